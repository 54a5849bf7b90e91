// SPDX-License-Identifier: GPL-3.0-or-later
// Runs of a scene with its motion that can be compared with each other, whatever their time step, mesh and beams.
//
// Bases stand where the motion has them at the end of every tick, exactly: the lag of commands (one tick, and the
// scene's smoothing) is not an error of the simulation.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "client/replay/trajectory.h"
#include "server/engine/tick/simulation.h"

namespace acus {

struct Experiment {
  Scene scene;
  client::Trajectory motion;
};

// scenes/NAME.yaml with scenes/trajectories/NAME.csv, `pace` times as fast. The motion's corners are rounded here
// instead of by the scene's smoothing, the same for every time step: a base whose speed jumps within a tick has an
// inertial force that grows with 1/h.
Experiment read_experiment(const std::string& scenes_folder, const std::string& name, double pace = 1);

// What is kept of a run, from its first tick on. Series of one needle after the other.
struct Recording {
  double h = 0;                      // s
  std::vector<Matrix3X> tip;         // per needle, 3 x ticks (m)
  std::vector<Matrix3X> base_force;  // per needle, 3 x ticks (N)
  std::vector<Matrix3X> probes;      // per probing, 3 x probes (m), displacements
  std::uint64_t ticks = 0;
  std::uint64_t not_converged = 0;    // ticks whose laws or iterations ended above their tolerance
  double sweeps = 0, iterations = 0;  // mean per tick
  double residual = 0;                // N, largest
  double processor_seconds = 0;       // of the ticks alone
  // Of the calibration (tests/study/bench/calibration.h) beside the ticks, median of one solve; 0 without tissue.
  double calibration_seconds = 0;

  // Processor seconds per simulated second: below 1 it runs in real time.
  double run_time() const { return processor_seconds / (static_cast<double>(ticks) * h); }
  // Of a tick over the calibration (-).
  double calibrated() const { return run_time() * h / calibration_seconds; }
};

// How long the motion takes (s).
double duration(const Experiment& experiment);

// Where the tissue's displacement is asked for: points of its rest shape (3 x probes, m, world), at every full multiple
// of kProbeInterval, which must be one of h, too.
inline constexpr double kProbeInterval = 0.1;  // s
Recording record(const Experiment& experiment, const Matrix3X& probes);


// The nodes of the experiment's own mesh at rest.
Matrix3X nodes_of(const Experiment& experiment);

}  // namespace acus
