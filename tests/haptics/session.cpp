// SPDX-License-Identifier: GPL-3.0-or-later
// acus-haptic with a real server: in lockstep the same run gives the same numbers; in real time it runs and ends.
#include <doctest/doctest.h>

#include <algorithm>
#include <csignal>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "tests/haptics/block_scene.h"
#include "tests/integration/server_process.h"
#include "tests/support/file_content.h"
#include "tests/support/places.h"

using namespace acus::testing;
using acus::content_of;

namespace {

// A column of a CSV file.
std::vector<double> column(const std::string& csv, const std::string& name) {
  std::istringstream lines(csv);
  std::string line, cell;
  std::getline(lines, line);
  int wanted = 0;
  std::istringstream header(line);
  while (std::getline(header, cell, ',') && cell != name) ++wanted;
  std::vector<double> values;
  while (std::getline(lines, line)) {
    std::istringstream row(line);
    for (int i = 0; i <= wanted; ++i) std::getline(row, cell, ',');
    values.push_back(std::stod(cell));
  }
  return values;
}

// A needle of which the tip is 5 mm above a block that it punctures at 0.3 N.
std::string scene() {
  return block_scene("{interaction: {puncture_force: 0.3, cutting_force: 0.1, pressure: 2000}}", 0.155, 500);
}

// Runs acus-haptic on it and returns its summary; its recording is in `record`.
nlohmann::json run(const std::vector<std::string>& server_options, const std::string& duration, std::string* record) {
  ServerProcess server(server_options, scene());
  const std::string csv = server.folder() / "run.csv", summary = server.folder() / "run.json";
  Process haptic({acus::program_path("acus-haptic"), "--commands", server.commands(), "--states", server.states(),
                  "--duration", duration, "--grip", "firm", "--hand-speed", "0.05", "--record", csv, "--summary",
                  summary, "--timeout", "60"});
  REQUIRE(haptic.wait(kPatience) == 0);
  if (record) *record = content_of(csv);
  return nlohmann::json::parse(content_of(summary));
}

}  // namespace

TEST_CASE("a session in lockstep inserts, feels, and is the same again") {
  std::string first, second;
  const auto summary = run({"--lockstep"}, "2.5", &first);
  run({"--lockstep"}, "2.5", &second);
  CHECK(first == second);
  CHECK(summary["lockstep"] == true);
  CHECK(summary["topic"] == "haptics");
  CHECK(summary["samples"] == 2501);
  CHECK(summary["states"] > 1000);
  CHECK(summary["largest_force_N"] > 0.2);
  CHECK(summary["largest_force_N"] < 1.0);
  CHECK(summary["coupling_N_per_m"] == doctest::Approx(1800));
  CHECK(summary["given_J"] < 0);  // the hand pushed
}

TEST_CASE("a second session begins where the first one left the needle") {
  ServerProcess server({"--lockstep"}, scene());
  std::vector<double> begins, ends;
  for (int session = 0; session < 2; ++session) {
    const std::string csv = server.folder() / "run.csv";
    Process haptic({acus::program_path("acus-haptic"), "--commands", server.commands(), "--states", server.states(),
                    "--duration", "0.9", "--hand-speed", "0.05", "--record", csv, "--timeout", "60"});
    REQUIRE(haptic.wait(kPatience) == 0);
    const std::vector<double> places = column(content_of(csv), "base_z_m");
    begins.push_back(places.front());
    ends.push_back(places.back());
  }
  CHECK(begins[0] == doctest::Approx(0.155));
  CHECK(ends[0] < 0.145);
  CHECK(begins[1] == doctest::Approx(ends[0]).epsilon(1e-3));
}

TEST_CASE("a session in real time ends after its duration" * doctest::test_suite("clock")) {
  const auto summary = run({}, "0.5", nullptr);
  CHECK(summary["lockstep"] == false);
  CHECK(summary["samples"] > 0);
  CHECK(summary["duration_s"] >= 0.5);
}

