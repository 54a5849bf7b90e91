// SPDX-License-Identifier: GPL-3.0-or-later
// Dents: their shape, and that together they displace places as far as they should.
#include "server/engine/models/unresolved/dent.h"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <vector>

namespace acus::test {
namespace {

const LoadRadii kRadii{1e-3, 5e-3};

TEST_CASE("a dent is whole at its centre, falls off without a turn and hardly reaches beyond twice the mesh's radius") {
  const Dent dent{{1, 2, 3}, {0, 0, -4e-3}, kRadii};
  CHECK(dent.share({1, 2, 3}) == doctest::Approx(1).epsilon(1e-12));
  double before = 1;
  for (double rho = 1e-4; rho < 0.05; rho *= 1.1) {
    const double share = dent.share({1, 2 + rho, 3});
    CHECK(share > 0);
    CHECK(share < before);
    before = share;
  }
  CHECK(dent.share({1, 2 + 2 * kRadii.outer, 3}) < 0.05);
  // (R² - r²)/(2 rho³) over 1/r - 1/R, far away.
  CHECK(dent.share({1, 3, 3}) == doctest::Approx(12e-6 / 800).epsilon(1e-3).scale(0));
}

TEST_CASE("a dent is the load over r less the load over R") {
  const auto regularised = [](double rho, double radius) { return 1 / std::hypot(rho, radius); };
  const Dent dent{Vector3::Zero(), Vector3::UnitZ(), kRadii};
  for (const double rho : {0.0, 0.5e-3, 2e-3, 9e-3}) {
    const double share =
        (regularised(rho, 1e-3) - regularised(rho, 5e-3)) / (regularised(0, 1e-3) - regularised(0, 5e-3));
    CHECK(dent.share({rho, 0, 0}) == doctest::Approx(share).epsilon(1e-12).scale(0));
  }
}

TEST_CASE("dents side by side displace each centre by what is wanted there") {
  std::vector<Dent> dents;
  std::vector<Vector3> wanted;
  for (int i = 0; i < 6; ++i) {
    dents.push_back({{0.006 * i, 0.002 * (i % 3), 0}, Vector3::Zero(), {0.5e-3 * (1 + i % 3), 6e-3}});
    wanted.push_back({1e-4 * i, 0, -2e-3 - 5e-4 * (i % 2)});
  }
  set_moves(wanted, dents);
  for (std::size_t i = 0; i < dents.size(); ++i)
    CHECK((displacement(dents, dents[i].centre) - wanted[i]).norm() < 2e-5);
}

TEST_CASE("two displacements that are wanted at one place make no large moves") {
  std::array<Dent, 2> dents{Dent{Vector3::Zero(), {}, kRadii}, Dent{Vector3(1e-4, 0, 0), {}, {0.5e-3, 4e-3}}};
  const std::array<Vector3, 2> wanted{Vector3(0, 0, -3e-3), Vector3(0, 0, 1e-3)};
  set_moves(wanted, dents);
  for (std::size_t i = 0; i < 2; ++i) CHECK(dents[i].move.norm() <= 2 * wanted[i].norm() * (1 + 1e-12));
}

TEST_CASE("two dents at one place share what is wanted there") {
  std::array<Dent, 2> dents{Dent{Vector3::Zero(), {}, kRadii}, Dent{Vector3::Zero(), {}, {0.5e-3, 4e-3}}};
  const std::array<Vector3, 2> wanted{Vector3(0, 0, -1e-3), Vector3(0, 0, -1e-3)};
  set_moves(wanted, dents);
  CHECK((displacement(dents, Vector3::Zero()) - wanted[0]).norm() < 1e-15);
}

}  // namespace
}  // namespace acus::test
