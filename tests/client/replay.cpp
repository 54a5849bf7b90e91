// SPDX-License-Identifier: GPL-3.0-or-later
// The acus-replay program against a scripted peer: what it writes, prints and returns.
#include <doctest/doctest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "protocol/codec.h"
#include "tests/client/mock_server.h"
#include "tests/client/recorded_messages.h"
#include "tests/support/file_content.h"
#include "tests/support/places.h"

using acus::content_of;
using acus::test::MockScript;
using acus::test::MockServer;
using acus::test::read_messages;
using namespace acus::protocol;

namespace {

struct Outcome {
  int status = -1;
  std::string output;  // stdout and stderr
};

// A folder with a short trajectory (0.2 s, one needle), gone with the test.
class Workplace {
 public:
  Workplace() : folder_(std::filesystem::temp_directory_path() / ("acus_replay_" + std::to_string(::getpid()))) {
    std::filesystem::create_directories(folder_);
    std::ofstream(path("motion.csv")) << "t,needle,x,y,z,qw,qx,qy,qz,spin\n"
                                         "0,needle,0,0,0,1,0,0,0,0\n"
                                         "0.2,needle,0,0,-0.05,1,0,0,0,1\n";
  }
  ~Workplace() { std::filesystem::remove_all(folder_); }
  Workplace(const Workplace&) = delete;
  Workplace& operator=(const Workplace&) = delete;

  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  void write(const std::string& name, const std::string& text) const { std::ofstream(path(name)) << text; }

  std::string read(const std::string& name) const { return content_of(path(name)); }

  Outcome replay(const MockServer& server, const std::string& arguments = "", const std::string& motion = "motion.csv",
                 double timeout_s = 20) const {
    const std::string command = "timeout 100 " + acus::program_path("acus-replay") + " '" + path(motion) +
                                "' --commands " + server.commands() + " --states " + server.states() + " --timeout " +
                                std::to_string(timeout_s) + " " + arguments + " 2>&1";
    Outcome outcome;
    FILE* pipe = popen(command.c_str(), "r");
    REQUIRE(pipe != nullptr);
    std::array<char, 4096> buffer{};
    while (const std::size_t count = std::fread(buffer.data(), 1, buffer.size(), pipe)) {
      outcome.output.append(buffer.data(), count);
    }
    const int status = pclose(pipe);
    outcome.status = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    return outcome;
  }

 private:
  std::filesystem::path folder_;
};

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

// The numbers of a column of CSV without quotes.
std::vector<double> column(const std::string& csv, const std::string& name) {
  std::istringstream lines(csv);
  std::string line, cell;
  std::getline(lines, line);
  std::istringstream header(line);
  int place = 0;
  while (std::getline(header, cell, ',') && cell != name) ++place;
  REQUIRE(cell == name);
  std::vector<double> numbers;
  while (std::getline(lines, line)) {
    std::istringstream cells(line);
    for (int i = 0; i <= place; ++i) std::getline(cells, cell, ',');
    numbers.push_back(std::stod(cell));
  }
  return numbers;
}

MockScript lockstep_script() {
  MockScript script;
  script.lockstep = true;
  return script;
}

}  // namespace

TEST_CASE("a replay in real time sends its poses, writes its states, shuts the server down and returns 0" *
          doctest::test_suite("gate")) {
  const Workplace here;
  MockServer server;
  const auto outcome = here.replay(server, "--shutdown --out " + here.path("run.csv"));
  INFO(outcome.output);
  CHECK(outcome.status == 0);
  CHECK(contains(outcome.output, ", 0 lost"));
  CHECK(contains(outcome.output, "deepest 50.0 mm; peak axial resistance 0.050 N going in"));
  CHECK(contains(here.read("run.csv"), ",received_s\n"));
  CHECK(contains(here.read("run.events.csv"), ",puncture,"));
  CHECK(server.poses() > 0);
}

TEST_CASE("poses leave at the rate that was asked for, numbered after those of the last client" *
          doctest::test_suite("gate")) {
  const Workplace here;
  MockScript script;
  script.first_seq = 700;
  MockServer server(script);
  const auto outcome = here.replay(server, "--rate 10 --out " + here.path("run.csv"));
  INFO(outcome.output);
  CHECK(outcome.status == 0);
  CHECK(server.poses() <= 3);  // at 0, 0.1 and 0.2 s; a busy machine skips some
  CHECK(contains(here.read("run.csv"), ",needle,703,"));
}

