// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/study/studies/stability_criteria.h"

#include <algorithm>
#include <cmath>

namespace acus {

namespace {

// What is no number is the largest of all.
void raise(Peak& peak, double value, std::size_t tick) {
  if (value > peak.value || std::isnan(value)) peak = {value, tick};
}

double energy_scale(std::span<const double> stored, std::span<const double> work) {
  double scale = kLeastEnergy;
  for (std::size_t k = 0; k < stored.size(); ++k)
    scale = std::max({scale, std::abs(stored[k] - stored[0]), std::abs(work[k])});
  return scale;
}

double largest(std::span<const double> values) { return values.empty() ? 0 : *std::ranges::max_element(values); }

double largest_norm(std::span<const Vector3> vectors) {
  double most = 0;
  for (const Vector3& v : vectors) most = std::max(most, v.norm());
  return most;
}

// The increment of tick k opposes the one before.
bool opposed(std::span<const Vector3> f, std::size_t k) { return (f[k] - f[k - 1]).dot(f[k - 1] - f[k - 2]) < 0; }

// The least increment of the window that ends with tick k, over the mean force there.
double window_share(std::span<const Vector3> f, std::size_t k, double least_force) {
  double least = kInfinity, sum = 0;
  for (std::size_t i = k + 1 - kAlternations; i <= k; ++i) {
    least = std::min(least, (f[i] - f[i - 1]).norm());
    sum += f[i].norm();
  }
  return least / std::max(sum / kAlternations, least_force);
}

bool any(std::span<const std::uint32_t> flags, std::uint32_t wanted) {
  return std::ranges::any_of(flags, [=](std::uint32_t f) { return (f & wanted) != 0; });
}

}  // namespace

Peak energy_gain(std::span<const double> stored, std::span<const double> work) {
  Peak peak;
  const double scale = energy_scale(stored, work);
  for (std::size_t k = 0; k < stored.size(); ++k) raise(peak, (stored[k] - stored[0] - work[k]) / scale, k);
  return peak;
}

Peak energy_rise(std::span<const double> stored, std::span<const double> work, std::size_t from) {
  Peak peak;
  const double scale = energy_scale(stored, work);
  double least = kInfinity;
  for (std::size_t k = from; k < stored.size(); ++k) {
    const double available = stored[k] - work[k];
    least = std::min(least, available);
    raise(peak, (available - least) / scale, k);
  }
  return peak;
}

Peak alternation(std::span<const Vector3> force, const std::vector<bool>& left_out) {
  Peak peak;
  const double most = largest_norm(force);
  if (most < kLeastForce) return peak;
  int run = 1;  // increments in a row of which each opposes the one before
  for (std::size_t k = 2; k < force.size(); ++k) {
    run = opposed(force, k) ? run + 1 : 1;
    const bool counts = left_out.empty() || !left_out[k];
    if (run >= kAlternations && counts) raise(peak, window_share(force, k, kLeastShare * most), k);
  }
  return peak;
}

std::vector<bool> told_of(std::span<const std::uint32_t> flags) {
  std::vector<bool> told;
  std::size_t since = kExcused + 1;  // ticks since the last trouble
  for (const std::uint32_t f : flags) {
    since = f & kTroubles ? 0 : since + 1;
    told.push_back(since <= kExcused);
  }
  return told;
}

Peak unflagged_residual(std::span<const double> residual, std::span<const std::uint32_t> flags) {
  Peak peak;
  for (std::size_t k = 0; k < residual.size(); ++k)
    if (!(flags[k] & kLawsNotConverged)) raise(peak, residual[k], k);
  return peak;
}

double swing(std::span<const double> kinetic) {
  const double most = largest(kinetic);
  return most > 0 ? largest(kinetic.last(kinetic.size() / 4)) / most : 0;
}

StabilityFigures measure(const StabilitySeries& series) {
  StabilityFigures f;
  f.gain = energy_gain(series.stored, series.work);
  f.rise = energy_rise(series.stored, series.work, series.rest);
  f.residual = unflagged_residual(series.residual, series.flags);
  const std::vector<bool> told = told_of(series.flags);
  f.excused =
      static_cast<double>(std::ranges::count(told, true)) / static_cast<double>(std::max<std::size_t>(told.size(), 1));
  for (const auto& force : series.forces) {
    const Peak peak = alternation(force);
    raise(f.alternation, peak.value, peak.tick);
    f.untold_alternation = std::max(f.untold_alternation, alternation(force, told).value);
    f.largest_force = std::max(f.largest_force, largest_norm(force));
  }
  f.largest_energy = energy_scale(series.stored, series.work);
  const double most = largest(series.distance);
  if (most < kLeastDistance) return f;
  f.left = series.distance.back() / most;
  // Ticks in which the base still moves may have a needle that is faster than any tissue.
  const std::size_t from = std::min(std::max(series.last_inside + 1, series.rest), series.ticks());
  f.swing = swing(std::span(series.kinetic).subspan(from));
  return f;
}

const char* name_of(TrialOutcome outcome) {
  constexpr const char* kNames[] = {"sound", "flagged", "refused", "failed"};
  return kNames[static_cast<int>(outcome)];
}

Verdict judge(const StabilitySeries& series, const StabilityFigures& f, double residual_tolerance,
              const Expected& expected, const StabilityLimits& limits) {
  Verdict verdict;
  const std::vector<bool> told = told_of(series.flags);
  const auto add = [&](const std::string& what) { verdict.why += (verdict.why.empty() ? "" : "; ") + what; };
  const auto check = [&](const char* what, bool holds, bool excused = false) {
    if (holds) return;
    add(what);
    verdict.outcome = std::max(verdict.outcome, excused ? TrialOutcome::flagged : TrialOutcome::failed);
  };
  if (any(series.flags, kTroubles)) verdict.outcome = TrialOutcome::flagged;
  check("not finite", series.finite && !any(series.flags, kNotFinite));
  check("residual", f.residual.value <= residual_tolerance);
  check("energy gain", f.gain.value <= limits.gain, told[f.gain.tick]);
  check("energy without bound", f.gain.value <= limits.flagged_gain);
  check("energy rises at rest", f.rise.value <= limits.rise, told[f.rise.tick]);
  check("alternating force", f.alternation.value <= limits.alternation, f.untold_alternation <= limits.alternation);
  check("inverted elements", !series.unseen_inversion);
  const auto note = [&](const char* what, bool holds, bool must_hold, bool excused = false) {
    if (must_hold) return check(what, holds, excused);
    if (!holds) add(what);
  };
  note("needle never touches the tissue", series.touched, expected.touch);
  note("needle does not come out", series.withdrawn || !series.touched, expected.come_out, told.back());
  const bool returns = f.left <= limits.left || f.swing > limits.swing;
  check("tissue does not return", returns || !series.withdrawn, told.back());
  if (verdict.outcome == TrialOutcome::flagged && !verdict.why.empty() && f.excused > kMostTicks)
    add("most ticks are flagged");
  return verdict;
}

}  // namespace acus
