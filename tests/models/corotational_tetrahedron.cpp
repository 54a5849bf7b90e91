// SPDX-License-Identifier: GPL-3.0-or-later
// The corotational tetrahedron: polar rotation against Eigen's singular value decomposition, forces and tangents
// against differences, balance, lanes against the single element, and what happens when it collapses.
#include "server/engine/models/element/corotational_energy.h"

#include <doctest/doctest.h>

#include "server/engine/math/random.h"
#include "tests/models/bench_tissue.h"
#include "tests/support/dense.h"

namespace acus {
namespace {

using Matrix12x = Eigen::Matrix<double, 12, 12>;
using Vector12x = Eigen::Matrix<double, 12, 1>;
using Nodes = Eigen::Matrix<double, 3, 4>;

constexpr double kPi = std::numbers::pi;

struct Tetrahedron {
  TetrahedronShape<double> shape;
  Nodes rest;
  double q[4] = {1, 0, 0, 0};

  explicit Tetrahedron(Random& random) {
    TetrahedralMesh mesh;
    do {
      mesh.nodes = random.matrix(3, 4);
      mesh.tetrahedra = {{0, 1, 2, 3}};
    } while (rest_volume(mesh, 0) < 0.1);
    build_topology(mesh);
    Material material;
    material.young_modulus = 3;
    material.poisson_ratio = 0.3;
    shape = bench_tissue(mesh, material).elements[0];
    rest = mesh.nodes;
  }

  // A rotated, strained and shifted copy of the rest shape; the warm start is up to 0.5 rad off.
  Nodes deform(Random& random, double strain) {
    const Quaternion rotation = random.rotation();
    const MatrixX g = random.matrix(3, 3, strain);
    const Matrix3 stretch = Matrix3::Identity() + 0.5 * (g + g.transpose());
    warm(rotation * random.rotation(0.5));
    return (rotation.toRotationMatrix() * stretch * rest).colwise() + random.vector();
  }
  void warm(const Quaternion& r) { q[0] = r.w(), q[1] = r.x(), q[2] = r.y(), q[3] = r.z(); }