TEST_CASE("a replay in lockstep sends one pose per tick, twice with the same bytes" * doctest::test_suite("gate")) {
  const Workplace here;
  for (const char* name : {"a.csv", "b.csv"}) {
    MockServer server(lockstep_script());
    const auto outcome = here.replay(server, "--lockstep --shutdown --out " + here.path(name));
    INFO(outcome.output);
    CHECK(outcome.status == 0);
    CHECK(server.poses() == 41);  // 0.2 s at 200 Hz, both ends included
    CHECK(server.ticks() == 42);  // and one before the first pose
  }
  CHECK(here.read("a.csv") == here.read("b.csv"));
  CHECK(here.read("a.events.csv") == here.read("b.events.csv"));
}

TEST_CASE("passes go forth and back without a jump" * doctest::test_suite("gate")) {
  const Workplace here;
  MockServer server(lockstep_script());
  const auto outcome = here.replay(server, "--lockstep --passes 3 --out " + here.path("run.csv"));
  INFO(outcome.output);
  CHECK(outcome.status == 0);
  CHECK(server.poses() == 121);  // 0.6 s at 200 Hz
  const std::vector<double> depths = column(here.read("run.csv"), "depth_m");
  REQUIRE(depths.size() == 122);
  for (std::size_t i = 1; i < depths.size(); ++i) CHECK(std::abs(depths[i] - depths[i - 1]) < 1.01 * 0.05 / 40);
  CHECK(depths[41] == doctest::Approx(0.05));
  CHECK(depths[81] == doctest::Approx(0));
  CHECK(depths[121] == doctest::Approx(0.05));
}

TEST_CASE("the timing of a run is recorded: a row per pose that was used, and one per statistics" *
          doctest::test_suite("gate")) {
  const Workplace here;
  MockServer server;
  const auto outcome = here.replay(server, "--passes 2 --timing " + here.path("timing.csv"));
  INFO(outcome.output);
  CHECK(outcome.status == 0);
  CHECK(contains(outcome.output, "round trip  p50"));
  const std::vector<double> numbers = column(here.read("timing.csv"), "seq");
  const std::vector<double> trips = column(here.read("timing.csv"), "round_trip_s");
  REQUIRE(!numbers.empty());
  CHECK(numbers.size() <= server.poses());
  CHECK(numbers.back() <= static_cast<double>(server.poses()));
  CHECK(trips.size() == numbers.size());
  for (const double trip : trips) CHECK(trip > 0);
  CHECK(column(here.read("timing.stats.csv"), "late").size() >= 2);
}

TEST_CASE("shapes are recorded as they come, none is missing in lockstep, and they read back" *
          doctest::test_suite("gate")) {
  const Workplace here;
  MockServer server(lockstep_script());
  const auto outcome = here.replay(server, "--lockstep --shapes " + here.path("run.shapes"));
  INFO(outcome.output);
  CHECK(outcome.status == 0);
  CHECK(contains(outcome.output, "run.shapes, 8 shapes, 0 lost"));
  const std::vector<std::string> messages = read_messages(here.path("run.shapes"));
  REQUIRE(messages.size() == 10);  // two replies, then a tissue and a needle at ticks 10, 20, 30 and 40 of 42
  CHECK(std::get<HelloReply>(decode_reply(messages[0])).scene == "mock scene");
  CHECK(std::get<DescribeReply>(decode_reply(messages[1])).regions == std::vector<std::string>{"tissue"});
  for (std::uint64_t i = 0; i < 4; ++i) {
    const auto tissue = std::get<TissueShape>(decode_state(messages[2 + 2 * i]));
    const auto needle = std::get<NeedleShape>(decode_state(messages[3 + 2 * i]));
    CHECK(tissue.tick == 10 * (i + 1));
    CHECK(tissue.positions == std::vector<float>{0, 0, static_cast<float>(tissue.tick)});
    CHECK(tissue.path_points == std::vector<float>{1, 2, 3});
    CHECK(tissue.path_sizes == std::vector<std::int32_t>{1});
    CHECK(needle.tick == tissue.tick);
  }
}

