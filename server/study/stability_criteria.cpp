// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/study/stability_criteria.h"

#include <algorithm>
#include <cmath>

namespace acus {

namespace {

void raise(Peak& peak, double value, std::size_t tick) {
  if (value > peak.value) peak = {value, tick};
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

// Increments that oppose the one before, up to tick k.
int opposed(std::span<const Vector3> f, std::size_t k) { return (f[k] - f[k - 1]).dot(f[k - 1] - f[k - 2]) < 0; }

// The least increment of the window that ends with tick k, over the mean force there.
double window_share(std::span<const Vector3> f, std::size_t k, double least_force) {
  double least = kInfinity, sum = 0;
  for (std::size_t i = k + 1 - kAlternations; i <= k; ++i) {
    least = std::min(least, (f[i] - f[i - 1]).norm());
    sum += f[i].norm();
  }
  return least / std::max(sum / kAlternations, least_force);
}

bool excused(const StabilitySeries& series, std::size_t tick) {
  const std::size_t from = tick > kExcused ? tick - kExcused : 0;
  for (std::size_t k = from; k <= tick && k < series.ticks(); ++k)
    if (series.flags[k] & kTroubles) return true;
  return false;
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

Peak alternation(std::span<const Vector3> force) {
  Peak peak;
  const double most = largest_norm(force);
  if (most < kLeastForce) return peak;
  int run = 1;  // increments in a row of which each opposes the one before
  for (std::size_t k = 2; k < force.size(); ++k) {
    run = opposed(force, k) ? run + 1 : 1;
    if (run >= kAlternations) raise(peak, window_share(force, k, kLeastShare * most), k);
  }
  return peak;
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
  for (const auto& force : series.forces) {
    const Peak peak = alternation(force);
    raise(f.alternation, peak.value, peak.tick);
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

const char* name_of(Outcome outcome) {
  constexpr const char* kNames[] = {"sound", "flagged", "refused", "failed"};
  return kNames[static_cast<int>(outcome)];
}

Verdict judge(const StabilitySeries& series, const StabilityFigures& f, double residual_tolerance,
              const StabilityLimits& limits) {
  Verdict verdict;
  const auto exceeded = [&](const char* what, bool is_excused) {
    verdict.why += (verdict.why.empty() ? "" : "; ") + std::string(what);
    verdict.outcome = std::max(verdict.outcome, is_excused ? Outcome::flagged : Outcome::failed);
  };
  const auto check = [&](const char* what, const Peak& peak, double limit) {
    if (!(peak.value <= limit)) exceeded(what, excused(series, peak.tick));
  };
  if (!series.finite) exceeded("not finite", false);
  check("residual", f.residual, residual_tolerance);
  check("energy gain", f.gain, limits.gain);
  if (f.gain.value > limits.flagged_gain) exceeded("energy without bound", false);
  check("energy rises at rest", f.rise, limits.rise);
  check("alternating force", f.alternation, limits.alternation);
  if (series.unseen_inversion) exceeded("inverted elements", false);
  const bool returns = f.left <= limits.left || f.swing > limits.swing;
  if (series.withdrawn && !returns) exceeded("tissue does not return", excused(series, series.ticks() - 1));
  return verdict;
}

}  // namespace acus
