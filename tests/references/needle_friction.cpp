// SPDX-License-Identifier: GPL-3.0-or-later
// The shaft as an elastic bar that distributed friction holds.
//
// Sources
//   Coulomb, before it slides as a whole (shear lag): a bar of stiffness EA held by the friction q per length slips
//   over the length F/q from where it is pulled by F, and is displaced there by u = F²/(2 EA q). Reversed after full
//   sliding it slips in both senses and doubles: u = F²/(4 EA q), F the change of force; H. L. Cox, Br. J. Appl.
//   Phys. 3 (1952) for shear lag, G. Masing, Proc. 2nd Int. Congr. Appl. Mech. (1926) for the doubling.
//   Viscous friction b per length: b u' = EA u_xx, diffusion. Displaced at its end by u_0, the free bar of length L
//   bears F = (2 EA u_0/L) sum over odd n of exp(-n² pi² t EA/(4 b L²)): K. Terzaghi's consolidation, in J. Crank, "The
//   Mathematics of Diffusion" (1975), eq. 4.17.
#include <numbers>

#include "server/engine/laws/solver/constraint_solver.h"
#include "tests/models/bench_needle.h"
#include "tests/references/figure.h"
#include "tests/references/rigid_ground.h"

namespace acus::test {
namespace {

constexpr double kPi = std::numbers::pi;

// Needle in rigid tissue: friction 20 N/m, a soft thick needle so that it stretches and does not buckle.
constexpr double kFriction = 20;  // N/m
Scene friction_scene(double spacing) {
  Scene scene = rigid_ground();
  Needle& needle = scene.needles[0];
  needle.outer_diameter = 4e-3;
  needle.material.young_modulus = 1e8;
  needle.beams = 100;
  needle.constraint_spacing = spacing;
  needle.smoothing = 5e-3;  // a base that stops at once makes the soft bar ring, and so slip back
  Interaction& law = scene.tissue.regions[0].interaction;
  law = {.puncture_force = 1e-3, .cutting_force = 0, .pressure = 1e3, .foundation_stiffness = {}};
  law.friction_static = law.friction_dynamic = kFriction / (kPi * needle.outer_diameter * 1e3);
  return scene;
}

// Displacement of the base (m) that changes its force by F (N), `a` of the bar being outside.
double masing(double f, double a, double axial) { return f * a / axial + f * f / (4 * axial * kFriction); }

TEST_CASE("a shaft whose motion is reversed follows Masing's parabola until it slides again") {
  const Scene scene = friction_scene(1e-3);
  const Needle& needle = scene.needles[0];
  const double axial = axial_stiffness(needle);
  Bench bench(scene);
  bench.push(0, 0.085, 0.2);
  bench.wait(0.1);
  const double depth = bench.needle().inserted_depth, outside = needle.length - depth, sliding = kFriction * depth;
  CHECK(agrees("friction, sliding force / q D", 1, bench.resistance() / sliding, 1e-7));

  const double before = bench.resistance();
  double moved = 0;
  for (const double share : {0.25, 0.5, 0.75, 1.0}) {  // of the reversal
    const double change = share * 2 * sliding, to = masing(change, outside, axial);
    bench.push(0, -(to - moved), 4e-4);
    bench.wait(0.1);
    moved = to;
    CHECK(agrees("friction, reversal to " + std::to_string(share) + ", change of force / 2 q D", share,
                 (before - bench.resistance()) / (2 * sliding), 0.002));
  }
  bench.push(0, -2e-4, 2e-3);
  bench.wait(0.1);
  CHECK(agrees("friction, pulled on, sliding force / q D", -1,
               bench.resistance() / (kFriction * bench.needle().inserted_depth), 1e-7));
  CHECK(bench.flags() == 0);
}

// What holds a bar at a node that stands for `owned` metres of it, in ticks of h.
using HoldingLaw = Law (*)(double owned, double h);

// A bar without inertia to speak of, held along its whole length by one row at each node, and pulled at its base.
class HeldBar {
 public:
  static constexpr int kBeams = 50;

  HeldBar(HoldingLaw law, double h)
      : law_(law),
        h_(h),
        model_(make_model()),
        state_(make_needle_state(model_, {})),
        motion_(model_, h, kBeams),
        solver_(kBeams) {}

  static double axial() { return make_model().stiffness.axial; }  // EA (N)
  static double length() { return make_model().length; }          // m

