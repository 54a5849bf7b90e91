// SPDX-License-Identifier: GPL-3.0-or-later
// acus-replay and a real acus-server, as processes over real sockets.
#include <doctest/doctest.h>
#include <signal.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "protocol/codec.h"
#include "tests/client/recorded_messages.h"
#include "tests/integration/process.h"
#include "tests/integration/server_process.h"
#include "tests/support/places.h"

using acus::TemporaryFolder;
using acus::testing::kPatience;
using acus::testing::Process;
using namespace std::chrono_literals;

namespace {

constexpr std::chrono::minutes kLongRun{9};  // for sanitizers on a busy machine

// A server and the replay of a trajectory into it, in a folder that goes with them.
struct Bench {
  TemporaryFolder folder;

  std::string path(const std::string& name) const { return folder / name; }

  std::vector<std::string> server(const std::string& scene, const std::vector<std::string>& options = {}) const {
    return with_endpoints({acus::program_path("acus-server"), scene}, options);
  }

  std::vector<std::string> replay(const std::string& trajectory, std::vector<std::string> options = {}) const {
    options.insert(options.end(), {"--out", path("run.csv"), "--timeout", "60"});
    return with_endpoints({acus::program_path("acus-replay"), trajectory}, options);
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

const std::string kScenes = acus::source_path("scenes/");

// Those of the default run: all there, at their ticks, with the path that was cut.
void check_shapes(const std::vector<std::string>& messages) {
  using namespace acus::protocol;
  const auto hello = std::get<HelloReply>(decode_reply(messages.at(0)));
  const auto describe = std::get<DescribeReply>(decode_reply(messages.at(1)));
  CHECK(describe.positions.size() == 3 * hello.tissue.nodes);
  std::uint64_t needles = 0, tissues = 0;
  float lowest = 1;  // m, end of the path when it was longest
  for (std::size_t i = 2; i < messages.size(); ++i) {
    const State state = decode_state(messages[i]);
    if (const auto* needle = std::get_if<NeedleShape>(&state)) {
      REQUIRE(needle->tick == 8 * ++needles);  // 500 ticks per second, 60 shapes as near as whole ticks come
      continue;
    }
    const auto& tissue = std::get<TissueShape>(state);
    REQUIRE(tissue.tick == 17 * ++tissues);
    REQUIRE(tissue.positions.size() == describe.positions.size());
    if (!tissue.path_points.empty()) lowest = std::min(lowest, tissue.path_points.back());
  }
  CHECK(needles == 8202 / 8);
  CHECK(tissues == 8202 / 17);
  CHECK(lowest < -0.015f);  // 65 mm below the top face
}

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
  Process replay(bench.replay(kScenes + "trajectories/insertion_pullback.csv",
                              {"--lockstep", "--shutdown", "--shapes", bench.path("run.shapes")}));
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
  CHECK(split(bench.lines("run.events.csv").back()).at(5) == "phantom");

  check_shapes(acus::test::read_messages(bench.path("run.shapes")));
}
