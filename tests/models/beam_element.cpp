// SPDX-License-Identifier: GPL-3.0-or-later
// The beam element: forces and tangents against differences of the energy, balance, frame invariance, and the textbook
// stiffness where it is straight.
#include "server/engine/models/needle/beam_element.h"

#include <doctest/doctest.h>

#include "server/engine/math/random.h"
#include "server/engine/math/rotation.h"
#include "tests/support/dense.h"

namespace acus {
namespace {

constexpr BeamStiffness kStiffness{0.5, 7, 0.3, 0.2};

struct Beam {
  BeamEnd a, b;

  // Moves the generalised coordinates (x1, theta1, x2, theta2) by dq.
  Beam moved(const Vector12& dq) const {
    Beam m = *this;
    m.a.position += dq.segment<3>(0);
    m.a.frame = rotation_exp(dq.segment<3>(3)) * a.frame;
    m.b.position += dq.segment<3>(6);
    m.b.frame = rotation_exp(dq.segment<3>(9)) * b.frame;
    return m;
  }
  Beam carried(const Pose& motion) const {
    const Matrix3 turn = motion.orientation.toRotationMatrix();
    return {{motion * a.position, turn * a.frame}, {motion * b.position, turn * b.frame}};
  }

  double energy() const { return beam_energy(kStiffness, a, b); }
  Vector12 forces() const { return beam_forces(kStiffness, a, b); }
  Matrix12 tangent() const { return beam_tangent(kStiffness, a, b); }
  Matrix12 material_tangent() const { return beam_material_tangent(kStiffness, a, b); }
};

Beam straight(const Pose& pose) {
  const Matrix3 frame = pose.orientation.toRotationMatrix();
  return {{pose.position, frame}, {pose * Vector3(kStiffness.length, 0, 0), frame}};
}

// Bent, twisted and stretched by a good deal more than a beam of a needle ever is.
std::vector<Beam> deformed_beams() {
  Random random(1);
  std::vector<Beam> beams;
  for (int i = 0; i < 10; ++i) {
    Vector12 dq = random.matrix(12, 1, 0.6);
    dq.segment<3>(0) *= 0.1;
    dq.segment<3>(6) *= 0.1;
    beams.push_back(straight({random.vector(), random.rotation()}).moved(dq));
  }
  return beams;
}

// d²Psi/dq_i dq_j by central differences of step h.
double second_difference(const Beam& beam, int i, int j, double h) {
  const auto energy = [&](double along_i, double along_j) {
    Vector12 dq = Vector12::Zero();
    dq[i] += along_i;
    dq[j] += along_j;
    return beam.moved(dq).energy();
  };
  return (energy(h, h) - energy(h, -h) - energy(-h, h) + energy(-h, -h)) / (4 * h * h);
}

// The columns are the six rigid motions: three translations, three turns about the origin.
Eigen::Matrix<double, 12, 6> rigid_motions(const Beam& beam) {
  Eigen::Matrix<double, 12, 6> motions = Eigen::Matrix<double, 12, 6>::Zero();
  for (int k = 0; k < 2; ++k) {
    motions.block<3, 3>(6 * k, 0).setIdentity();
    motions.block<3, 3>(6 * k, 3) = -skew(k == 0 ? beam.a.position : beam.b.position);
    motions.block<3, 3>(6 * k + 3, 3).setIdentity();
  }
  return motions;
}

TEST_CASE("beam forces are the gradient of the energy") {
  for (const Beam& beam : deformed_beams()) {
    const Vector12 forces = beam.forces();
    for (int i = 0; i < 12; ++i) {
      const Vector12 step = 1e-5 * Vector12::Unit(i);
      const double difference = (beam.moved(step).energy() - beam.moved(-step).energy()) / 2e-5;
      CHECK(std::abs(difference - forces[i]) < 1e-8 * forces.norm());
    }
  }
}

TEST_CASE("the beam tangent is the Hessian of the energy") {
  for (const Beam& beam : deformed_beams()) {
    const Matrix12 k = beam.tangent();
    const double scale = k.cwiseAbs().maxCoeff();
    CHECK((k - k.transpose()).cwiseAbs().maxCoeff() < 1e-14 * scale);
    for (int i = 0; i < 12; ++i)
      for (int j = 0; j <= i; ++j) {
        // Richardson extrapolation takes the error of order h² out.
        const double coarse = second_difference(beam, i, j, 2e-3), fine = second_difference(beam, i, j, 1e-3);
        CAPTURE(i);
        CAPTURE(j);
        CHECK(std::abs((4 * fine - coarse) / 3 - k(i, j)) < 1e-8 * scale);
      }
  }
}

TEST_CASE("forces and moments on a beam balance") {
  for (const Beam& beam : deformed_beams()) {
    const Vector12 f = beam.forces();
    const Vector3 f1 = f.segment<3>(0), m1 = f.segment<3>(3), f2 = f.segment<3>(6), m2 = f.segment<3>(9);
    CHECK((f1 + f2).norm() < 1e-14 * f.norm());
    CHECK((m1 + m2 + (beam.b.position - beam.a.position).cross(f2)).norm() < 1e-13 * f.norm());
  }
}

TEST_CASE("a rigid motion changes no energy and turns forces and stiffness along") {
  Random random(2);
  for (const Beam& beam : deformed_beams()) {
    const Pose motion{random.vector(3), random.rotation()};
    const Beam carried = beam.carried(motion);
    CHECK(carried.energy() == doctest::Approx(beam.energy()).epsilon(1e-12));
    Matrix12 turn = Matrix12::Zero();
    for (int k = 0; k < 12; k += 3) turn.block<3, 3>(k, k) = motion.orientation.toRotationMatrix();
    CHECK((carried.forces() - turn * beam.forces()).norm() < 1e-12 * beam.forces().norm());
    const Matrix12 turned = turn * beam.tangent() * turn.transpose();
    CHECK((carried.tangent() - turned).norm() < 1e-12 * turned.norm());
    const Matrix12 turned_material = turn * beam.material_tangent() * turn.transpose();
    CHECK((carried.material_tangent() - turned_material).norm() < 1e-12 * turned_material.norm());
  }
}

TEST_CASE("the material tangent is positive semidefinite and lets rigid motions, and only these, pass") {
  for (const Beam& beam : deformed_beams()) {
    const Matrix12 k = beam.material_tangent();
    const double scale = k.cwiseAbs().maxCoeff();
    CHECK((k * rigid_motions(beam)).cwiseAbs().maxCoeff() < 1e-13 * scale);
    const VectorX eigenvalues = test::eigenvalues(k);
    CHECK(eigenvalues[0] > -1e-13 * scale);
    CHECK(eigenvalues[6] > 1e-4 * scale);
  }
}

TEST_CASE("at rest energy and forces vanish and both tangents agree") {
  Random random(3);
  for (int repeat = 0; repeat < 5; ++repeat) {
    const Beam beam = straight({random.vector(), random.rotation()});
    CHECK(beam.energy() < 1e-28);
    CHECK(beam.forces().norm() < 1e-13);
    CHECK((beam.tangent() - beam.material_tangent()).norm() < 1e-12 * beam.tangent().norm());
  }
}

TEST_CASE("the straight beam has the stiffness of Euler and Bernoulli") {
  const Matrix12 k = straight({}).tangent();
  const auto [l, ea, ei, gj] = kStiffness;
  CHECK(k(0, 0) == doctest::Approx(ea / l));
  CHECK(k(3, 3) == doctest::Approx(gj / l));
  CHECK(k(3, 9) == doctest::Approx(-gj / l));
  CHECK(k(7, 7) == doctest::Approx(12 * ei / (l * l * l)));
  CHECK(k(7, 11) == doctest::Approx(-6 * ei / (l * l)));  // y2, theta_z2
  CHECK(k(8, 10) == doctest::Approx(6 * ei / (l * l)));   // z2, theta_y2
  CHECK(k(10, 10) == doctest::Approx(4 * ei / l));
  CHECK(k(4, 10) == doctest::Approx(2 * ei / l));
}

TEST_CASE("pure twist and pure stretch are exact at any size") {
  const auto [l, ea, ei, gj] = kStiffness;
  for (const double twist : {0.1, 1.0, 3.0}) {
    Vector12 dq = Vector12::Zero();
    dq[9] = twist;
    const Beam beam = straight({}).moved(dq);
    CHECK(beam.energy() == doctest::Approx(0.5 * gj / l * twist * twist).epsilon(1e-9).scale(0));
    CHECK(beam.forces()[9] == doctest::Approx(gj / l * twist));
  }
  Vector12 dq = Vector12::Zero();
  dq[6] = 0.2 * l;
  CHECK(straight({}).moved(dq).forces()[6] == doctest::Approx(0.2 * ea));
}

TEST_CASE("a beam bent to an arc carries EI times its curvature") {
  // Ends of a circular arc of opening angle a and chord L; slopes at the chord +- a/2.
  const auto [l, ea, ei, gj] = kStiffness;
  const double opening = 0.06;
  Vector12 dq = Vector12::Zero();
  dq[5] = -opening / 2;
  dq[11] = opening / 2;
  const Beam beam = straight({}).moved(dq);
  CHECK(beam.forces()[11] == doctest::Approx(ei * opening / l).epsilon(2e-3).scale(0));
  CHECK(beam.forces()[5] == doctest::Approx(-ei * opening / l).epsilon(2e-3).scale(0));
  CHECK(std::abs(beam.forces()[7]) < 1e-14);
}

}  // namespace
}  // namespace acus