TEST_CASE("poses of guides are recorded with the shapes, and carry no spin" * doctest::test_suite("gate")) {
  const Workplace here;
  here.write("guided.csv",
             "t,needle,x,y,z,qw,qx,qy,qz,spin\n"
             "0,collar,0,0,0,1,0,0,0,0\n"
             "0.2,collar,0,0,-0.04,1,0,0,0,0\n");
  MockScript script = lockstep_script();
  script.guides = {"collar"};
  MockServer server(script);
  const auto outcome = here.replay(server, "--lockstep --shapes " + here.path("run.shapes"), "guided.csv");
  INFO(outcome.output);
  CHECK(outcome.status == 0);
  const std::vector<std::string> messages = read_messages(here.path("run.shapes"));
  REQUIRE(messages.size() == 2 + 4 * 3);
  const auto pose = std::get<Pose>(decode_command(messages[2]));  // before the tissue of tick 10: eight poses later
  CHECK(pose.needle == "collar");
  CHECK(pose.position[2] == doctest::Approx(-0.04 * 8 / 40));
  CHECK_FALSE(pose.spin.has_value());
}

TEST_CASE("a trajectory that spins a guide is refused" * doctest::test_suite("gate")) {
  const Workplace here;
  MockScript script;
  script.needles = {"other"};
  script.guides = {"needle"};
  MockServer server(script);
  const auto outcome = here.replay(server);
  CHECK(outcome.status == 1);
  CHECK(contains(outcome.output, "spins 'needle', which is a guide"));
}

TEST_CASE("lost shapes return 4 and are counted" * doctest::test_suite("gate")) {
  const Workplace here;
  MockScript script;
  script.loses_shapes = true;
  MockServer server(script);
  const auto outcome = here.replay(server, "--shapes " + here.path("run.shapes"));
  INFO(outcome.output);
  CHECK(outcome.status == 4);
  CHECK_FALSE(contains(outcome.output, "shapes, 0 lost"));
}

TEST_CASE("a slower pose rate holds in lockstep, too" * doctest::test_suite("gate")) {
  const Workplace here;
  MockServer server(lockstep_script());
  const auto outcome = here.replay(server, "--lockstep --rate 50");
  INFO(outcome.output);
  CHECK(outcome.status == 0);
  CHECK(server.poses() == 11);
}

TEST_CASE("a server that comes later is waited for, a paused one is resumed" * doctest::test_suite("gate")) {
  const Workplace here;
  MockScript script;
  script.paused = true;
  MockServer server(script, 500);
  const auto outcome = here.replay(server);
  INFO(outcome.output);
  CHECK(outcome.status == 0);
}

TEST_CASE("a server that falls far behind its rate is driven all the same" * doctest::test_suite("gate")) {
  const Workplace here;
  MockScript script;
  script.rate = 5000;
  script.pace = 0.004;
  MockServer server(script);
  const auto outcome = here.replay(server, "--rate 100");  // 0.1 s of states take longer than its timeout
  INFO(outcome.output);
  CHECK(outcome.status == 0);
}

TEST_CASE("a trajectory for another scene is refused with the names of the needles" * doctest::test_suite("gate")) {
  const Workplace here;
  MockScript script;
  script.needles = {"left", "right"};
  MockServer server(script);
  const auto outcome = here.replay(server);
  CHECK(outcome.status == 1);
  CHECK(contains(outcome.output, "moves needle 'needle', but scene 'mock scene' has 'left', 'right'"));
}

TEST_CASE("a run that is refused leaves the recording of the one before, and no empty file" *
          doctest::test_suite("gate")) {
  const Workplace here;
  MockServer earlier;
  REQUIRE(here.replay(earlier, "--out '" + here.path("run.csv") + "'").status == 0);
  const std::string before = here.read("run.csv");
  std::filesystem::remove(here.path("run.events.csv"));
  MockScript script;
  script.needles = {"left", "right"};
  MockServer server(script);
  const auto outcome =
      here.replay(server, "--out '" + here.path("run.csv") + "' --timing '" + here.path("t.csv") + "'");
  CHECK(outcome.status == 1);
  CHECK_FALSE(contains(outcome.output, "written"));
  CHECK(here.read("run.csv") == before);
  CHECK_FALSE(std::filesystem::exists(here.path("run.events.csv")));
  CHECK_FALSE(std::filesystem::exists(here.path("t.csv")));
}

TEST_CASE("a run replaces the files of one before, and none of anybody else" * doctest::test_suite("gate")) {
  const Workplace here;
  const std::string options = "--out '" + here.path("run.csv") + "' --shapes '" + here.path("run.shapes") +
                              "' --timing '" + here.path("t.csv") + "' --summary '" + here.path("run.json") + "'";
  for (int run = 0; run < 2; ++run) {
    MockServer server;
    const auto outcome = here.replay(server, options);
    INFO(outcome.output);
    CHECK(outcome.status == 0);
  }
  MockServer server;
  for (const char* name : {"run.csv", "run.events.csv", "run.shapes", "t.csv", "t.stats.csv", "run.json"}) {
    const std::string before = here.read(name);
    here.write(name, "my own notes\n");
    const auto outcome = here.replay(server, options);
    CHECK(outcome.status == 1);
    CHECK(
        contains(outcome.output, here.path(name) + ": something else stands there, which would be lost; give another"));
    CHECK(here.read(name) == "my own notes\n");
    here.write(name, before);
  }
}

