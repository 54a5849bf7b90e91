// SPDX-License-Identifier: GPL-3.0-or-later
// Which runs the study of errors makes of a scene: one knob at a time, from the scene as it stands with a tick of 1 ms,
// and the combinations of rung and mesh with the time step. Kinds of error are told apart by what a run is compared
// with:
//
//   solver          the same scene and time step, converged (rung refined to 1e-12 m, laws direct to 1e-10 N)
//   laws            the same scene, rung and time step with the laws solved directly, to 1e-10 N
//   total           the same scene, converged, with the shortest time step: solver and time step together; of a
//                   converged run, the error of the time step alone
//   discretisation  the same settings with the finest value of the knob (beams, spacing, mesh)
//   overall         the finest mesh with a tick of 1 ms, whatever the run's own time step is
#pragma once

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "server/engine/scene/scene.h"

namespace acus {

struct Comparison {
  const char* kind;
  std::size_t with;  // index of the setting that is the reference: this one or one before it
};

// A run to make: what it is called and how it differs from the scene as it stands.
struct Setting {
  std::string knob, value;
  double h;  // s
  std::function<void(Scene&)> change;
  std::vector<Comparison> comparisons;
};

// A scene of the project and the values that its knobs get.
struct StudiedScene {
  const char* name;
  double pace;                            // by which its motion is made faster
  std::vector<double> steps;              // s, the shortest first
  std::vector<std::array<int, 3>> cells;  // of the box, the finest first; empty: the mesh is a file
  std::vector<int> beams;                 // of the first needle, the most first
  std::vector<double> spacings;           // m, of the first needle, the narrowest first
};

inline constexpr double kStandardStep = 1e-3;  // s, one of the steps of every scene

std::vector<StudiedScene> studied_scenes(bool quick);
std::vector<Setting> settings_of(const StudiedScene& studied);

}  // namespace acus
