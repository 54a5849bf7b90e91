// SPDX-License-Identifier: GPL-3.0-or-later
// Outcomes of the scenes with something in the way: an inclusion that a needle may slide off, and bone.
#include <doctest/doctest.h>

#include "server/engine/models/unresolved/dimple.h"
#include "server/engine/scene/scene_fields.h"
#include "tests/support/places.h"
#include "tests/validation/scene_run.h"

namespace acus::test {
namespace {

constexpr double kInclusionRadius = 14e-3;  // m, of the ball around the origin in scenes/meshes/inclusion.geo

// Whether all fields of two parameter structs are the same, however deep they stand.
template <class T>
bool same(const T& a, const T& b) {
  if constexpr (HasFields<T>) {
    bool all = true;
    for_each_entry(FieldsOf<T>::list, [&](const auto& entry) {
      if constexpr (requires { entry.member; }) {
        all = all && same(a.*entry.member, b.*entry.member);
      } else {
        for_each_entry(entry.alternatives, [&](const auto& f) { all = all && same(a.*f.member, b.*f.member); });
      }
    });
    return all;
  } else if constexpr (is_optional<T>) {
    return a.has_value() == b.has_value() && (!a || same(*a, *b));
  } else if constexpr (is_list<T>) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const auto& x, const auto& y) { return same(x, y); });
  } else if constexpr (requires { a.coeffs(); }) {
    return (a.coeffs().array() == b.coeffs().array()).all();
  } else {
    return a == b;
  }
}

int needle_path(const SceneRun& run) {
  // The needle that is looked at is the last one in.
  int last = -1;
  Matrix3X points(3, run.simulation().path_capacity());
  for (int i = 0; i < Simulation::max_paths(); ++i)
    if (run.simulation().path_positions(i, points) > 0) last = i;
  return last;
}

// How close a path at rest comes to the inclusion's middle (m).
double closest_approach(const Matrix3X& path) { return path.colwise().norm().minCoeff(); }

}  // namespace

TEST_CASE("inclusion_soft_needle: the needle touches the inclusion, slides along it and off") {
  SceneRun run("inclusion_soft_needle");
  run.run();
  check_sound(run);
  CHECK(names(run.events(), run.scene()) == "contact tissue, puncture tissue, contact inclusion, release inclusion");
  const Matrix3X path = path_at_rest(run.simulation(), needle_path(run));
  CHECK(closest_approach(path) > kInclusionRadius - 0.5e-3);  // flat elements cut the corners of the ball
  const Vector3 end = path.rightCols<1>();
  CHECK(end.z() < 0);  // past the middle, beside it
  CHECK(end.z() > -kInclusionRadius);
  CHECK(end.head<2>().norm() > 0.012);
}

TEST_CASE("inclusion_stiff_needle: a stiffer needle enters") {
  SceneRun run("inclusion_stiff_needle");
  run.run();
  check_sound(run);
  CHECK(names(run.events(), run.scene()) == "contact tissue, puncture tissue, contact inclusion, crossing inclusion");
  CHECK(run.find(EventKind::crossing)->force == doctest::Approx(0.7).epsilon(1e-6));
  CHECK(path_at_rest(run.simulation(), needle_path(run)).rightCols<1>().norm() < kInclusionRadius);
}

TEST_CASE("inclusion_supported: between supporting needles the soft needle enters") {
  SceneRun run("inclusion_supported");
  run.run();
  check_sound(run);
  const Scene alone = read_scene(source_path("scenes/inclusion_soft_needle.yaml"));
  CHECK(same(run.scene().tissue, alone.tissue));
  CHECK(same(run.scene().needles[0], alone.needles[0]));
  CHECK(same(run.scene().guides, alone.guides));
  CHECK(run.scene().rate == alone.rate);

  REQUIRE(run.find(EventKind::crossing) != nullptr);
  CHECK(run.find(EventKind::crossing)->region == 1);
  CHECK(run.find(EventKind::crossing)->force == doctest::Approx(0.7).epsilon(1e-6));
  CHECK(closest_approach(path_at_rest(run.simulation(), needle_path(run))) < kInclusionRadius - 1e-3);
  for (int support = 1; support < 4; ++support) {
    CHECK(names(run.events(support), run.scene()) == "contact tissue, puncture tissue");
  }
}

TEST_CASE("bone: the tip slides along it and never enters, at ten times the force that punctures muscle") {
  SceneRun run("bone");
  run.run();
  check_sound(run);
  const Scene& scene = run.scene();
  CHECK(names(run.events(), scene) == "contact muscle, puncture muscle, contact bone, release bone, withdrawal muscle");
  const Event* touched = nullptr;
  for (const TickReport& tick : run.ticks())
    for (const Event& e : tick.events)
      if (e.kind == EventKind::contact && e.region == 1) touched = &e;
  REQUIRE(touched != nullptr);

  constexpr double kBoneSurface = -0.01;  // m, z
  double deepest = 0, slid = 0, largest = 0;
  for (const TickReport& tick : run.ticks()) {
    const NeedleReport& n = tick.needles[0];
    deepest = std::max(deepest, kBoneSurface - n.tip_position.z());
    if (n.tip_position.z() < kBoneSurface + 0.1e-3) largest = std::max(largest, n.tip_force.z());
    if (tick.tick > touched->tick && n.tip_position.z() < kBoneSurface + 0.1e-3)
      slid = std::max(slid, (n.tip_position - touched->position).norm());
  }
  MESSAGE("slid " << 1e3 * slid << " mm, largest force of the bone on the tip " << largest << " N, deepest "
                  << 1e3 * deepest << " mm");
  CHECK(slid > 10e-3);
  Indented sides(scene.tissue.regions[0].material, scene.tissue.regions[0].interaction.deep_indentation);
  sides += Indented(scene.tissue.regions[1].material, scene.tissue.regions[1].interaction.deep_indentation);
  CHECK(dimple_force(sides, scene.needles[0].outer_diameter, deepest) <= 1.01 * largest);
  CHECK(largest >= 10 * scene.tissue.regions[0].interaction.puncture_force);
  CHECK((run.simulation().tissue_positions() - run.simulation().mesh().nodes).cwiseAbs().maxCoeff() < 1e-9);
}

}  // namespace acus::test