TEST_CASE("a run that ends before any statistics leaves their header, one of no event that of the events" *
          doctest::test_suite("gate")) {
  const Workplace here;
  MockServer server;
  const auto outcome =
      here.replay(server, "--out '" + here.path("run.csv") + "' --timing '" + here.path("t.csv") + "'");
  INFO(outcome.output);
  CHECK(outcome.status == 0);
  CHECK(contains(here.read("t.stats.csv"), "received_s,"));
  CHECK(contains(here.read("run.events.csv"), "kind"));
}

TEST_CASE("a recording may go where a link points that leads nowhere yet, and the link stays" *
          doctest::test_suite("gate")) {
  const Workplace here;
  std::filesystem::create_symlink(here.path("nowhere.csv"), here.path("run.csv"));
  MockScript script;
  script.needles = {"left", "right"};
  MockServer server(script);
  CHECK(here.replay(server, "--out '" + here.path("run.csv") + "'").status == 1);
  CHECK(std::filesystem::is_symlink(here.path("run.csv")));
}

TEST_CASE("the clock modes of both sides must agree" * doctest::test_suite("gate")) {
  const Workplace here;
  MockServer real_time;
  CHECK(here.replay(real_time, "--lockstep").status == 1);
  MockServer lockstep(lockstep_script());
  CHECK(here.replay(lockstep).status == 1);
}

TEST_CASE("bad arguments and files return 1" * doctest::test_suite("gate")) {
  const Workplace here;
  MockServer server;
  CHECK(here.replay(server, "--nonsense").status == 1);
  CHECK(here.replay(server, "", "missing.csv").status == 1);
  CHECK(here.replay(server, "--out /nowhere/run.csv").status == 1);
  CHECK(here.replay(server, "--shapes /nowhere/run.shapes").status == 1);
  CHECK(here.replay(server, "--timing /nowhere/timing.csv").status == 1);
}

TEST_CASE("two results in one file, and the timing of a run in lockstep, are refused before anything is written" *
          doctest::test_suite("gate")) {
  const Workplace here;
  MockServer server;
  here.write("run.csv", "kept");
  const auto same = here.replay(server, "--out " + here.path("run.csv") + " --timing " + here.path("./run.csv"));
  CHECK(same.status == 1);
  CHECK(contains(same.output, "--out and --timing name the same file"));
  CHECK(here.read("run.csv") == "kept");
  CHECK(here.replay(server, "--lockstep --timing " + here.path("run.csv")).status == 1);
  CHECK(here.read("run.csv") == "kept");
}

TEST_CASE("a result in the place of the trajectory is refused, by whatever name" * doctest::test_suite("gate")) {
  const Workplace here;
  MockServer server;
  const std::string motion = here.read("motion.csv");
  std::filesystem::create_symlink("motion.csv", here.path("link.csv"));
  std::filesystem::create_hard_link(here.path("motion.csv"), here.path("hard.csv"));
  std::filesystem::create_directory(here.path("folder"));
  for (const std::string name : {"motion.csv", "./motion.csv", "folder/../motion.csv", "link.csv", "hard.csv"}) {
    for (const std::string option : {"--out", "--shapes", "--timing"}) {
      const auto outcome = here.replay(server, option + " " + here.path(name));
      INFO(outcome.output);
      CHECK(outcome.status == 1);
      CHECK(contains(outcome.output, option + " would overwrite the trajectory"));
    }
  }
  CHECK(here.read("motion.csv") == motion);

  for (const auto& [option, name] : {std::pair{"--out", "run.events.csv"}, {"--timing", "run.stats.csv"}}) {
    std::filesystem::copy(here.path("motion.csv"), here.path(name));
    const auto outcome = here.replay(server, std::string(option) + " " + here.path("run.csv"), name);
    INFO(outcome.output);
    CHECK(outcome.status == 1);
    CHECK(contains(outcome.output, "would overwrite the trajectory"));
    CHECK(here.read(name) == motion);
    CHECK_FALSE(std::filesystem::exists(here.path("run.csv")));
  }
}