// A needle on bone, driven in lockstep over a simulated network; `more` are options of acus-haptic.
nlohmann::json press_bone(const std::vector<std::string>& more) {
  ServerProcess server(
      {"--lockstep"},
      block_scene("{material: {young_modulus: 10e6}, interaction: {puncture_force: .inf}}", 0.155, 1000));

  const std::string summary = server.folder() / "run.json";
  std::vector<std::string> command{acus::program_path("acus-haptic"),
                                   "--commands",
                                   server.commands(),
                                   "--states",
                                   server.states(),
                                   "--duration",
                                   "1.6",
                                   "--hand-depth",
                                   "0.015",
                                   "--hand-speed",
                                   "0.02",
                                   "--summary",
                                   summary,
                                   "--timeout",
                                   "60"};
  command.insert(command.end(), more.begin(), more.end());
  Process haptic(command);
  REQUIRE(haptic.wait(kPatience) == 0);
  return nlohmann::json::parse(content_of(summary));
}

TEST_CASE("bone is felt at the stiffness of the rule, over a late and lossy network too, and no energy is made") {
  for (const std::vector<std::string>& network : {std::vector<std::string>{},
                                                  {"--delay", "0.005"},
                                                  {"--delay", "0.01"},
                                                  {"--delay", "0.02"},
                                                  {"--delay", "0.02", "--jitter", "0.01", "--loss", "0.05"}}) {
    CAPTURE(network.size());
    const auto summary = press_bone(network);
    CHECK(summary["kit"] == true);
    CHECK(summary["felt_median_N_per_m"] > 900);  // of the 1,800 N/m that the rule allows
    CHECK(summary["given_J"] < 1e-3);
    CHECK(summary["withheld_J"] >= 0);
  }
  const auto plain = press_bone({"--no-kit", "--delay", "0.005"});
  CHECK(plain["kit"] == false);
  CHECK(plain["given_J"] > 1e-3);  // what the kit is for
  CHECK(plain["largest_force_N"] == doctest::Approx(10));
}

TEST_CASE("a hand that lets itself be pushed back by the tissue is paid from what it has put in") {
  ServerProcess server({"--lockstep"}, content_of(acus::source_path("scenes/insertion_pullback.yaml")));
  const std::string summary = server.folder() / "run.json";
  Process haptic({acus::program_path("acus-haptic"), "--commands", server.commands(), "--states", server.states(),
                  "--duration", "3.8", "--summary", summary, "--timeout", "60"});
  REQUIRE(haptic.wait(kPatience) == 0);
  const auto run = nlohmann::json::parse(content_of(summary));
  CHECK(run["largest_force_N"] == doctest::Approx(1).epsilon(0.02));  // the puncture
  CHECK(run["withheld_J"] < 1e-5);
  CHECK(run["rest_felt_N"].get<double>() == doctest::Approx(run["rest_server_N"].get<double>()).epsilon(0.01));
}

// A needle that two programs share in lockstep, the second one for so long. What both have recorded.
struct SharedRun {
  std::string teacher, pupil;
};
SharedRun share_needle(const std::string& pupil_duration, const std::vector<std::string>& network) {
  ServerProcess server({"--lockstep"}, scene());
  const std::string program = acus::program_path("acus-haptic"), endpoint = "ipc://" + (server.folder() / "share");
  const std::string first = server.folder() / "teacher.csv", second = server.folder() / "pupil.csv";
  std::vector<std::string> pupil_command{program,        "--join",     endpoint,      "--hand-speed", "0.05",
                                         "--hand-depth", "0.02",       "--grip",      "fingertips",   "--record",
                                         second,         "--duration", pupil_duration};
  pupil_command.insert(pupil_command.end(), network.begin(), network.end());
  Process pupil(pupil_command);
  Process teacher({program, "--commands", server.commands(), "--states", server.states(), "--share", endpoint,
                   "--hand-speed", "0.05", "--duration", "2", "--record", first, "--timeout", "60"});
  CHECK(pupil.wait(kPatience) == 0);
  CHECK(teacher.wait(kPatience) == 0);
  return {content_of(first), content_of(second)};
}

// J, that the force of a recording has done on the handle along x.
double work(const std::string& csv) {
  const std::vector<double> force = column(csv, "force_x_N"), place = column(csv, "device_x_m");
  double sum = 0;
  for (std::size_t i = 1; i < place.size(); ++i) sum += force[i - 1] * (place[i] - place[i - 1]);
  return sum;
}

