// SPDX-License-Identifier: GPL-3.0-or-later
// Trajectories: at all times of one that is accepted, the base stands somewhere.
#include <cmath>

#include "client/replay/trajectory.h"
#include "tests/fuzz/fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace acus::client;
  try {
    const Trajectory trajectory = parse_trajectory(acus::fuzz::text_of(data, size), "motion.csv");
    for (const Motion& motion : trajectory.motions) {
      for (int i = -1; i <= 11; ++i) {
        const double share = i / 10.0;
        const BasePose pose = motion.at((1 - share) * trajectory.begin() + share * trajectory.end());
        double square = 0;
        for (const double x : pose.position) acus::fuzz::require(std::isfinite(x), "positions are finite");
        for (const double x : pose.orientation) square += x * x;
        acus::fuzz::require(std::abs(square - 1) < 1e-6, "orientations are unit quaternions");
      }
    }
  } catch (const TrajectoryError&) {
  }
  return 0;
}
