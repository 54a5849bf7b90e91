// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/tick/insertion/tip_laws.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace acus {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

// Tilted from the normal.
Vector3 tilted(double degrees) { return {std::sin(degrees * kDegree), 0, -std::cos(degrees * kDegree)}; }

Needle with_tip(TipShape tip) {
  Needle needle;
  needle.tip = tip;
  return needle;
}

TEST_CASE("a blunt tip, and any that is pushed straight, punctures at f_p and has the friction of the surface") {
  for (const double tilt : {0.0, 30.0, 80.0}) {
    const TipFriction blunt = tip_friction(with_tip(TipShape::blunt), tilted(tilt), Vector3::UnitZ(), 0.3);
    CHECK(blunt.friction == 0.3);
    CHECK(blunt.puncture_share == 1);
  }
  CHECK(tip_friction(with_tip(TipShape::bevel), tilted(0), Vector3::UnitZ(), 0.3).puncture_share == 1);
}

TEST_CASE("a sharp tip that is tilted punctures at f_p along the needle, and sticks until its face lies flat") {
  for (const TipShape tip : {TipShape::bevel, TipShape::pencil, TipShape::trocar}) {
    const double flat = 90 - *face_angle(with_tip(tip)) / kDegree;
    for (const double tilt : {15.0, 45.0, flat - 2.1}) {
      const TipFriction found = tip_friction(with_tip(tip), tilted(tilt), Vector3::UnitZ(), 0.3);
      CHECK(found.puncture_share == doctest::Approx(std::cos(tilt * kDegree)));
      CHECK(found.friction > std::tan(tilt * kDegree));
    }
    CHECK(tip_friction(with_tip(tip), tilted(flat + 2.1), Vector3::UnitZ(), 0.3).friction == 0.3);
    CHECK(tip_friction(with_tip(tip), tilted(flat - 2.1), Vector3::UnitZ(), 20).friction == 20);
  }
}

TEST_CASE("a sharp tip whose face comes to lie flat lets go over some degrees, not at one") {
  for (const TipShape tip : {TipShape::bevel, TipShape::pencil, TipShape::trocar}) {
    TipFriction before = tip_friction(with_tip(tip), tilted(0), Vector3::UnitZ(), 0.3);
    double largest = 0;
    for (double tilt = 0; tilt < 90; tilt += 0.01) {
      const TipFriction found = tip_friction(with_tip(tip), tilted(tilt), Vector3::UnitZ(), 0.3);
      CHECK(found.friction <= before.friction);
      largest =
          std::max({largest, before.friction - found.friction, std::abs(found.puncture_share - before.puncture_share)});
      before = found;
    }
    CHECK(before.friction == 0.3);
    CHECK(before.puncture_share == 1);
    CHECK(largest < 0.02);
  }
}

TEST_CASE("a tip ground nearly to a needle's line has the friction of a surface that it lies along or leaves") {
  Needle thin = with_tip(TipShape::bevel);
  thin.tip_angle = 0.01;
  for (const double tilt : {90.0, 91.0, 120.0}) {
    const TipFriction found = tip_friction(thin, tilted(tilt), Vector3::UnitZ(), 0.3);
    CHECK(found.friction == doctest::Approx(0.3));
    CHECK(found.puncture_share == doctest::Approx(1));
  }
}

TEST_CASE("a tip that is drawn off does not bite, and a scene may say how it is ground") {
  CHECK(tip_friction(with_tip(TipShape::bevel), tilted(180), Vector3::UnitZ(), 0.3).puncture_share == 1);
  Needle short_bevel = with_tip(TipShape::bevel);
  short_bevel.tip_angle = 17 * kDegree;
  CHECK(tip_friction(short_bevel, tilted(75), Vector3::UnitZ(), 0.3).friction == 0.3);
  CHECK(tip_friction(with_tip(TipShape::bevel), tilted(75), Vector3::UnitZ(), 0.3).friction > 4);
}

}  // namespace
}  // namespace acus
