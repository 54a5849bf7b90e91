// SPDX-License-Identifier: GPL-3.0-or-later
// The scenes after Fig. 6 to 8 of the paper in tissue that hardly changes its volume, with the element that does not
// lock: the same outcomes as at 0.45.
#include <doctest/doctest.h>

#include "tests/validation/scene_run.h"

namespace acus::test {
namespace {

// The tissue has a moment more to come to rest, as in scenes_layers.cpp.
void make_nearly_incompressible(Scene& scene, client::Trajectory& motion) {
  std::vector<client::Sample>& samples = motion.motions[0].samples;
  samples.push_back({samples.back().time + 0.2, samples.back().pose});
  scene.tissue.element = TissueElement::nodal_pressure;
  for (Region& region : scene.tissue.regions) region.material.poisson_ratio = 0.49;
}

// Runs to its end.
struct NearlyIncompressible : SceneRun {
  NearlyIncompressible(const std::string& scene, const std::string& motion)
      : SceneRun(scene, motion, make_nearly_incompressible) {
    run();
    check_sound(*this);
  }
  explicit NearlyIncompressible(const std::string& scene) : NearlyIncompressible(scene, scene) {}
};

}  // namespace

TEST_CASE("at Poisson's ratio 0.49 insertion_pullback_layers goes through both layers and out") {
  const NearlyIncompressible run("insertion_pullback_layers", "insertion_pullback");
  CHECK(names(run.events(), run.scene()) ==
        "contact upper, puncture upper, contact lower, crossing lower, withdrawal upper");
  CHECK(run.find(EventKind::puncture)->force == doctest::Approx(1).epsilon(1e-6));
  CHECK(run.find(EventKind::crossing)->force == doctest::Approx(1.2).epsilon(1e-6));
}

TEST_CASE("at Poisson's ratio 0.49 the soft needle slides off the inclusion") {
  const NearlyIncompressible run("inclusion_soft_needle");
  CHECK(names(run.events(), run.scene()) == "contact tissue, puncture tissue, contact inclusion, release inclusion");
}

TEST_CASE("at Poisson's ratio 0.49 a stiffer needle enters the inclusion") {
  const NearlyIncompressible run("inclusion_stiff_needle");
  CHECK(names(run.events(), run.scene()) == "contact tissue, puncture tissue, contact inclusion, crossing inclusion");
}

TEST_CASE("at Poisson's ratio 0.49 the soft needle enters between supporting needles") {
  const NearlyIncompressible run("inclusion_supported");
  REQUIRE(run.find(EventKind::crossing) != nullptr);
  CHECK(run.find(EventKind::crossing)->region == 1);
  CHECK(run.find(EventKind::crossing)->force == doctest::Approx(0.7).epsilon(1e-6));
  for (int support = 1; support < 4; ++support)
    CHECK(names(run.events(support), run.scene()) == "contact tissue, puncture tissue");
}

}  // namespace acus::test
