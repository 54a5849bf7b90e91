// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/models/unresolved/dent.h"

#include <cassert>
#include <cmath>
#include <cstddef>

namespace acus {

namespace {

// Of Gauss-Seidel; dents that are 2 R apart need one.
constexpr int kSweeps = 4;
// In R, of a dent.
constexpr double kReach = 8;

double share_at(const LoadRadii& radii, double rho2) {
  const auto [r, R] = radii;
  return (1 / std::sqrt(rho2 + r * r) - 1 / std::sqrt(rho2 + R * R)) * (r * R / (R - r));
}

}  // namespace

double Dent::share(const Vector3& x) const {
  assert(!radii.resolved() && radii.inner > 0);
  return share_at(radii, (x - centre).squaredNorm());
}

Vector3 displacement(std::span<const Dent> dents, const Vector3& x) {
  Vector3 sum = Vector3::Zero();
  for (const Dent& dent : dents) {
    const double rho2 = (x - dent.centre).squaredNorm(), reach = kReach * dent.radii.outer;
    if (rho2 < reach * reach) sum += share_at(dent.radii, rho2) * dent.move;
  }
  return sum;
}

void set_moves(std::span<const Vector3> wanted, std::span<Dent> dents) {
  assert(wanted.size() == dents.size());
  for (Dent& dent : dents) dent.move.setZero();
  for (int sweep = 0; sweep < kSweeps; ++sweep)
    for (std::size_t i = 0; i < dents.size(); ++i) {
      const Vector3 move = dents[i].move + wanted[i] - displacement(dents, dents[i].centre);
      const double most = 2 * wanted[i].norm(), length = move.norm();
      dents[i].move = length > most ? Vector3(most / length * move) : move;
    }
}

}  // namespace acus