TEST_CASE("a teacher and a pupil in two programs share a needle and its force, and neither gets energy") {
  for (const std::vector<std::string>& network :
       {std::vector<std::string>{}, {"--delay", "0.02", "--jitter", "0.01", "--loss", "0.05"}}) {
    const SharedRun run = share_needle("0", network);
    REQUIRE(std::ranges::count(run.pupil, '\n') > 1900);
    CHECK(run.teacher == share_needle("0", network).teacher);
    CHECK(column(run.pupil, "share").back() == doctest::Approx(0.5));
    CHECK(work(run.teacher) < 1e-6);
    CHECK(work(run.pupil) < 1e-6);
    const auto most = [](const std::string& csv) { return -std::ranges::min(column(csv, "force_x_N")); };
    CHECK(most(run.teacher) > 0.1);
    CHECK(most(run.pupil) > 0.05);
  }
}

TEST_CASE("a pupil that leaves gives its share back without a jump of the needle") {
  const std::vector<double> base = column(share_needle("1.1", {}).teacher, "base_z_m");
  double fastest = 0;
  for (std::size_t i = 1; i < base.size(); ++i) fastest = std::max(fastest, std::abs(base[i] - base[i - 1]));
  CHECK(fastest < 0.15e-3);  // the hand's 0.05 m/s, and what the share brings
}

TEST_CASE("a pupil without a teacher ends with 3, and a needle is shared on this machine alone") {
  const std::string program = acus::program_path("acus-haptic");
  Process alone({program, "--join", "ipc:///nowhere", "--timeout", "0.3"});
  CHECK(alone.wait(kPatience) == 3);
  Process open({program, "--join", "tcp://0.0.0.0:5799", "--timeout", "0.3"});
  CHECK(open.wait(kPatience) == 1);
  acus::TemporaryFolder folder;
  const std::string file = folder.write("notes", "to be kept");
  Process destructive({program, "--join", "ipc://" + file, "--timeout", "0.3"});
  CHECK(destructive.wait(kPatience) == 3);
  ServerProcess server({"--lockstep"}, scene());
  Process teacher({program, "--commands", server.commands(), "--states", server.states(), "--share", "ipc://" + file});
  CHECK(teacher.wait(kPatience) == 1);
  CHECK(content_of(file) == "to be kept");
  Process mixed({program, "--verify", "--share", "ipc:///nowhere/x"});
  CHECK(mixed.wait(kPatience) == 1);
}

// Until the file has a row of samples.
void wait_for_samples(const std::string& csv) {
  for (int i = 0; i < 2000 && std::ranges::count(content_of(csv), '\n') < 50; ++i) std::this_thread::sleep_for(10ms);
}

TEST_CASE("a session whose server is gone ends with 3, one whose server was started anew with 2" *
          doctest::test_suite("clock")) {
  for (const bool anew : {false, true}) {
    CAPTURE(anew);
    ServerProcess server({}, scene());
    const std::string csv = server.folder() / "run.csv";
    Process haptic({acus::program_path("acus-haptic"), "--commands", server.commands(), "--states", server.states(),
                    "--timeout", anew ? "20" : "1", "--record", csv});
    wait_for_samples(csv);
    server.process().send_signal(SIGKILL);
    server.process().wait(kPatience);
    std::optional<Process> other;
    if (anew) other.emplace(server.command_line({}));
    CHECK(haptic.wait(kPatience) == (anew ? 2 : 3));
  }
}

TEST_CASE("no server, no such needle, no such device: each its own exit status") {
  const std::string program = acus::program_path("acus-haptic");
  Process nobody({program, "ipc:///nowhere", "--timeout", "0.2"});
  CHECK(nobody.wait(kPatience) == 3);
  Process twice({program, "ipc:///nowhere", "--commands", "ipc:///nowhere/commands"});
  CHECK(twice.wait(kPatience) == 1);
  for (const char* axes : {"x,-y,z", "x,y", "w,y,z"}) {
    Process mirrored({program, "--verify", "--axes", axes});
    CHECK(mirrored.wait(kPatience) == 1);
  }
  Process unknown({program, "--device", "broom"});
  CHECK(unknown.wait(kPatience) == 1);
  for (const char* server :
       {"localhost:abc", "tcp://localhost:abc", "localhost:99999", "localhost:", "udp://localhost"}) {
    CAPTURE(server);
    Process misnamed({program, server, "--timeout", "0.2"});
    CHECK(misnamed.wait(kPatience) == 1);
  }
  ServerProcess server({"--lockstep"}, scene());
  Process needle(
      {program, "--commands", server.commands(), "--states", server.states(), "--needle", "none", "--duration", "0.1"});
  CHECK(needle.wait(kPatience) == 1);
}
