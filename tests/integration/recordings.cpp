// SPDX-License-Identifier: GPL-3.0-or-later
// Recordings of real servers: what is left of them whatever ends the server, and what is refused.
#include <doctest/doctest.h>
#include <sys/resource.h>
#include <sys/wait.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <thread>

#include "tests/integration/printed.h"
#include "tests/support/file_content.h"
#include "tests/support/places.h"

namespace acus::testing {
namespace {

// A file that lives as long as this.
class Output {
 public:
  explicit Output(const std::string& path) : file_(std::fopen(path.c_str(), "w")), path_(path) {}
  ~Output() { std::fclose(file_); }
  int file() const { return fileno(file_); }
  std::string text() const { return content_of(path_); }

 private:
  std::FILE* file_;
  std::string path_;
};

struct Rerun {
  std::optional<int> status;
  std::string printed;

  bool says(const std::string& words) const { return printed.find(words) != std::string::npos; }
};

Rerun rerun(const TemporaryFolder& folder, const std::string& recording, const std::string& program = "acus-export") {
  const Output output(folder / "printed");
  Process process({program_path(program), recording}, output.file());
  const std::optional<int> status = process.wait(kPatience);
  return {status, output.text()};
}

// Sends a pose for each of so many states.
void push(client::CommandLink& commands, client::StateLink& states, int ticks, std::uint64_t from = 0) {
  for (std::uint64_t i = from + 1; i <= from + static_cast<std::uint64_t>(ticks); ++i) {
    REQUIRE(commands.send(pose_at(0.5 - 1e-4 * static_cast<double>(i), i)));
    receive<protocol::Force>(states);
  }
}

// The same in lockstep, each pose with a tick.
void step_down(client::CommandLink& commands, std::uint64_t from, std::uint64_t ticks) {
  for (std::uint64_t i = from + 1; i <= from + ticks; ++i) {
    REQUIRE(commands.send(pose_at(0.5 - 1e-4 * static_cast<double>(i), i)));
    commands.step(1, kPatience);
  }
}

std::string refusal(client::CommandLink& commands, const std::string& file) {
  try {
    commands.record(file, kPatience);
    return "accepted";
  } catch (const client::Refused& refused) {
    return std::string(name_of(refused.error.code)) + ": " + refused.error.message;
  }
}

}  // namespace

TEST_CASE("a session in real time is run again to the last bit") {
  ServerProcess server;
  const std::string file = server.folder() / "run.acus";
  ServerProcess recorded({"--record", file});
  client::CommandLink commands = hold(recorded);
  CHECK(commands.hello(kPatience).recording == "run.acus");
  client::StateLink states = subscribe(recorded, {"force"});
  push(commands, states, 60);
  commands.reset(kPatience);
  push(commands, states, 20, 60);
  recorded.process().send_signal(SIGTERM);
  CHECK(recorded.process().wait(kPatience) == 0);
  const Rerun again = rerun(server.folder(), file);
  CHECK(again.status == 0);
  CHECK(again.says("the same to the last bit"));
  CHECK(!again.says("its end"));
  CHECK(rerun(server.folder(), file, "acus-replay").says("the same to the last bit"));
  const std::string csv = server.folder() / "run.csv";
  CHECK(Process({program_path("acus-replay"), file, "--out", csv}).wait(kPatience) == 1);
  CHECK(!std::filesystem::exists(csv));
}

TEST_CASE("what was recorded a second before the server is killed is run again") {
  const TemporaryFolder folder;
  ServerProcess server({"--record", folder / "run"});
  client::CommandLink commands = hold(server);
  client::StateLink states = subscribe(server, {"force"});
  push(commands, states, 20);
  const std::uint64_t tick = receive<protocol::Stats>(states).tick;
  for (;;) {  // the server's own clock
    const auto force = receive<protocol::Force>(states);
    if (force.time > static_cast<double>(tick) / 200 + 1.0) break;
  }
  // Half a second at most, but for a machine that stands still.
  const auto size = std::filesystem::file_size(folder / "run");
  const auto deadline = std::chrono::steady_clock::now() + kPatience;
  while (std::filesystem::file_size(folder / "run") == size && std::chrono::steady_clock::now() < deadline)
    std::this_thread::sleep_for(10ms);
  server.process().send_signal(SIGKILL);
  CHECK(server.process().wait(kPatience) == -SIGKILL);
  const Rerun again = rerun(folder, folder / "run");
  CHECK(again.status == 0);
  CHECK(again.says("the same to the last bit"));
  CHECK(again.says("it was not ended"));
  const std::size_t at = again.printed.find("run again   ");
  REQUIRE(at != std::string::npos);
  CHECK(std::stoull(again.printed.substr(at + 12)) >= tick);
}

TEST_CASE("clients begin and end recordings in the server's folder, under plain new names") {
  ServerProcess other;
  const std::string runs = other.folder() / "runs";
  std::filesystem::create_directory(runs);
  ServerProcess server({"--lockstep", "--recordings", runs});
  client::CommandLink commands = hold(server);
  commands.step(5, kPatience);
  CHECK_THROWS_AS(commands.end_recording(kPatience), client::Refused);
  for (const char* name : {"", "../run", "a/b", "/tmp/run", ".hidden", "-x", "a\n", "\xff"}) {
    CAPTURE(name);
    CHECK(refusal(commands, name).starts_with("record_error: field 'file' must be a name"));
  }
  CHECK(std::filesystem::is_empty(runs));
  CHECK(commands.record("first.acus", kPatience).tick == 5);
  CHECK(commands.hello(kPatience).recording == "first.acus");
  CHECK(refusal(commands, "second.acus").starts_with("record_error: 'first.acus' is being recorded"));
  CHECK(commands.send(pose_at(0.45, 1)));
  commands.step(300, kPatience);
  commands.end_recording(kPatience);
  const std::uintmax_t whole = std::filesystem::file_size(runs + "/first.acus");
  CHECK(!commands.hello(kPatience).recording);
  commands.step(5, kPatience);
  CHECK(refusal(commands, "first.acus").find("there is a file of this name already") != std::string::npos);
  CHECK(refusal(commands, "second.acus") == "accepted");
  commands.step(3, kPatience);
  commands.shutdown(kPatience);
  CHECK(server.process().wait(kPatience) == 0);
  CHECK(std::filesystem::file_size(runs + "/first.acus") == whole);  // it was closed when its end was answered
  const Rerun first = rerun(server.folder(), runs + "/first.acus");
  CHECK(first.status == 0);
  CHECK(first.says("run again   300 ticks"));
  CHECK(rerun(server.folder(), runs + "/second.acus").says("run again   3 ticks"));
}

TEST_CASE("a server without a folder for recordings keeps none for clients") {
  ServerProcess server({"--lockstep"});
  client::CommandLink commands(server.commands());
  CHECK(refusal(commands, "run").find("start it with --recordings FOLDER") != std::string::npos);
}

TEST_CASE("a server that cannot record what it shall does not start") {
  const TemporaryFolder folder;
  const std::string there = folder.write("there", "precious");
  ServerProcess server({"--record", there});
  CHECK(server.process().wait(kPatience) == 5);
  CHECK(std::filesystem::file_size(there) == 8);
  ServerProcess nowhere({"--record", folder / "none/run"});
  CHECK(nowhere.process().wait(kPatience) == 5);
}

TEST_CASE("a recording whose file was removed is not said to be done") {
  const TemporaryFolder folder;
  ServerProcess server({"--lockstep", "--recordings", folder / ""});
  client::CommandLink commands = hold(server);
  commands.record("run", kPatience);
  commands.step(5, kPatience);
  std::filesystem::remove(folder / "run");
  commands.step(5, kPatience);
  CHECK_THROWS_WITH_AS(commands.end_recording(kPatience), doctest::Contains("ended by itself"), client::Refused);
  CHECK(refusal(commands, "run") == "accepted");
  commands.step(5, kPatience);
  commands.end_recording(kPatience);
  CHECK(rerun(folder, folder / "run").says("run again   5 ticks"));
}

TEST_CASE("when the disk is full the recording ends, and the simulation goes on") {
  const TemporaryFolder folder;
  ServerProcess server({"--lockstep", "--record", folder / "run"});
  client::CommandLink commands = hold(server);
  client::StateLink states = subscribe(server, {"force"});
  commands.step(50, kPatience);
  const auto size = [&] { return std::filesystem::file_size(folder / "run"); };
  while (size() < 1000) std::this_thread::sleep_for(10ms);  // the beginning is there
  std::string command = "prlimit --fsize=" + std::to_string(size() + 100) + " --pid ";
  REQUIRE(std::system((command + std::to_string(server.process().id())).c_str()) == 0);
  protocol::RecordingState state = protocol::RecordingState::on;
  for (std::uint64_t i = 1; state == protocol::RecordingState::on; ++i) {
    REQUIRE(commands.send(pose_at(0.5 - 1e-6 * static_cast<double>(i), i)));
    commands.step(1, kPatience);
    while (const auto received = states.receive(0ms))
      if (const auto* stats = std::get_if<protocol::Stats>(&*received)) state = stats->recording;
  }
  CHECK(state == protocol::RecordingState::failed);
  CHECK(!commands.hello(kPatience).recording);
  CHECK_THROWS_WITH_AS(commands.end_recording(kPatience), doctest::Contains("ended by itself"), client::Refused);
  commands.step(5, kPatience);
  commands.shutdown(kPatience);
  CHECK(server.process().wait(kPatience) == 0);
  const Rerun again = rerun(folder, folder / "run");
  CHECK(again.status == 0);
  CHECK(again.says("the same to the last bit"));
  // Nor is a recording overwritten by what is made of it, or a damaged one taken for a whole one.
  std::filesystem::copy_file(folder / "run", folder / "copy.events.csv");
  CHECK(Process({program_path("acus-export"), folder / "run", "--csv", folder / "run"}).wait(kPatience) == 3);
  CHECK(Process({program_path("acus-export"), folder / "copy.events.csv", "--csv", folder / "copy.csv"})
            .wait(kPatience) == 3);
  std::ofstream(folder / "run", std::ios::app) << "more";
  CHECK(rerun(folder, folder / "run").status == 5);
}

TEST_CASE("a server whose recording ended by itself says so when it ends") {
  const TemporaryFolder folder;
  ServerProcess server({"--lockstep", "--record", folder / "run"});
  client::CommandLink commands(server.commands());
  client::StateLink states = subscribe(server, {});
  const std::string command = "prlimit --fsize=1000 --pid " + std::to_string(server.process().id());
  REQUIRE(std::system(command.c_str()) == 0);
  while (receive<protocol::Stats>(states).recording == protocol::RecordingState::on) commands.step(500, kPatience);
  commands.shutdown(kPatience);
  CHECK(server.process().wait(kPatience) == 5);
}

TEST_CASE("a server that cannot bring the last of its recording to the disk says so when it ends") {
  const TemporaryFolder folder;
  ServerProcess server({"--lockstep", "--record", folder / "run"});
  client::CommandLink commands(server.commands());
  commands.hello(kPatience);
  const auto size = [&] { return std::filesystem::file_size(folder / "run"); };
  const auto before = size();
  commands.step(1, kPatience);
  while (size() == before) std::this_thread::sleep_for(10ms);
  const std::string command = "prlimit --fsize=" + std::to_string(size()) + " --pid ";
  REQUIRE(std::system((command + std::to_string(server.process().id())).c_str()) == 0);
  commands.step(1, kPatience);
  commands.shutdown(kPatience);  // before the next half second
  CHECK(server.process().wait(kPatience) == 5);
}

TEST_CASE("a server goes on from a moment of a recording, bit by bit, and its own run is recorded from there") {
  const TemporaryFolder folder;
  const std::string first = folder / "first", second = folder / "second";
  ServerProcess recorded({"--lockstep", "--record", first});
  client::CommandLink commands = hold(recorded);
  step_down(commands, 0, 20);
  const protocol::HashReply middle = commands.hash(kPatience);
  step_down(commands, 20, 20);
  const protocol::HashReply end = commands.hash(kPatience);
  commands.shutdown(kPatience);
  CHECK(recorded.process().wait(kPatience) == 0);

  ServerProcess from_middle({"--lockstep", "--at", "0.1", "--record", second}, content_of(first));  // 200 Hz
  client::CommandLink others = hold(from_middle);
  const protocol::HashReply there = others.hash(kPatience);
  CHECK(there.hash == middle.hash);
  CHECK(there.tick == 20);
  CHECK(there.epoch == 0);
  step_down(others, 20, 20);
  CHECK(others.hash(kPatience).hash == end.hash);
  others.shutdown(kPatience);
  CHECK(from_middle.process().wait(kPatience) == 0);
  CHECK(rerun(folder, second).says("run again   20 ticks"));

  ServerProcess from_end({"--lockstep"}, content_of(second));
  client::CommandLink again(from_end.commands());
  CHECK(again.hash(kPatience).hash == end.hash);
  CHECK(again.hash(kPatience).tick == 40);
}

namespace {

// A run of 20 ticks in which the needle goes down.
void record_steps(const std::string& file) {
  ServerProcess recorded({"--lockstep", "--record", file});
  client::CommandLink commands = hold(recorded);
  step_down(commands, 0, 20);
  commands.shutdown(kPatience);
  CHECK(recorded.process().wait(kPatience) == 0);
}

}  // namespace

TEST_CASE("in real time a server goes on from a recording, and its needles rest where they were going") {
  const TemporaryFolder folder;
  record_steps(folder / "run");
  ServerProcess server({}, content_of(folder / "run"));
  client::StateLink states = subscribe(server, {"force"});
  protocol::Force force;
  do force = receive<protocol::Force>(states);
  while (force.tick < 220);  // a second later
  CHECK(force.epoch == 0);
  CHECK(force.base_position[2] == doctest::Approx(0.5 - 20e-4));
}

TEST_CASE("a server that begins paused rests at its moment until it is resumed, and a needle can be taken before") {
  const TemporaryFolder folder;
  record_steps(folder / "run");
  ServerProcess server({"--paused"}, content_of(folder / "run"));
  client::CommandLink others = hold(server);
  CHECK(others.hello(kPatience).paused);
  const protocol::HashReply first = others.hash(kPatience), second = others.hash(kPatience);
  CHECK(first.tick == 20);
  CHECK(second.tick == 20);
  CHECK(second.hash == first.hash);
  client::StateLink states = subscribe(server, {"force"});
  others.resume(kPatience);
  CHECK(receive<protocol::Force>(states).tick == 21);
  CHECK_FALSE(others.hello(kPatience).paused);
  CHECK(ServerProcess({"--paused", "--lockstep"}).process().wait(kPatience) == 1);
}

TEST_CASE("options that do not go with a recording, or without one, and recordings that cannot be used, are refused") {
  const TemporaryFolder folder;
  ServerProcess recorded({"--lockstep", "--record", folder / "run"});
  client::CommandLink commands(recorded.commands());
  commands.step(20, kPatience);
  commands.shutdown(kPatience);
  CHECK(recorded.process().wait(kPatience) == 0);
  const std::string run = content_of(folder / "run"), damaged = run.substr(0, run.size() - 1);
  const auto status = [](const std::vector<std::string>& options, const std::string& scene) {
    return ServerProcess(options, scene).process().wait(kPatience);
  };
  CHECK(status({"--at", "0"}, small_scene("small")) == 1);
  CHECK(status({"--restore", folder / "run"}, run) == 1);
  CHECK(status({"--rate", "100"}, run) == 1);
  for (const char* at : {"-1", "nan", "inf", "soon"}) CHECK(status({"--at", at}, run) == 1);
  CHECK(status({"--at", "0.2"}, run) == 2);
  CHECK(status({}, damaged) == 2);
  CHECK(status({}, run.substr(0, 10)) == 2);
  CHECK(status({"--check", "--at", "0.05"}, run) == 0);
}

TEST_CASE("a recording without a name is no recording") {
  ServerProcess server({"--record", ""});
  CHECK(server.process().wait(kPatience) == 1);
}

}  // namespace acus::testing
