// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/runtime/rehearsal.h"

#include <doctest/doctest.h>

#include "server/engine/state/bytes/state_bytes.h"

namespace acus {
namespace {

// A needle 35 mm above a block, or turned away from it.
Simulation simulation_of(const std::string& orientation) {
  return Simulation(
      parse_scene("acus_scene: 1\nrate: 200\n"
                  "tissue:\n"
                  "  mesh: {box: {size: [0.1, 0.1, 0.1], cells: [3, 3, 3]}}\n"
                  "  regions: [{interaction: {puncture_force: 0.2}}]\n"
                  "  fixed: [{box: {max: [.inf, .inf, -0.05]}}]\n"
                  "needles: [{length: 0.1, base: {position: [0.003, 0.002, 0.185], orientation: [" +
                      orientation + "]}}]\n",
                  "scene.yaml", ""));
}

}  // namespace

TEST_CASE("a rehearsal pushes the needle in, and leaves the state as it was after loading") {
  Simulation simulation = simulation_of("0.7071068, 0, 0.7071068, 0");
  const std::uint64_t before = hash(simulation.state());
  const Rehearsal rehearsal = rehearse(simulation, {.processor_time = 100, .duration = 4});
  CHECK(hash(simulation.state()) == before);
  CHECK(rehearsal.outside.ticks > 0);
  CHECK(rehearsal.outside.median > 0);
  REQUIRE(rehearsal.inside.size() == 4);
  CHECK(rehearsal.outside.rows < rehearsal.inside.front().rows);
  for (std::size_t i = 0; i < rehearsal.inside.size(); ++i) {
    const RehearsedTicks& part = rehearsal.inside[i];
    CHECK(part.rows > 0);
    CHECK(part.median > 0);
    CHECK(part.p99 >= part.median);
    if (i > 0) CHECK(part.depth > rehearsal.inside[i - 1].depth);
  }
  CHECK(rehearsal.inside.back().depth > 0.03);
  CHECK(rehearsal.inside.back().rows > rehearsal.inside.front().rows);
}

TEST_CASE("a needle that points elsewhere is told of") {
  Simulation simulation = simulation_of("0.7071068, 0, -0.7071068, 0");
  const Rehearsal rehearsal = rehearse(simulation, {.processor_time = 100, .duration = 20});
  CHECK(rehearsal.end == RehearsalEnd::needles_are_through);
  CHECK(rehearsal.outside.ticks < 400);  // 0.23 m to the farthest node and 0.1 m of needle, at 0.2 m/s
  CHECK(rehearsal.inside.empty());
  CHECK(describe(rehearsal, 0.005).find("no needle gets to the tissue") != std::string::npos);
}

TEST_CASE("a rehearsal that a limit stops on the way says so, instead of that no needle gets to the tissue") {
  for (const auto& orientation : {"0.7071068, 0, 0.7071068, 0", "0.7071068, 0, -0.7071068, 0"}) {
    Simulation simulation = simulation_of(orientation);
    const Rehearsal short_one = rehearse(simulation, {.processor_time = 100, .duration = 0.05});
    CHECK(short_one.end == RehearsalEnd::duration);
    CHECK(short_one.outside.ticks == 5);
    CHECK(short_one.inside.empty());
    const std::string text = describe(short_one, 0.005);
    CHECK(text.find("not reached within 0.05 s of simulation time") != std::string::npos);
    CHECK(text.find("no needle") == std::string::npos);
  }
}

TEST_CASE("few ticks inside are one part") {
  Simulation simulation = simulation_of("0.7071068, 0, 0.7071068, 0");
  const auto inside_of = [&](double duration) {
    const Rehearsal rehearsal = rehearse(simulation, {.processor_time = 100, .duration = duration});
    int ticks = 0;
    for (const RehearsedTicks& part : rehearsal.inside) ticks += part.ticks;
    return std::pair{rehearsal.inside.size(), ticks};
  };
  double duration = 0.05;  // s, half of the way to the tissue
  REQUIRE(inside_of(duration).first == 0);
  while (inside_of(duration).first == 0 && duration < 1) duration += 0.05;  // ten ticks
  const auto [parts, ticks] = inside_of(duration);
  CHECK(parts == 1);
  CHECK(ticks > 0);
  CHECK(ticks <= 10);
}

TEST_CASE("a rehearsal ends in the time that it may take") {
  Simulation simulation = simulation_of("0.7071068, 0, 0.7071068, 0");
  const Rehearsal none = rehearse(simulation, {.processor_time = 0, .duration = 100});
  CHECK(none.outside.ticks == 0);
  CHECK(none.inside.empty());
  CHECK(none.end == RehearsalEnd::processor_time);
  CHECK(describe(none, 0.005).find("not reached within 0 s of processor time") != std::string::npos);
}

TEST_CASE("a rehearsal is printed in milliseconds and in shares of a tick") {
  const Rehearsal rehearsal{{100, 0, 0, 1e-3, 1.5e-3}, {{50, 0.02, 36, 1.25e-3, 2e-3}}, {}, {}};
  const std::string text = describe(rehearsal, 0.004);
  CHECK(text.find("needles outside      0           0     1.000     1.500     38 %") != std::string::npos);
  CHECK(text.find("pushed in            20          36    1.250     2.000     50 %") != std::string::npos);
}

TEST_CASE("ticks that take longer than they may are warned of, with a rate that can be held") {
  const Rehearsal rehearsal{{100, 0, 0, 1e-3, 1.5e-3}, {{50, 0.02, 36, 1.25e-3, 2e-3}}, {}, {}};
  CHECK(rehearsal_warnings(rehearsal, 0.0021).empty());
  const std::vector<SceneWarning> found = rehearsal_warnings(rehearsal, 0.001);
  REQUIRE(found.size() == 1);
  CHECK(found[0].text.starts_with("they take up to 200 % of their time"));
  CHECK(found[0].text.find("a rate of at most 400 Hz") != std::string::npos);
  CHECK(found[0].text.find("tissue.window") == std::string::npos);
  CHECK(rehearsal_warnings(rehearsal, 0.001, 16)[0].text.find("tissue.window: 16, or --lockstep") != std::string::npos);
}

TEST_CASE("a window that its thread has too little time for is warned of, with one that it has enough for") {
  Rehearsal rehearsal{{100, 0, 0, 1e-4, 2e-4}, {{50, 0.02, 36, 1e-4, 2e-4}}, {}, {}, 16, 12e-3};
  CHECK(rehearsal_warnings(rehearsal, 0.001).empty());
  CHECK(describe(rehearsal, 0.001).find("the window's thread takes 12.00 ms of a window of 16.00 ms") !=
        std::string::npos);
  rehearsal.window_seconds = 14e-3;
  const std::vector<SceneWarning> found = rehearsal_warnings(rehearsal, 0.001);
  REQUIRE(found.size() == 1);
  CHECK(found[0].of == "tissue.window");
  CHECK(found[0].text ==
        "its thread takes up to 14.0 ms of the 16.0 ms of a window, so that ticks wait for it; take at least 18, or "
        "fewer cells");
}

TEST_CASE("a rehearsal times the window's thread") {
  Scene scene = simulation_of("0.7071068, 0, 0.7071068, 0").scene();
  scene.tissue.regions[0].material.rayleigh_stiffness = 0.01;
  scene.tissue.window = 4;
  scene.tissue.window_thread = true;
  Simulation simulation(scene);
  const Rehearsal rehearsal = rehearse(simulation, {.processor_time = 100, .duration = 1});
  CHECK(rehearsal.window == 4);
  CHECK(rehearsal.window_seconds > 0);
}

TEST_CASE("a window is what large tissue on supports may try, where the scene can have one") {
  const auto with_cells = [](const std::string& cells) {
    return parse_scene(
        "acus_scene: 1\nrate: 1000\n"
        "tissue:\n"
        "  rung: warped\n"
        "  mesh: {box: {size: [0.1, 0.1, 0.1], cells: [" +
            cells +
            "]}}\n"
            "  regions: [{material: {poisson_ratio: 0.45, rayleigh_stiffness: 0.01}}]\n"
            "  fixed: [{box: {max: [.inf, .inf, -0.04]}}]\n"
            "needles: [{length: 0.1, base: {position: [0, 0, 0.2]}}]\n",
        "scene.yaml", "");
  };
  Scene scene = with_cells("10, 10, 10");
  CHECK(window_to_try(Simulation(scene)) == 16);
  scene.rate = 250;
  CHECK(window_to_try(Simulation(scene)) == 4);
  scene.tissue.window = 4;
  CHECK(window_to_try(Simulation(scene)) == 0);
  scene.tissue.window = 0;
  scene.tissue.rung = TissueRung::linear;
  CHECK(window_to_try(Simulation(scene)) == 0);
  CHECK(window_to_try(Simulation(with_cells("4, 4, 4"))) == 0);
}

}  // namespace acus
