// SPDX-License-Identifier: GPL-3.0-or-later
// Outcomes of the scenes of clinical procedures: brachytherapy, needles that cross, and deep-brain electrodes.
#include <doctest/doctest.h>

#include <algorithm>

#include "server/engine/math/rotation.h"
#include "tests/support/needle_gap.h"
#include "tests/support/places.h"
#include "tests/support/shared_data.h"
#include "tests/validation/scene_run.h"

namespace acus::test {
namespace {

// Mean displacement of a region's nodes (m), weighted by the tetrahedra that they belong to.
Vector3 region_displacement(const SceneRun& run, int region) {
  const Simulation& simulation = run.simulation();
  const auto x = simulation.tissue_positions();
  Vector3 sum = Vector3::Zero();
  double volume = 0;
  for (int t = 0; t < simulation.mesh().tetrahedron_count(); ++t) {
    if (simulation.regions()[static_cast<std::size_t>(t)] != region) continue;
    const double v = rest_volume(simulation.mesh(), t);
    for (const int node : simulation.mesh().tetrahedra[static_cast<std::size_t>(t)])
      sum += v / 4 * (x.col(node) - simulation.mesh().nodes.col(node));
    volume += v;
  }
  return sum / volume;
}

int region_index(const Scene& scene, const std::string& name) {
  for (std::size_t i = 0; i < scene.tissue.regions.size(); ++i)
    if (scene.tissue.regions[i].name == name) return static_cast<int>(i);
  FAIL("no region ", name);
  return -1;
}

double farthest(const SceneRun& run) {
  const Simulation& simulation = run.simulation();
  return (simulation.tissue_positions() - simulation.mesh().nodes).colwise().norm().maxCoeff();
}

TEST_CASE("brachytherapy: six needles enter the prostate one after another and push the target ahead") {
  SceneRun run("brachytherapy");
  const int target = region_index(run.scene(), "target"), prostate = region_index(run.scene(), "prostate");
  double before = 0, largest = 0;
  for (double t = 0.1; t < 12.2; t += 0.1) {
    run.run_until(t);
    const double moved = region_displacement(run, target).norm();
    if (t < 10.5) before = std::max(before, moved);
    largest = std::max(largest, moved);
  }
  run.run();
  check_sound(run);
  const Vector3 end = region_displacement(run, target);
  MESSAGE("target moved by at most ", 1e3 * largest, " mm, ", 1e3 * before, " mm before its own needle; at the end [",
          1e3 * end.x(), ", ", 1e3 * end.y(), ", ", 1e3 * end.z(), "] mm");
  for (int i = 0; i < 6; ++i) {
    CAPTURE(i);
    CHECK(run.count(EventKind::puncture, i) == 1);
    const std::vector<Event> events = run.events(i);
    CHECK(std::any_of(events.begin(), events.end(), [&](const Event& e) {
      return e.kind == EventKind::crossing && e.region == prostate;
    }));
  }
  const std::vector<Event> last = run.events(5);
  CHECK(last.back().kind == EventKind::crossing);
  CHECK(last.back().region == target);
  // Pushed along the needles, by millimetres, as prostates are.
  CHECK(largest > 0.5e-3);
  CHECK(largest < 6e-3);
  CHECK(end.z() < 0);
}

TEST_CASE("crossing: the second needle bends the first one aside in the tissue, and leaves it as it was") {
  SceneRun run("crossing");
  std::vector<double> gaps;
  for (double t = 2; t < 7.5; t += 0.05) {
    run.run_until(t);
    const State& state = run.simulation().state();
    const Model& model = run.simulation().model();
    gaps.push_back(needle_gap(model.needles[0], state.needles[0], model.needles[1], state.needles[1]));
  }
  run.run();
  check_sound(run);
  CHECK(*std::ranges::min_element(gaps) > -3e-6);  // -1.4e-6
  double most = 0, between = 0;  // N
  for (std::size_t tick = 0; tick < run.ticks().size(); ++tick) {
    const Vector3 force = run.needle(tick, 0).needle_force;
    most = std::max(most, force.norm());
    between = std::max(between, (force + run.needle(tick, 1).needle_force).norm());
  }
  MESSAGE("they press each other by up to ", most, " N");
  CHECK(most == doctest::Approx(0.189).epsilon(0.1));
  CHECK(between < 1e-12);
  const std::size_t before = 2000, end = run.ticks().size() - 1;
  CHECK(run.needle(end, 0).needle_force.norm() == 0);
  CHECK((run.needle(end, 0).tip_position - run.needle(before, 0).tip_position).norm() < 0.05e-3);
}

// The tip's place among the tissue at rest is what a plan asks for.
TEST_CASE("deep_brain: a soft electrode reaches its target") {
  SceneRun run("deep_brain");
  run.run();
  check_sound(run);
  const int target = region_index(run.scene(), "target");
  CHECK(run.events().back().kind == EventKind::crossing);
  CHECK(run.events().back().region == target);
  const NeedleReport& end = run.needle(run.ticks().size() - 1);
  const Vector3 tip = rest_position(run.simulation(), end.tip_position);
  const Vector3 planned = run.scene().tissue.regions[static_cast<std::size_t>(target)].sphere->center;
  MESSAGE("tip ", 1e3 * (tip - planned).norm(), " mm off the target's centre, brain displaced by up to ",
          1e3 * farthest(run), " mm, largest force ", run.find(EventKind::puncture)->force, " N");
  CHECK((tip - planned).norm() < 0.3e-3);
  CHECK(end.base_force.norm() < 0.09);
  CHECK(farthest(run) < 0.4e-3);
}

// The electrode of the scene in the layers of a head, along the axis that the mesh was cut for; the skull is predrilled:
// a channel along the axis is nobody's bone.
Scene head_scene(const std::string& mesh, const Scene& electrode_scene) {
  const Vector3 entry(0.133537, 0.090199, 0.200070), axis = Vector3(-0.5086, -0.1822, -0.8415).normalized();
  Scene scene;
  scene.name = "electrode into a head";
  scene.rate = 100;
  scene.tissue.gmsh = GmshMesh{mesh, 1e-3};
  Interaction soft;
  soft.puncture_force = 0.06;
  soft.cutting_force = 0.02;
  soft.pressure = 800;
  soft.friction_static = 0.25;
  soft.friction_dynamic = 0.2;
  soft.friction_viscous = 10;
  const auto region = [&](const char* group, double young_modulus, double density) {
    Region r;
    r.name = group;
    r.physical_group = group;
    r.material = {young_modulus, 0.45, density, 0, 0.02};
    r.interaction = soft;
    scene.tissue.regions.push_back(r);
  };
  scene.tissue.regions.clear();
  region("scalp", 20e3, 1100);
  region("skull", 1e6, 1800);
  region("csf", 1e3, 1000);
  region("gray_matter", 3e3, 1040);
  region("white_matter", 4e3, 1040);
  scene.tissue.regions[1].interaction.puncture_force = kInfinity;
  Region burr_hole;
  burr_hole.name = "burr hole";
  burr_hole.physical_group = "skull";
  burr_hole.cylinder = Cylinder{entry, entry + 0.02 * axis, 0.004};
  burr_hole.material = {1e3, 0.45, 1000, 0, 0.02};
  burr_hole.interaction = soft;
  scene.tissue.regions.push_back(burr_hole);
  // The dura is open, and there are no other membranes below the skin.
  const auto join = [&](const char* between, const char* and_) {
    scene.tissue.interfaces.push_back({between, and_, 0, 0});
  };
  join("scalp", "burr hole");
  join("burr hole", "csf");
  join("csf", "gray_matter");
  join("gray_matter", "white_matter");
  Volume deep;  // what the needle does not reach holds the plug
  deep.half_space = HalfSpace{entry + 0.042 * axis, -axis};
  scene.tissue.fixed = {deep};
  scene.needles = electrode_scene.needles;
  scene.needles[0].base = {entry - (0.01 + scene.needles[0].length) * axis,
                           rotation_between(Vector3::UnitX(), axis)};
  scene.needles[0].max_speed = 0.05;
  scene.guides = electrode_scene.guides;
  scene.guides[0].pose = {entry - 0.003 * axis, scene.needles[0].base.orientation};
  scene.guides[1].pose = {entry - 0.025 * axis, scene.needles[0].base.orientation};
  return scene;
}

TEST_CASE("deep_brain: the same electrode through the layers of a head") {
  const std::string mesh = shared_data("meshes/head_plug_5regions.msh");
  if (mesh.empty()) return;
  const Scene scene = head_scene(mesh, read_scene(source_path("scenes/deep_brain.yaml")));
  Simulation simulation(scene);
  const Vector3 axis = scene.needles[0].base.orientation * Vector3::UnitX();
  std::vector<Event> events;
  int flagged = 0;
  constexpr double kSpeed = 0.01, kDepth = 0.03;
  for (int tick = 1; tick <= static_cast<int>((kDepth + 0.01) / kSpeed * scene.rate); ++tick) {
    Command command;
    command.seq = static_cast<std::uint64_t>(tick);
    command.pose = Pose{scene.needles[0].base.position + tick * kSpeed / scene.rate * axis,
                        scene.needles[0].base.orientation};
    simulation.command(0, command);
    simulation.step();
    flagged += (simulation.report().flags & ~kTangentProjected) != 0;  // it is near buckling between its guides
    const auto& of_tick = simulation.report().events;
    events.insert(events.end(), of_tick.begin(), of_tick.end());
  }
  const NeedleReport& end = simulation.report().needles[0];
  MESSAGE(names(events, scene), "; force ", end.base_force.norm(), " N, ", flagged, " ticks flagged");
  std::vector<int> first_seen;  // grey and white matter interlock: the axis may meet them more than once
  for (const Event& event : events)
    if (std::find(first_seen.begin(), first_seen.end(), event.region) == first_seen.end())
      first_seen.push_back(event.region);
  CHECK(first_seen == std::vector<int>{0, 5, 2, 3, 4});
  CHECK(flagged == 0);
  const Vector3 tip = rest_position(simulation, end.tip_position) - scene.needles[0].base.position;
  const double off_axis = (tip - tip.dot(axis) * axis).norm();
  MESSAGE("tip ", 1e3 * off_axis, " mm off the axis");
  CHECK(off_axis < 0.25e-3);
  CHECK(end.inserted_depth > 0.025);
}

}  // namespace
}  // namespace acus::test
