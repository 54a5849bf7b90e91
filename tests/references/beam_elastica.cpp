// SPDX-License-Identifier: GPL-3.0-or-later
// Plane bending of a cantilever far beyond small angles.
//
// Sources
//   K. E. Bisshopp, D. C. Drucker, "Large deflection of cantilever beams", Q. Appl. Math. 3 (1945), Fig. 2: tip
//     deflection w and shortening u of the inextensible elastica under a dead transverse force P at its end.
//   K. Mattiasson, "Numerical results from large deflection beam and frame problems analysed by means of elliptic
//     integrals", Int. J. Numer. Meth. Engng 17 (1981), Table I: the same with the slope of the tip, five digits.
//   Circle: a couple M at the end bends an elastica of stiffness EI to the radius EI/M.
//
// The needle can stretch, by P/EA = 3e-5 of its length at the largest load here.
#include "tests/models/bench_needle.h"
#include "tests/references/figure.h"

namespace acus {
namespace {

NeedleModel cantilever(int beams) {
  NeedleBody body = bench_body();
  body.beams = beams;
  return make_needle_model(body, Vector3::Zero());
}

// Mattiasson 1981, Table I: P L²/EI, u/L, w/L, slope of the tip (rad).
struct Elastica {
  double load, shortening, deflection, slope;
};
constexpr Elastica kMattiasson[] = {{1, 0.05643, 0.30172, 0.46135}, {2, 0.16064, 0.49346, 0.78175},
                                    {3, 0.25442, 0.60325, 0.98602}, {4, 0.32894, 0.66996, 1.12124},
                                    {5, 0.38763, 0.71379, 1.21537}, {6, 0.43459, 0.74457, 1.28370},
                                    {7, 0.47293, 0.76737, 1.33496}, {8, 0.50483, 0.78498, 1.37443},
                                    {9, 0.53182, 0.79906, 1.40547}, {10, 0.55500, 0.81061, 1.43029}};

Elastica loaded_cantilever(int beams, double load) {
  const NeedleModel model = cantilever(beams);
  const double force = load * model.stiffness.bending / (model.length * model.length);
  const NeedleState state = find_equilibrium(model, {}, tip_load(model, {0, force, 0}, Vector3::Zero())).state;
  const Vector3 tip = state.x.col(beams) / model.length, tangent = state.q.back() * Vector3::UnitX();
  return {load, 1 - tip.x(), tip.y(), std::atan2(tangent.y(), tangent.x())};
}

TEST_CASE("a cantilever under an end force meets Mattiasson's table up to P L²/EI = 10") {
  constexpr double kTolerance = 1e-4;  // -, of the length; rad
  for (const Elastica& expected : kMattiasson) {
    const Elastica found = loaded_cantilever(100, expected.load);
    const std::string load = "elastica, P L²/EI = " + std::to_string(static_cast<int>(expected.load));
    CHECK(agrees(load + ", u/L", expected.shortening, found.shortening, kTolerance));
    CHECK(agrees(load + ", w/L", expected.deflection, found.deflection, kTolerance));
    CHECK(agrees(load + ", slope", expected.slope, found.slope, kTolerance));
  }
}

TEST_CASE("the elastica at P L²/EI = 10 is approached with order two in the beams' length") {
  // Against the model's own limit, extrapolated, as five digits of a table and the stretch hide the finest errors.
  double tip[3];
  for (int i = 0; i < 3; ++i) tip[i] = loaded_cantilever(20 << i, 10).deflection;
  const double order = observed_order(tip[0] - tip[1], tip[1] - tip[2]);
  CHECK(agrees("elastica, order in beam length", 2, order, 0.1));
  CHECK(agrees("elastica, P L²/EI = 10, w/L extrapolated", 0.81061, tip[2] + (tip[2] - tip[1]) / 3, 5e-5));
}

// Half the angle between the ends of a beam that bears the couple M alone. Its chord keeps its length and its ends make
// equal angles with it, so that dE/dt2 of beam_element.h reads 2 EI/L (3 sin a - sin 2a) = M.
double half_angle(const BeamStiffness& s, double couple) {
  double a = couple * s.length / (2 * s.bending);
  for (int i = 0; i < 20; ++i) {
    const double residual = 2 * s.bending / s.length * (3 * std::sin(a) - std::sin(2 * a)) - couple;
    a -= residual / (2 * s.bending / s.length * (3 * std::cos(a) - 2 * std::cos(2 * a)));
  }
  return a;
}

// Nodes on the polygon of beams that each turn by 2a, and the largest distance from it.
double off_polygon(const NeedleModel& model, const NeedleState& state, double a) {
  Vector3 node = Vector3::Zero();
  double off = 0;
  for (int i = 1; i < model.nodes(); ++i) {
    const double direction = (2 * i - 1) * a;
    node += model.beam_length() * Vector3(std::cos(direction), std::sin(direction), 0);
    off = std::max(off, (state.x.col(i) - node).norm());
  }
  return off;
}

TEST_CASE("an end moment rolls a needle up twice") {
  double distance[2];  // -, of the tip from the clamp, of the length: closed circles
  for (int i = 0; i < 2; ++i) {
    const NeedleModel model = cantilever(i == 0 ? 40 : 80);
    const double couple = 4 * std::numbers::pi * model.stiffness.bending / model.length;
    const NeedleState state = find_equilibrium(model, {}, tip_load(model, Vector3::Zero(), {0, 0, couple}), 40).state;
    const double off = off_polygon(model, state, half_angle(model.stiffness, couple)) / model.length;
    CHECK(agrees("rolled up twice, distance from the discrete polygon / L", 0, off, 1e-9));
    distance[i] = state.x.col(model.beams).norm() / model.length;
  }
  CHECK(agrees("rolled up twice, 80 beams, tip from clamp / L", 0, distance[1], 6e-3));
  CHECK(agrees("rolled up twice, order in beam length", 2, observed_order(distance[0], distance[1]), 0.1));
}

}  // namespace
}  // namespace acus
