// SPDX-License-Identifier: GPL-3.0-or-later
// acus-replay and a real acus-server, as processes over real sockets.
#include <doctest/doctest.h>
#include <signal.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "tests/integration/process.h"
#include "tests/integration/server_process.h"

using acus::testing::kPatience;
using acus::testing::Process;
using acus::testing::TemporaryFolder;
using namespace std::chrono_literals;

namespace {

constexpr std::chrono::minutes kLongRun{9};  // for sanitizers on a busy machine

// A server and the replay of a trajectory into it, in a folder that goes with them.
struct Bench {
  TemporaryFolder folder;

  std::string path(const std::string& name) const { return folder / name; }

  std::vector<std::string> server(const std::string& scene, const std::vector<std::string>& options = {}) const {
    return with_endpoints({ACUS_BINARY_DIR "/acus-server", scene}, options);
  }

  std::vector<std::string> replay(const std::string& trajectory, std::vector<std::string> options = {}) const {
    options.insert(options.end(), {"--out", path("run.csv"), "--timeout", "60"});
    return with_endpoints({ACUS_BINARY_DIR "/acus-replay", trajectory}, options);
  }

  std::vector<std::string> lines(const std::string& name) const {
    std::ifstream file(path(name));
    std::vector<std::string> lines;
    for (std::string line; std::getline(file, line);) lines.push_back(line);
    return lines;
  }

 private:
  std::vector<std::string> with_endpoints(std::vector<std::string> line,
                                          const std::vector<std::string>& options) const {
    line.insert(line.end(), {"--commands", "ipc://" + path("commands"), "--states", "ipc://" + path("states")});
    line.insert(line.end(), options.begin(), options.end());
    return line;
  }
};

std::vector<std::string> split(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream stream(line);
  for (std::string cell; std::getline(stream, cell, ',');) cells.push_back(cell);
  return cells;
}

// The numbers of a column of a run.
std::vector<double> column(const std::vector<std::string>& lines, const std::string& name) {
  const auto names = split(lines.at(0));
  const auto index = std::find(names.begin(), names.end(), name) - names.begin();
  REQUIRE(index < std::ssize(names));
  std::vector<double> values;
  for (std::size_t i = 1; i < lines.size(); ++i) values.push_back(std::stod(split(lines[i])[index]));
  return values;
}

std::string slow_motion(const Bench& bench, double seconds) {
  std::ostringstream text;
  text << "t,needle,x,y,z,qw,qx,qy,qz,spin\n0,needle,0,0,0.5,1,0,0,0,0\n" << seconds << ",needle,0,0,0.6,1,0,0,0,0\n";
  return bench.folder.write("motion.csv", text.str());
}

std::string far_away_scene(const Bench& bench) {
  return bench.folder.write("scene.yaml", acus::testing::small_scene("small"));
}

// The liver is fixed at one end; the needle stands 10 mm before the middle of a flat place at the other and points
// along the normal there.
std::string liver_scene(const std::string& mesh) {
  const std::string head = R"(acus_scene: 1
name: liver
rate: 500
needles:
  - base: {position: [-0.3082, 0.1343, -0.0262], orientation: [0.993217, 0, -0.076517, -0.087592]}
tissue:
  fixed:
    - box: {min: [0, -.inf, -.inf]}
  mesh:
    gmsh:
      metres_per_unit: 0.034
      file: )";
  return head + mesh + "\n";
}

const std::string kScenes = std::string(ACUS_SOURCE_DIR) + "/scenes/";
const std::string kSharedData = std::string(ACUS_SOURCE_DIR) + "/../shared/data/";

}  // namespace

TEST_CASE("acus-replay waits for a server that starts later, and shuts it down") {
  const Bench bench;
  Process replay(bench.replay(slow_motion(bench, 0.5), {"--shutdown"}));
  std::this_thread::sleep_for(300ms);
  Process server(bench.server(far_away_scene(bench)));
  CHECK(replay.wait(kPatience) == 0);
  CHECK(server.wait(kPatience) == 0);
  CHECK(bench.lines("run.csv").size() > 50);  // 0.5 s at 200 Hz, less what a busy server skipped
}

