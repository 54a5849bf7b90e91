// SPDX-License-Identifier: GPL-3.0-or-later
// Backward Euler against its own exact recurrence, to rounding, and against the differential equation, with order one.
// Oscillators of one degree of freedom are made of the server's models: a single tetrahedron on three fixed corners
// that moves along its height or across, and a needle of a single beam that stretches or twists. Its equation
//
//   m x'' + (alpha m + beta k) x' + k x = 0
//
// becomes, with b = alpha m + beta k (server/MODEL.md, "Time stepping"),
//
//   (m/h² + b/h + k) x_1 = (m/h² + b/h) x_0 + (m/h) v_0,   v_1 = (x_1 - x_0)/h.
//
// Sources
//   E. Hairer, G. Wanner, "Solving Ordinary Differential Equations II" (1996), sec. IV.3: implicit Euler, order one.
//   L. Meirovitch, "Fundamentals of Vibrations" (2001), eq. 2.26: the damped oscillator's free response.
//   Kelvin-Voigt: with alpha = 0 and no inertia the strain relaxes as exp(-t/beta), in ticks as (1 + h/beta)^-n.
//   Free fall: x_n = g h² n (n + 1)/2 = g t (t + h)/2; with drag alpha m the speed g (1 - exp(-alpha t))/alpha.
#include <doctest/doctest.h>

#include <numbers>

#include "server/engine/math/rotation.h"
#include "tests/models/bench_needle.h"
#include "tests/models/bench_tissue.h"
#include "tests/models/motions.h"
#include "tests/references/figure.h"

namespace acus {
namespace {

struct Oscillator {
  double m, k, alpha, beta;