TEST_CASE("two results in one file are refused, also those beside them and by other names" *
          doctest::test_suite("gate")) {
  const Workplace here;
  MockServer server;
  std::filesystem::create_symlink("run.csv", here.path("dangling.csv"));
  for (const std::string& arguments : {"--out " + here.path("run.csv") + " --shapes " + here.path("run.events.csv"),
                                       "--out " + here.path("run.csv") + " --timing " + here.path("run.events.csv"),
                                       "--shapes " + here.path("run.stats.csv") + " --timing " + here.path("run.csv"),
                                       "--out " + here.path("run.csv") + " --shapes " + here.path("dangling.csv")}) {
    const auto outcome = here.replay(server, arguments);
    INFO(outcome.output);
    CHECK(outcome.status == 1);
    CHECK(contains(outcome.output, "name the same file"));
    CHECK_FALSE(std::filesystem::exists(here.path("run.csv")));
  }
}

TEST_CASE("a server that rejects poses returns 2" * doctest::test_suite("gate")) {
  const Workplace here;
  for (const bool lockstep : {false, true}) {
    MockScript script;
    script.lockstep = lockstep;
    script.rejects_poses = true;
    MockServer server(script);
    const auto outcome = here.replay(server, lockstep ? "--lockstep" : "");
    INFO(outcome.output);
    CHECK(outcome.status == 2);
    CHECK(contains(outcome.output, "refused 'pose' (bad_value)"));
  }
}

TEST_CASE("a server that is not there, says nothing, or ends in the middle returns 3" * doctest::test_suite("gate")) {
  const Workplace here;
  MockScript mute;
  mute.mute = true;
  MockServer silent(mute);
  CHECK(here.replay(silent, "", "motion.csv", 0.3).status == 3);

  for (const bool lockstep : {false, true}) {
    MockScript script;
    script.lockstep = lockstep;
    script.last_tick = 20;
    MockServer server(script);
    const auto outcome =
        here.replay(server, (lockstep ? "--lockstep --out " : "--out ") + here.path("run.csv"), "motion.csv", 1);
    INFO(outcome.output);
    CHECK(outcome.status == 3);
    if (lockstep) CHECK(contains(here.read("run.csv"), "\n1,19,"));  // what came until then is kept
  }
}

TEST_CASE("a world that starts anew in the middle returns 3" * doctest::test_suite("gate")) {
  const Workplace here;
  MockScript script;
  script.lockstep = true;
  script.reset_tick = 20;
  MockServer server(script);
  const auto outcome = here.replay(server, "--lockstep");
  INFO(outcome.output);
  CHECK(outcome.status == 3);
  CHECK(contains(outcome.output, "the world of this run is gone"));
}

TEST_CASE("lost states return 4 and are counted" * doctest::test_suite("gate")) {
  const Workplace here;
  MockScript script;
  script.lossy_pose = 3;
  MockServer server(script);
  const auto outcome = here.replay(server);
  INFO(outcome.output);
  CHECK(outcome.status == 4);
  CHECK(contains(outcome.output, ", 1 lost"));
}

TEST_CASE("a limit on the timing decides over the exit status, and the summary tells what was measured" *
          doctest::test_suite("gate")) {
  const Workplace here;
  MockServer server;
  const std::string summary = here.path("summary.json");
  const auto missed = here.replay(server, "--max-p99-ms 0 --max-late-per-1000 1000 --summary " + summary);
  INFO(missed.output);
  CHECK(missed.status == 7);
  CHECK(contains(missed.output, "acus-replay: --max-p99-ms 0 was exceeded: "));
  CHECK(!contains(missed.output, "--max-late-per-1000 1000 was"));
  const std::string json = here.read("summary.json");
  for (const char* text : {"\"scene\": \"mock scene\"", "\"round_trip_p99_ms\": ", "\"states_lost\": 0",
                           "\"option\": \"--max-p99-ms\"", "\"held\": false"})
    CHECK_MESSAGE(contains(json, text), text);
  CHECK(here.replay(server, "--max-ms 60000").status == 0);
  CHECK(here.replay(server, "--lockstep --max-ms 1").status == 1);
  CHECK(here.replay(server, "--summary " + here.path("motion.csv")).status == 1);
}

TEST_CASE("another version of the protocol returns 5" * doctest::test_suite("gate")) {
  const Workplace here;
  MockScript script;
  script.version = 1;
  MockServer server(script);
  CHECK(here.replay(server).status == 5);
}