TEST_CASE("acus-replay ends with 3 when the server is killed under it, and keeps what it has") {
  const Bench bench;
  Process server(bench.server(far_away_scene(bench)));
  Process replay(bench.replay(slow_motion(bench, 300)));
  const auto deadline = std::chrono::steady_clock::now() + kPatience;
  while (bench.lines("run.csv").size() < 10 && std::chrono::steady_clock::now() < deadline) {
    std::this_thread::sleep_for(20ms);
  }
  server.send_signal(SIGKILL);
  CHECK(replay.wait(kPatience) == 3);
  CHECK(bench.lines("run.csv").size() >= 10);
}

TEST_CASE("the default scene and trajectory in lockstep give the curve of an insertion and a pullback") {
  const Bench bench;
  Process server(bench.server(kScenes + "insertion_pullback.yaml", {"--lockstep"}));
  Process replay(bench.replay(kScenes + "trajectories/insertion_pullback.csv", {"--lockstep", "--shutdown"}));
  REQUIRE(replay.wait(kLongRun) == 0);
  CHECK(server.wait(kPatience) == 0);

  const auto run = bench.lines("run.csv");
  const auto ticks = column(run, "tick");
  CHECK(ticks.size() == 8202);  // 16.4 s at 500 Hz, both ends, and one tick before the first pose
  CHECK(ticks.back() == 8202);

  const auto depth = column(run, "depth_m");
  CHECK(*std::max_element(depth.begin(), depth.end()) > 0.065);
  CHECK(depth.back() == 0);
  const auto axial = column(run, "base_force_in_base_x_N");  // negative: resistance against going in
  CHECK(*std::min_element(axial.begin(), axial.end()) < -1.5);
  CHECK(*std::max_element(axial.begin(), axial.end()) > 1.0);
  CHECK(std::abs(axial.back()) < 1e-6);

  std::string kinds;
  for (const std::string& event : bench.lines("run.events.csv")) kinds += " " + split(event).at(4);
  CHECK(kinds == " kind contact puncture withdrawal");
}

TEST_CASE("a measured hand motion into a liver, in real time: no state lost, every number finite") {
  const std::string recording = kSharedData + "hand_motion/recording1.txt";
  const std::string mesh = std::filesystem::weakly_canonical(kSharedData + "meshes/sofa_liver.msh").string();
  if (!std::filesystem::exists(recording) || !std::filesystem::exists(mesh)) {
    MESSAGE("skipped: no ../shared/data beside the source");
    return;
  }
  const Bench bench;
  Process convert({ACUS_SOURCE_DIR "/client/convert_hand_motion.py", recording, "--out", bench.path("hand.csv"),
                   "--start", "-0.3082", "0.1343", "-0.0262", "--direction", "0.973", "-0.174", "0.152", "--travel",
                   "0.05"});
  REQUIRE(convert.wait(kPatience) == 0);

  Process server(bench.server(bench.folder.write("scene.yaml", liver_scene(mesh))));
  Process replay(bench.replay(bench.path("hand.csv"), {"--shutdown"}));
  CHECK(replay.wait(kLongRun) == 0);  // lost states would be 4
  CHECK(server.wait(kPatience) == 0);

  const auto run = bench.lines("run.csv");
  const auto depth = column(run, "depth_m");
  CHECK(*std::max_element(depth.begin(), depth.end()) > 0.005);
  for (const char* name :
       {"base_force_x_N", "base_force_y_N", "base_force_z_N", "base_torque_x_Nm", "tip_position_z_m"}) {
    const auto values = column(run, name);
    CHECK_MESSAGE(std::all_of(values.begin(), values.end(), [](double value) { return std::isfinite(value); }), name);
  }
  const auto flags = column(run, "flags");
  CHECK(std::none_of(flags.begin(), flags.end(),
                     [](double bits) { return (static_cast<unsigned>(bits) & acus::protocol::kNotFinite) != 0; }));
}
