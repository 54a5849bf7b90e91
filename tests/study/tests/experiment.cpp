// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/study/studies/experiment.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/places.h"

namespace acus {
namespace {

const std::string kScenes = source_path("scenes");

double height(const client::Motion& motion, double time) { return motion.at(time).position[2]; }

TEST_CASE("a study's motion is the recorded one without its corners, as fast as it is told") {
  const client::Motion recorded = client::read_trajectory(kScenes + "/trajectories/insertion_pullback.csv").motions[0];
  const client::Motion rounded = read_experiment(kScenes, "insertion_pullback", 2).motion.motions[0];
  const double step = 0.25e-3;
  double apart = 0, corner = 0, rounded_corner = 0;
  for (double t = step; t < 8.2; t += step) {
    const auto bend = [&](const client::Motion& motion, double pace) {
      return std::abs(height(motion, pace * (t + step)) - 2 * height(motion, pace * t) +
                      height(motion, pace * (t - step)));
    };
    apart = std::max(apart, std::abs(height(rounded, t) - height(recorded, 2 * t)));
    corner = std::max(corner, bend(recorded, 2));
    rounded_corner = std::max(rounded_corner, bend(rounded, 1));
  }
  CHECK(apart < 1e-5);  // m
  CHECK(rounded_corner < 0.1 * corner);
}

TEST_CASE("a recording has every tick of tips and forces, and probes at multiples of their interval") {
  Experiment experiment = read_experiment(kScenes, "insertion_pullback");
  client::Motion& motion = experiment.motion.motions[0];
  std::erase_if(motion.samples, [](const client::Sample& sample) { return sample.time > 0.31; });
  experiment.scene.rate = 100;
  experiment.scene.tissue.box.cells = {3, 3, 3};
  const Matrix3X points = (Matrix3X(3, 2) << 0, 0.01, 0, 0.02, 0.05, -0.03).finished();
  const Recording recording = record(experiment, points);
  CHECK(recording.ticks == 31);
  REQUIRE(recording.tip.size() == 1);
  CHECK(recording.tip[0].cols() == 31);
  CHECK(recording.base_force[0].cols() == 31);
  REQUIRE(recording.probes.size() == 3);
  // The needle has not touched the tissue yet.
  for (const Matrix3X& probe : recording.probes) CHECK(probe.cwiseAbs().maxCoeff() < 1e-15);
  CHECK(recording.not_converged == 0);
  CHECK(recording.run_time() > 0);
  CHECK(recording.calibrated() > 0);
}

}  // namespace
}  // namespace acus