  double b() const { return alpha * m + beta * k; }
};

struct Motion {
  double x, v;
};

Motion recurrence(const Oscillator& o, double h, const Motion& s) {
  const double drag = o.m / (h * h) + o.b() / h;
  const double x = (drag * s.x + o.m / h * s.v) / (drag + o.k);
  return {x, (x - s.x) / h};
}

// x(t) from x(0) = 1 at rest, underdamped.
double free_response(const Oscillator& o, double t) {
  const double decay = o.b() / (2 * o.m), w = std::sqrt(o.k / o.m - decay * decay);
  return std::exp(-decay * t) * (std::cos(w * t) + decay / w * std::sin(w * t));
}

// A tetrahedron with three fixed corners in the plane z = 0 and one at the height kEdge above the first.
constexpr double kEdge = 0.02;  // m
TetrahedralMesh single_tetrahedron() {
  TetrahedralMesh mesh;
  mesh.nodes.resize(3, 4);
  mesh.nodes << 0, kEdge, 0, 0, 0, 0, kEdge, 0, 0, 0, 0, kEdge;
  mesh.tetrahedra = {{0, 1, 2, 3}};
  build_topology(mesh);
  return mesh;
}

Material damped_material() {
  Material material = undamped_material();
  material.rayleigh_mass = 3;
  material.rayleigh_stiffness = 2e-4;
  return material;
}

// Of the free corner: a quarter of the mass; V (2 mu + lambda)/height² along the height, V mu/height² across.
Oscillator tetrahedron_oscillator(const Material& m, bool along) {
  const double volume = kEdge * kEdge * kEdge / 6, mu = m.young_modulus / (2 * (1 + m.poisson_ratio));
  const double lambda = 2 * mu * m.poisson_ratio / (1 - 2 * m.poisson_ratio);
  return {m.density * volume / 4, volume * (along ? 2 * mu + lambda : mu) / (kEdge * kEdge), m.rayleigh_mass,
          m.rayleigh_stiffness};
}

// The free corner's displacement after each tick, started at `x0` from rest; one unit along z or x.
std::vector<double> run_tetrahedron(TissueMatrix matrix, const Material& material, bool along, double h, int ticks,
                                    double x0) {
  const TetrahedralMesh mesh = single_tetrahedron();
  const TissueModel model = bench_tissue(mesh, material, [](const Vector3& p) { return p.z() < 1e-9; });
  const int axis = along ? 2 : 0;
  TissueState state = make_tissue_state(model);
  state.x(axis, 3) += x0;
  BenchMotion motion(model, h, matrix, 1, 1);
  std::vector<double> x;
  for (int i = 0; i < ticks; ++i) {
    motion.begin(state);
    for (int iteration = 0; iteration < 4; ++iteration) {  // the factor may be in single precision
      motion.linearize(state);
      motion.clear_rows();
      motion.correct({});
    }
    motion.commit(state);
    x.push_back(state.x(axis, 3) - mesh.nodes(axis, 3));
  }
  return x;
}

// The largest departure of a run from the recurrence, of the amplitude.
double off_recurrence(const Oscillator& o, double h, double x0, const std::vector<double>& x) {
  Motion s{x0, 0};
  double off = 0;
  for (const double found : x) {
    s = recurrence(o, h, s);
    off = std::max(off, std::abs(found - s.x) / std::abs(x0));
  }
  return off;
}

TEST_CASE("a tetrahedron swings by the recurrence of backward Euler, to rounding") {
  const Material material = damped_material();
  const struct {
    const char* name;
    TissueMatrix matrix;
    bool along;
  } cases[] = {{"constant, along", TissueMatrix::constant, true},
               {"constant, across", TissueMatrix::constant, false},
               {"turned, along", TissueMatrix::turned, true},
               {"refactorized, along", TissueMatrix::refactorized, true}};
  for (const auto& c : cases)
    for (const double h : {1e-4, 1e-3, 1e-2}) {
      const Oscillator o = tetrahedron_oscillator(material, c.along);
      const double off =
          off_recurrence(o, h, 0.2 * kEdge, run_tetrahedron(c.matrix, material, c.along, h, 300, 0.2 * kEdge));
      CHECK(agrees(std::string("tetrahedron, ") + c.name + ", h = " + std::to_string(h) + " s, off recurrence", 0, off,
                   1e-11));
    }
}

NeedleModel single_beam() {
  NeedleBody body = bench_body();
  body.beams = 1;
  body.material.young_modulus = 1e6;
  body.material.rayleigh_mass = 20;
  body.material.rayleigh_stiffness = 1e-4;
  return make_needle_model(body, Vector3::Zero());
}

Oscillator beam_oscillator(const NeedleModel& model, bool twist) {
  const BeamStiffness& s = model.stiffness;
  return {twist ? model.inertia_axial[1] : model.mass[1], (twist ? s.torsion : s.axial) / s.length, model.rayleigh_mass,
          model.rayleigh_stiffness};
}

// Stretch (m) or twist (rad) of the tip after each tick.
std::vector<double> run_beam(const NeedleModel& model, bool twist, double h, int ticks, double x0) {
  NeedleState state = make_needle_state(model, {});
  if (twist)
    state.q[1] = rotation_exp({x0, 0, 0});
  else
    state.x(0, 1) += x0;
  NeedleMotion motion(model, h, 1);
  std::vector<double> x;
  for (int i = 0; i < ticks; ++i) {
    motion.begin(state, {});
    for (int iteration = 0; iteration < 3; ++iteration) {
      motion.linearize(state);
      motion.clear_rows();
      motion.correct({});
    }
    motion.commit(state);
    x.push_back(twist ? rotation_log(state.q[1]).x() : state.x(0, 1) - model.length);
  }
  return x;
}

TEST_CASE("a beam stretches and twists by the recurrence of backward Euler, to rounding") {
  const NeedleModel model = single_beam();
  for (const bool twist : {false, true})
    for (const double h : {1e-5, 1e-4, 1e-2}) {
      const double x0 = twist ? 1.0 : 1e-3;
      const double off = off_recurrence(beam_oscillator(model, twist), h, x0, run_beam(model, twist, h, 300, x0));
      CHECK(agrees(
          std::string("beam, ") + (twist ? "twist" : "stretch") + ", h = " + std::to_string(h) + " s, off recurrence",
          0, off, 1e-10));
    }
}

TEST_CASE("tetrahedron and beam approach the differential equation with order one") {
  const Material material = damped_material();
  const NeedleModel beam = single_beam();
  const Oscillator oscillators[] = {tetrahedron_oscillator(material, true), beam_oscillator(beam, false),
                                    beam_oscillator(beam, true)};
  const char* names[] = {"tetrahedron", "beam, stretch", "beam, twist"};
  for (int body = 0; body < 3; ++body) {
    const Oscillator& o = oscillators[body];
    const double period = 2 * std::numbers::pi * std::sqrt(o.m / o.k), time = 0.8 * period;
    double error[2];
    for (int i = 0; i < 2; ++i) {
      const int ticks = 800 << i;
      const double x0 = body == 0 ? 1e-3 : body == 1 ? 1e-3 : 0.5, h = time / ticks;
      const std::vector<double> x = body == 0
                                        ? run_tetrahedron(TissueMatrix::refactorized, material, true, h, ticks, x0)
                                        : run_beam(beam, body == 2, h, ticks, x0);
      error[i] = std::abs(x.back() / x0 - free_response(o, time));
    }
    CHECK(error[1] < 0.01);
    CHECK(agrees(std::string("backward Euler, order in h, ") + names[body], 1, observed_order(error[0], error[1]),
                 0.008));
  }
}

TEST_CASE("Kelvin-Voigt: strain relaxes with the time constant beta") {
  Material material = undamped_material();
  material.density = 1e-6;  // no inertia to speak of
  material.rayleigh_stiffness = 0.05;
  constexpr double h = 1e-3;
  const std::vector<double> x = run_tetrahedron(TissueMatrix::refactorized, material, true, h, 100, 1e-3);
  const double per_tick = 1 / (1 + h / material.rayleigh_stiffness);
  double off = 0;
  for (std::size_t i = 0; i < x.size(); ++i)
    off = std::max(off, std::abs(x[i] / 1e-3 - std::pow(per_tick, static_cast<double>(i + 1))));
  CHECK(agrees("Kelvin-Voigt, off (1 + h/beta)^-n", 0, off, 1e-10));
  CHECK(agrees("Kelvin-Voigt, share left after 2 beta", std::exp(-2.0), x.back() / 1e-3, 0.003));
}

TEST_CASE("tissue without supports falls freely, and slower with drag") {
  const TetrahedralMesh mesh = make_box_mesh(Vector3::Constant(0.04), {2, 2, 2});
  const Vector3 gravity(2, -3, -9.81);
  constexpr double h = 1e-3, kTime = 0.2;  // s
  for (const TissueMatrix matrix : {TissueMatrix::constant, TissueMatrix::turned, TissueMatrix::refactorized})
    for (const double alpha : {0.0, 10.0}) {
      Material material = undamped_material();
      material.rayleigh_mass = alpha;
      material.rayleigh_stiffness = 0.01;
      const TissueModel model = bench_tissue(mesh, material, nullptr, gravity);
      TissueState state = make_tissue_state(model);
      BenchMotion motion(model, h, matrix, 1, 1);
      double fallen = 0, speed = 0, off = 0;  // of unit gravity: s², s
      for (int i = 0; i < 200; ++i) {
        motion.begin(state);
        for (int iteration = 0; iteration < 2; ++iteration) {
          motion.linearize(state);
          motion.clear_rows();
          motion.correct({});
        }
        motion.commit(state);
        speed = (speed + h) / (1 + alpha * h);
        fallen += h * speed;
        off = std::max(off,
                       (state.x - mesh.nodes - (fallen * gravity).replicate(1, model.nodes())).cwiseAbs().maxCoeff());
      }
      const std::string name = "free fall, matrix " + std::to_string(static_cast<int>(matrix)) + ", alpha " +
                               std::to_string(static_cast<int>(alpha));
      CHECK(agrees(name + ", off recurrence (m)", 0, off, 1e-9));
      if (alpha == 0) CHECK(agrees(name + ", height / g (s²)", kTime * (kTime + h) / 2, fallen, 1e-12));
      if (alpha > 0)
        CHECK(agrees(name + ", speed / g (s)", (1 - std::exp(-alpha * kTime)) / alpha, speed, 1e-3 * kTime));
    }
}

}  // namespace
}  // namespace acus