  // One tick with the base at x (m); the force at the base (N).
  double tick(double x) {
    motion_.begin(state_, {{x, 0, 0}, Quaternion::Identity()});
    motion_.linearize(state_);
    motion_.clear_rows();
    std::vector<Law> laws;
    std::vector<int> places;
    std::vector<double> gap, lambda(kBeams), delta(kBeams);
    for (int i = 1; i <= kBeams; ++i) {
      Vector12 along = Vector12::Zero();
      along[6] = 1;
      places.push_back(motion_.add_row(i - 1, along));
      laws.push_back(law_(model_.beam_length() * (i == kBeams ? 0.5 : 1), h_));
      gap.push_back(motion_.shape().x(0, i) - state_.x(0, i) + motion_.free_displacement(places.back()));
    }
    MatrixX W = MatrixX::Zero(kBeams, kBeams);
    motion_.add_compliances(places, W);
    W = MatrixX(W.selfadjointView<Eigen::Lower>());
    solver_.solve(LawMethod::direct, W, laws, gap, 1000, 1e-9, lambda, delta);
    motion_.correct(lambda);
    motion_.commit(state_);
    return motion_.base_reaction()[0];
  }

 private:
  static NeedleModel make_model() {
    NeedleBody body = bench_body();
    body.beams = kBeams;
    body.material.young_modulus = 1e7;
    body.material.density = 1e-3;
    return make_needle_model(body, Vector3::Zero());
  }

  HoldingLaw law_;
  double h_;
  NeedleModel model_;
  NeedleState state_;
  NeedleMotion motion_;
  ConstraintSolver solver_;
};

TEST_CASE("a bar pulled out of rest slips over F/q: u = F²/(2 EA q)") {
  constexpr double q = 1;  // N/m
  HeldBar bar([](double owned, double) { return Law{LawKind::friction, q * owned}; }, 1e-3);
  const double sliding = q * HeldBar::length();
  const double at_base =
      0.5 / HeldBar::kBeams;  // the half beam that node 0 stands for, whose friction its holder bears
  double x = 0;
  for (const double share : {0.2, 0.5, 0.8, 1.0}) {  // of the force at which all of it slides
    const double to = std::pow(share * sliding, 2) / (2 * HeldBar::axial() * q);
    double force = 0;
    for (int i = 1; i <= 20; ++i) force = bar.tick(x + i / 20.0 * (to - x));
    x = to;
    CHECK(agrees("friction, pulled to F/(q L) = " + std::to_string(share), share, force / sliding + at_base, 1e-8));
  }
  CHECK(agrees("friction, pulled on, F/(q L)", 1, bar.tick(2 * x) / sliding + at_base, 3e-6));
}

// Share of the force EA u_0/L at t, in units of b L²/EA.
double diffusion(double t) {
  double sum = 0;
  for (int n = 1; n < 200; n += 2) sum += 2 * std::exp(-n * n * kPi * kPi * t / 4);
  return sum;
}

TEST_CASE("a bar with viscous friction relaxes by diffusion, in the end with the time constant 4 b L²/(pi² EA)") {
  constexpr double b = 100;     // N s/m²
  constexpr int kTicks = 1000;  // in the time of diffusion
  const double time = b * HeldBar::length() * HeldBar::length() / HeldBar::axial();
  HeldBar bar([](double owned, double h) { return Law{LawKind::friction, 0, b * owned / h}; }, time / kTicks);
  const double aside = 1e-4, unit = HeldBar::axial() * aside / HeldBar::length();
  double before = 0;
  for (int i = 1; i <= kTicks; ++i) {
    const double share = bar.tick(aside) / unit;
    if (i % 200 == 0 || i == 50) {
      const double t = static_cast<double>(i) / kTicks;
      CHECK(agrees("relaxation, t EA/(b L²) = " + std::to_string(t) + ", F L/(EA u_0)", diffusion(t), share,
                   0.01 * diffusion(t)));
    }
    if (i == kTicks) {
      // Backward Euler: 1/(1 + h/tau) per tick.
      const double constant = 1 / ((before / share - 1) * kTicks);
      CHECK(agrees("relaxation, time constant EA/(b L²)", 4 / (kPi * kPi), constant, 1e-4));
    }
    before = share;
  }
}

}  // namespace
}  // namespace acus::test
