// SPDX-License-Identifier: GPL-3.0-or-later
// What a run must show to count as stable. Measures over its ticks 0 ... n-1, each with the tick at which it is worst:
//
// - available energy A_k = T_k + U_k + V_k - W_k: kinetic, elastic and potential energy less the work of the bases
//   since the start, W_k = -sum over ticks and needles of F (x_k - x_{k-1}) + M (turn in the tick). F (N) and M (N m)
//   are the needle's on its holder, x its base. Friction, cutting and damping only take from A.
// - scale: the largest of |T + U + V - (T + U + V)_0| and |W| of the run, at least kLeastEnergy.
// - gain: max_k (A_k - A_0) / scale, energy from nowhere, over the whole run.
// - rise: max over ticks j < k of the rest of (A_k - A_j) / scale. At rest A does not rise.
// - alternation of a force f (N, vector), with d_k = f_k - f_{k-1}: over every window of kAlternations increments of
//   which each opposes the one before, d_k . d_{k-1} < 0, the least |d| over the mean |f| there, but no less than
//   kLeastShare of the run's largest |f|. The largest of all windows and forces.
// - return: the largest distance of a node from where it was before the needle came (of a tissue without supports:
//   after the rigid motion that fits best), at the end, over the largest of the run.
// - swing: the largest kinetic energy of the last quarter since the needle left, over the largest since then. Soft and
//   heavy tissue swings longer than a run lasts; tissue that is caught somewhere stands still.
// - smallest volume of an element, over its volume at rest.
//
// A tick is told of where a flag of kTroubles was set in it or in the kExcused ticks before it. What exceeds a limit
// there makes the run "flagged", elsewhere "failed"; a run with such a flag is never "sound". Nothing excuses a number
// that is not finite, a residual in a tick that does not own up to it, an inversion that the next tick does not tell of
// (rung `linear` aside, whose elements do not know), or a gain above flagged_gain. A run that never touches the tissue,
// or whose needle stays in touch with it, shows little: it fails unless its cases say that it may (Expected) or, of a
// needle that stays, the last tick is told of; the verdict names it all the same.
//
// Limits in StabilityLimits.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "server/engine/state/report.h"
#include "server/engine/tick/simulation.h"

namespace acus {

inline constexpr double kLeastEnergy = 1e-6;  // J
inline constexpr int kAlternations = 6;
inline constexpr double kLeastShare = 0.05;
inline constexpr double kLeastForce = 1e-4;     // N, of a run's largest force, to be looked at
inline constexpr double kLeastDistance = 1e-5;  // m, of a run's largest distance from rest

// What a run leaves behind, per tick.
struct StabilitySeries {
  std::vector<double> stored;                // J, T + U + V
  std::vector<double> kinetic;               // J, T
  std::vector<double> work;                  // J, W
  std::vector<std::vector<Vector3>> forces;  // N, base and tip of every needle, one series each
  std::vector<double> distance;              // m, of the tissue from rest, largest node
  std::vector<double> residual;              // N, of the laws
  std::vector<std::uint32_t> flags;
  bool finite = true;             // every number reported, and the energy
  double smallest_volume = 1;     // -, of all elements and ticks
  bool unseen_inversion = false;  // an element was inverted and the next tick did not say so
  std::size_t rest = 0;           // first tick of the rest
  double deepest = 0;             // m, most of a needle that was inside
  std::ptrdiff_t intrusions = 0;  // tips found inside without path or contact
  bool touched = false;           // a needle did, in some tick
  bool withdrawn = false;         // no needle touched the tissue in one of the last kLeastRest ticks
  std::size_t last_inside = 0;    // last tick in which a needle was in the tissue
  double seconds = 0;             // of processor time in the ticks

  std::size_t ticks() const { return flags.size(); }
};

struct Peak {
  double value = 0;
  std::size_t tick = 0;
};

Peak energy_gain(std::span<const double> stored, std::span<const double> work);
Peak energy_rise(std::span<const double> stored, std::span<const double> work, std::size_t from);
// Of the ticks that are not to be `left_out`; empty: of all.
Peak alternation(std::span<const Vector3> force, const std::vector<bool>& left_out = {});
// Ticks that are told of.
std::vector<bool> told_of(std::span<const std::uint32_t> flags);
double swing(std::span<const double> kinetic);  // of the ticks since the needle left
// Of the ticks without kLawsNotConverged.
Peak unflagged_residual(std::span<const double> residual, std::span<const std::uint32_t> flags);

struct StabilityFigures {
  Peak gain, rise, alternation, residual;
  double untold_alternation = 0;  // of the ticks that are not told of
  double excused = 0;             // share of the ticks that are told of
  double left = 0;                // return
  double swing = 0;
  double largest_force = 0;   // N
  double largest_energy = 0;  // J, scale
};
StabilityFigures measure(const StabilitySeries& series);

struct StabilityLimits {
  double gain = 0.02;
  double flagged_gain = 0.9;  // not excused by any flag: nine tenths of the energy came from nowhere
  double rise = 1e-3;
  double alternation = 0.1;
  double left = 0.02;
  double swing = 0.01;  // above it the tissue is on its way
};

// What a run may leave out.
struct Expected {
  bool touch = true;     // a needle touches the tissue
  bool come_out = true;  // none does to the end; tissue that swings may hit a needle that is out
};

enum class TrialOutcome { sound, flagged, refused, failed };
struct Verdict {
  TrialOutcome outcome = TrialOutcome::sound;
  std::string why;  // every limit that is exceeded, whether most ticks excuse it, or the error

  bool pass() const { return outcome != TrialOutcome::failed; }
};
const char* name_of(TrialOutcome outcome);

// Flags that own up to a trouble.
inline constexpr std::uint32_t kTroubles =
    kLawsNotConverged | kNewtonNotConverged | kTangentProjected | kNotFinite | kStepLimited | kElementsInverted |
    kForcesUnbalanced | kEnergyGained | kNeedleOverstrained;
inline constexpr std::size_t kExcused = 100;
inline constexpr double kMostTicks = 0.5;  // a share of told ticks above it is named in Verdict::why

Verdict judge(const StabilitySeries& series, const StabilityFigures& figures, double residual_tolerance,
              const Expected& expected = {}, const StabilityLimits& limits = {});

}  // namespace acus
