// SPDX-License-Identifier: GPL-3.0-or-later
// Scenes with numbers at the ends of their ranges load or are refused, and what they publish is finite. Whether they
// are accurate is not asked.
#include <doctest/doctest.h>

#include <algorithm>
#include <random>

#include "server/engine/scene/scene_fields.h"
#include "server/engine/tick/simulation.h"

namespace acus {
namespace {

using Random = std::mt19937_64;

constexpr int kOneIn = 12;  // numbers, so many are put at an end of their range
constexpr int kScenes = 150;

double an_end_of(const Range& range, Random& random) { return random() % 2 == 0 ? range.min : range.max; }

template <class Value>
void disturb(Value& value, const Range& range, Random& random);

template <class Tuple, class Struct>
void disturb_fields(const Tuple& fields, Struct& value, Random& random) {
  for_each_entry(fields, [&]<class Entry>(const Entry& entry) {
    if constexpr (is_choice<Entry>) {
      disturb_fields(entry.alternatives, value, random);
    } else {
      disturb(value.*(entry.member), entry.range, random);
    }
  });
}

template <class Value>
void disturb(Value& value, const Range& range, Random& random) {
  if constexpr (HasFields<Value>) {
    disturb_fields(FieldsOf<Value>::list, value, random);
  } else if constexpr (is_list<Value>) {
    for (auto& entry : value) disturb(entry, range, random);
  } else if constexpr (is_optional<Value>) {
    if (value) disturb(*value, range, random);
  } else if constexpr (std::is_same_v<Value, Vector3>) {
    for (double& x : value) disturb(x, range, random);
  } else if constexpr (std::is_arithmetic_v<Value>) {
    if (random() % kOneIn == 0) value = static_cast<Value>(an_end_of(range, random));
  }
}

// The default scene above a small tissue, disturbed, with the rules between fields kept and few steps a tick.
Scene disturbed_scene(Random& random) {
  Scene scene;
  scene.tissue.box.cells = {2, 2, 2};
  scene.tissue.rung = static_cast<TissueRung>(random() % NamesOf<TissueRung>::names.size());
  scene.tissue.regions[0].interaction.pressure = 1000;
  scene.tissue.regions[0].interaction.foundation_stiffness = 1e5;
  scene.tissue.fixed.resize(1);
  scene.tissue.fixed[0].half_space = HalfSpace{{0, 0, -0.049}, Vector3::UnitZ()};
  scene.needles[0].base = {{0, 0, 0.201}, Quaternion(std::sqrt(0.5), 0, std::sqrt(0.5), 0)};
  scene.needles[0].curved_length = 0.05;
  disturb(scene, any(), random);
  scene.tissue.box.cells = {2, 2, 2};
  scene.newton.max_iterations = std::min(scene.newton.max_iterations, 3);
  scene.laws.max_steps = std::min(scene.laws.max_steps, 50);
  Interaction& laws = scene.tissue.regions[0].interaction;
  laws.friction_static = std::max(laws.friction_static, laws.friction_dynamic);
  Needle& needle = scene.needles[0];
  needle.beams = std::min(needle.beams, 50);
  needle.inner_diameter = std::min(needle.inner_diameter, 0.999 * needle.outer_diameter);
  needle.constraint_spacing = std::max(needle.constraint_spacing, needle.length / 50);
  needle.curved_length = std::min(*needle.curved_length, needle.length);
  needle.curvature = std::clamp(needle.curvature, -3 * needle.beams / needle.length, 3 * needle.beams / needle.length);
  needle.cutting_direction.x() = std::max(needle.cutting_direction.x(), 1e-3);
  return scene;
}

bool finite(const Simulation& simulation) {
  const NeedleReport& needle = simulation.report().needles[0];
  return simulation.needle_positions(0).allFinite() && simulation.tissue_positions().allFinite() &&
         needle.base_force.allFinite() && needle.base_torque.allFinite() && needle.tip_force.allFinite() &&
         needle.base.position.allFinite() && needle.tip_position.allFinite() && std::isfinite(needle.spin);
}

}  // namespace

TEST_CASE("a scene with numbers at the ends of their ranges is refused, or publishes finite numbers") {
  int loaded = 0;
  for (unsigned seed = 0; seed < kScenes; ++seed) {
    CAPTURE(seed);
    Random random(seed);
    const Scene scene = disturbed_scene(random);
    try {
      Simulation simulation(scene);
      ++loaded;
      for (std::uint64_t tick = 1; tick <= 5; ++tick) {
        const Vector3 forwards = scene.needles[0].base.orientation * Vector3(2e-3 * static_cast<double>(tick), 0, 0);
        const Pose pose{scene.needles[0].base.position + forwards, scene.needles[0].base.orientation};
        simulation.command(0, {tick, pose, tick == 3 ? kMaxSpin : 0.1});
        simulation.step();
        CHECK(finite(simulation));
      }
    } catch (const std::runtime_error& error) {
      CHECK(std::string(error.what()).size() > 10);
    }
  }
  MESSAGE(loaded << " of " << kScenes << " scenes loaded");
  CHECK(loaded > kScenes / 4);
}

}  // namespace acus