  Vector12x forces(const Nodes& x) {
    double local[4][3], force[4][3], turned[4] = {q[0], q[1], q[2], q[3]};
    for (int k = 0; k < 12; ++k) local[k / 3][k % 3] = x(k % 3, k / 3);
    corotational_forces(shape, local, turned, force);
    Vector12x f;
    for (int k = 0; k < 12; ++k) f[k] = force[k / 3][k % 3];
    return f;
  }
  double energy(const Nodes& x) const {
    double local[4][3];
    for (int k = 0; k < 12; ++k) local[k / 3][k % 3] = x(k % 3, k / 3);
    return corotational_energy(shape, local, q);
  }
  Matrix12x tangent(const Nodes& x, bool exact) const {
    double local[4][3];
    for (int k = 0; k < 12; ++k) local[k / 3][k % 3] = x(k % 3, k / 3);
    return corotational_tangent(shape, local, q, exact);
  }
};

Nodes step(const Nodes& x, int coordinate, double by) {
  Nodes moved = x;
  moved(coordinate % 3, coordinate / 3) += by;
  return moved;
}

// The rotation of F, by the decomposition under test and by Eigen.
Matrix3 polar(const Matrix3& f, const Quaternion& warm) {
  double raw[3][3], q[4] = {warm.w(), warm.x(), warm.y(), warm.z()}, r[3][3], s[3][3];
  for (int k = 0; k < 9; ++k) raw[k / 3][k % 3] = f(k / 3, k % 3);
  polar_rotation(raw, q, r, s);
  Matrix3 result;
  for (int k = 0; k < 9; ++k) result(k / 3, k % 3) = r[k / 3][k % 3];
  return result;
}

Matrix3 polar_oracle(const Matrix3& f) { return test::polar_decomposition(f).rotation; }

TEST_CASE("the polar rotation is that of the singular value decomposition") {
  Random random(1);
  for (int repeat = 0; repeat < 500; ++repeat) {
    const Quaternion rotation = random.rotation(), axes = random.rotation();
    const Vector3 stretch(random.uniform(0.4, 2), random.uniform(0.4, 2), random.uniform(0.4, 2));
    const Matrix3 f = rotation.toRotationMatrix() * axes.toRotationMatrix() * stretch.asDiagonal() *
                      axes.toRotationMatrix().transpose();
    CHECK((polar(f, rotation * random.rotation(1.5)) - polar_oracle(f)).norm() < 1e-12);
  }
}

TEST_CASE("the polar rotation is found from far away") {
  Random random(2);
  for (int repeat = 0; repeat < 500; ++repeat) {
    const Matrix3 f = random.rotation(0.95 * kPi).toRotationMatrix() * (Matrix3::Identity() + random.matrix(3, 3, 0.1));
    CHECK((polar(f, Quaternion::Identity()) - polar_oracle(f)).norm() < 1e-12);
  }
}

TEST_CASE("tetrahedron forces are the gradient of the energy") {
  Random random(3);
  for (int repeat = 0; repeat < 20; ++repeat) {
    Tetrahedron t(random);
    const Nodes x = t.deform(random, 0.3);
    const Vector12x forces = t.forces(x);
    for (int i = 0; i < 12; ++i) {
      const double difference = (t.energy(step(x, i, 1e-5)) - t.energy(step(x, i, -1e-5))) / 2e-5;
      CHECK(std::abs(difference - forces[i]) < 1e-8 * (1 + forces.norm()));
    }
  }
}

TEST_CASE("the exact tangent is the derivative of the forces") {
  Random random(4);
  for (int repeat = 0; repeat < 20; ++repeat) {
    Tetrahedron t(random);
    const Nodes x = t.deform(random, 0.3);
    const Matrix12x k = t.tangent(x, true);
    CHECK((k - k.transpose()).norm() < 1e-13 * k.norm());
    for (int i = 0; i < 12; ++i) {
      const Vector12x difference = (t.forces(step(x, i, 1e-5)) - t.forces(step(x, i, -1e-5))) / 2e-5;
      CHECK((difference - k.col(i)).norm() < 1e-9 * k.norm());
    }
  }
}

TEST_CASE("the turned tangent is the rest stiffness in the element's rotation, and semidefinite") {
  Random random(5);
  for (int repeat = 0; repeat < 10; ++repeat) {
    Tetrahedron t(random);
    const Matrix12x k0 = t.tangent(t.rest, true);
    CHECK((t.tangent(t.rest, false) - k0).norm() < 1e-12 * k0.norm());
    const Nodes x = t.deform(random, 0.3);
    double f[3][3], local[4][3];
    for (int k = 0; k < 12; ++k) local[k / 3][k % 3] = x(k % 3, k / 3);
    deformation_gradient(t.shape, local, f);
    Matrix3 gradient;
    for (int k = 0; k < 9; ++k) gradient(k / 3, k % 3) = f[k / 3][k % 3];
    Matrix12x turn = Matrix12x::Zero();
    for (int k = 0; k < 12; k += 3) turn.block<3, 3>(k, k) = polar_oracle(gradient);
    const Matrix12x turned = t.tangent(x, false);
    CHECK((turned - turn * k0 * turn.transpose()).norm() < 1e-11 * k0.norm());
    CHECK(test::eigenvalues(turned)[0] > -1e-12 * k0.norm());
  }
}

TEST_CASE("a rotated tetrahedron carries no force") {
  Random random(6);
  for (int repeat = 0; repeat < 50; ++repeat) {
    Tetrahedron t(random);
    const Nodes x = t.deform(random, 0);
    CHECK(t.forces(x).norm() < 1e-13);
    CHECK(t.energy(x) < 1e-27);
  }
}

TEST_CASE("the forces on a tetrahedron balance") {
  Random random(7);
  for (int repeat = 0; repeat < 50; ++repeat) {
    Tetrahedron t(random);
    const Nodes x = t.deform(random, 0.5);
    const Vector12x f = t.forces(x);
    Vector3 sum = Vector3::Zero(), moment = Vector3::Zero();
    for (int k = 0; k < 4; ++k) {
      sum += f.segment<3>(3 * k);
      moment += Vector3(x.col(k)).cross(Vector3(f.segment<3>(3 * k)));
    }
    CHECK(sum.norm() < 1e-14 * (1 + f.norm()));
    CHECK(moment.norm() < 1e-12 * (1 + f.norm()));
  }
}

void set_lane(int lane, const Tetrahedron& t, const Nodes& x, TetrahedronShape<Octet>& shape, Octet (&local)[4][3],
              Octet (&q)[4]) {
  for (int k = 0; k < 9; ++k) shape.gradient[k / 3][k % 3][lane] = t.shape.gradient[k / 3][k % 3];
  shape.volume[lane] = t.shape.volume;
  shape.law.mu[lane] = t.shape.law.mu;
  shape.law.lambda[lane] = t.shape.law.lambda;
  for (int k = 0; k < 12; ++k) local[k / 3][k % 3][lane] = x(k % 3, k / 3);
  for (int k = 0; k < 4; ++k) q[k][lane] = t.q[k];
}

TEST_CASE("lanes of one element or of eight give what each gives alone") {
  Random random(8);
  for (const bool same : {true, false}) {
    for (int repeat = 0; repeat < 20; ++repeat) {
      std::vector<Tetrahedron> elements;
      std::vector<Nodes> positions;
      TetrahedronShape<Octet> shape;
      Octet position[4][3], turn[4];
      for (int lane = 0; lane < kLanes; ++lane) {
        if (same && lane > 0) {
          elements.push_back(elements[0]);
          positions.push_back(positions[0]);
        } else {
          elements.emplace_back(random);
          positions.push_back(elements.back().deform(random, 0.1 * lane));
        }
        set_lane(lane, elements.back(), positions.back(), shape, position, turn);
      }
      Lanes local[4][3], q[4], lanes[4][3];
      for (int k = 0; k < 12; ++k) local[k / 3][k % 3] = position[k / 3][k % 3];
      for (int k = 0; k < 4; ++k) q[k] = turn[k];
      corotational_forces(shape, local, q, lanes);
      Octet force[4][3];
      for (int k = 0; k < 12; ++k) lanes[k / 3][k % 3].store(force[k / 3][k % 3].at);
      for (int lane = 0; lane < kLanes; ++lane) {
        const auto i = static_cast<std::size_t>(lane);
        const Vector12x alone = elements[i].forces(positions[i]);
        // Rounding of the forces is relative to stress times area, not to the small force of a nearly rigid turn.
        for (int k = 0; k < 12; ++k)
          CHECK(std::abs(force[k / 3][k % 3][lane] - alone[k]) < 1e-14 * (10 + alone.norm()));
      }
    }
  }
}

TEST_CASE("flattened, inverted and collapsed tetrahedra keep a finite force and a unit rotation") {
  Random random(9);
  const Matrix3 gradients[] = {Matrix3::Zero(),
                               Vector3(1, 0, 0).asDiagonal(),
                               Vector3(1, 1, 0).asDiagonal(),
                               Vector3(1, 1, -1).asDiagonal(),
                               Vector3(-1, -1, -1).asDiagonal(),
                               Vector3(1, 1, -1e-9).asDiagonal(),
                               Vector3(1e-200, 1e-200, 1e-200).asDiagonal(),
                               Vector3(1e3, 1e-3, -1e3).asDiagonal()};
  for (const Matrix3& f : gradients) {
    for (int repeat = 0; repeat < 20; ++repeat) {
      Tetrahedron t(random);
      t.warm(random.rotation());
      const Nodes x = random.rotation().toRotationMatrix() * f * t.rest;
      CAPTURE(f);
      const Vector12x force = t.forces(x);
      CHECK(force.allFinite());
      CHECK(force.norm() < 1e3 * (1 + f.norm()));
      CHECK(std::isfinite(t.energy(x)));
      CHECK(t.tangent(x, false).allFinite());
      const Matrix3 r = polar(random.rotation().toRotationMatrix() * f, random.rotation());
      CHECK((r.transpose() * r - Matrix3::Identity()).norm() < 1e-13);
      CHECK(r.determinant() > 0.9);
    }
  }
}

}  // namespace
}  // namespace acus
