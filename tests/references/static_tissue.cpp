// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/references/static_tissue.h"

#include <doctest/doctest.h>

#include <Eigen/IterativeLinearSolvers>

#include "server/engine/models/geometry/material_point.h"
#include "server/engine/models/tissue/rest_stiffness.h"

namespace acus {
namespace {

using ConjugateGradients = Eigen::ConjugateGradient<SparseMatrix, Eigen::Lower>;

VectorX solve_lower(const SparseMatrix& lower, const VectorX& rhs) {
  ConjugateGradients solver;
  solver.setTolerance(1e-12);
  solver.setMaxIterations(5000);
  solver.compute(lower);
  const VectorX solution = solver.solve(rhs);
  REQUIRE(solver.info() == Eigen::Success);
  return solution;
}

VectorX at_free_nodes(const TissueModel& model, const Matrix3X& nodal) {
  VectorX free(model.unknowns());
  for (std::size_t f = 0; f < model.free_nodes.size(); ++f)
    free.segment<3>(3 * static_cast<int>(f)) = nodal.col(model.free_nodes[f]);
  return free;
}

void move_free_nodes(const TissueModel& model, const VectorX& by, Matrix3X& x) {
  for (std::size_t f = 0; f < model.free_nodes.size(); ++f)
    x.col(model.free_nodes[f]) += by.segment<3>(3 * static_cast<int>(f));
}

// Gauss-Legendre of three points on [0, 1].
constexpr double kGauss[] = {0.11270166537925831, 0.5, 0.88729833462074169};
constexpr double kGaussWeight[] = {5.0 / 18, 8.0 / 18, 5.0 / 18};

}  // namespace

TetrahedralMesh make_cube(int cells, double jitter) {
  TetrahedralMesh mesh = make_box_mesh(Vector3::Constant(2), {cells, cells, cells});
  Random random(static_cast<unsigned>(cells));
  for (int i = 0; i < mesh.node_count(); ++i)
    if (!on_cube(mesh.nodes.col(i))) mesh.nodes.col(i) += random.vector(jitter * 2 / cells);
  build_topology(mesh);
  return mesh;
}

bool on_cube(const Vector3& p) { return p.cwiseAbs().maxCoeff() > 1 - 1e-9; }

Matrix3X solve_linear(const TissueModel& model, const VectorField& boundary, const Matrix3X& load) {
  Matrix3X x = model.mesh->nodes, forces(3, model.nodes());
  for (const int node : model.fixed_nodes) x.col(node) += boundary(model.mesh->nodes.col(node));
  Matrix3X displacement;
  RestStiffness(model).forces(x, displacement, forces);
  ElementRotations rotations(model);
  SparseMatrix stiffness;
  TissueAssembler(model).assemble(x, rotations, Tangent::rest, {.stiffness = 1}, stiffness);
  move_free_nodes(model, solve_lower(stiffness, at_free_nodes(model, load - forces)), x);
  return x;
}

Matrix3X solve_corotational(const TissueModel& model, Matrix3X start, const Matrix3X& load) {
  const TissueAssembler assembler(model);
  Matrix3X forces(3, model.nodes());
  ElementRotations rotations(model);
  SparseMatrix hessian;
  double moved = 1;
  for (int iteration = 0; iteration < 20 && moved > 1e-11; ++iteration) {
    elastic_forces(model, start, rotations, forces);
    assembler.assemble(start, rotations, Tangent::exact, {.stiffness = 1}, hessian);
    const VectorX step = solve_lower(hessian, at_free_nodes(model, load - forces));
    move_free_nodes(model, step, start);
    moved = step.cwiseAbs().maxCoeff();
  }
  REQUIRE(moved <= 1e-11);
  return start;
}

void for_each_point(const TetrahedralMesh& mesh, int tetrahedron,
                    const std::function<void(const QuadraturePoint&)>& f) {
  const auto& nodes = mesh.tetrahedra[static_cast<std::size_t>(tetrahedron)];
  const double volume = rest_volume(mesh, tetrahedron);
  // The cube onto the tetrahedron: (1 - a), a (1 - b), a b (1 - c), a b c with the Jacobian 6 V a² b.
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      for (int k = 0; k < 3; ++k) {
        const double a = kGauss[i], b = kGauss[j], c = kGauss[k];
        QuadraturePoint p;
        p.corners = {1 - a, a * (1 - b), a * b * (1 - c), a * b * c};
        p.volume = 6 * volume * a * a * b * kGaussWeight[i] * kGaussWeight[j] * kGaussWeight[k];
        p.place.setZero();
        for (int n = 0; n < 4; ++n) p.place += p.corners[n] * mesh.nodes.col(nodes[static_cast<std::size_t>(n)]);
        f(p);
      }
}

Matrix3X body_load(const TetrahedralMesh& mesh, const VectorField& force) {
  Matrix3X load = Matrix3X::Zero(3, mesh.node_count());
  for (int t = 0; t < mesh.tetrahedron_count(); ++t)
    for_each_point(mesh, t, [&](const QuadraturePoint& p) {
      const Vector3 at_point = p.volume * force(p.place);
      for (int n = 0; n < 4; ++n)
        load.col(mesh.tetrahedra[static_cast<std::size_t>(t)][static_cast<std::size_t>(n)]) += p.corners[n] * at_point;
    });
  return load;
}

FieldErrors field_errors(const TetrahedralMesh& mesh, const Matrix3X& x, const VectorField& displacement,
                         const MatrixField& gradient) {
  double u_error = 0, u_size = 0, g_error = 0, g_size = 0;
  for (int t = 0; t < mesh.tetrahedron_count(); ++t) {
    const auto& nodes = mesh.tetrahedra[static_cast<std::size_t>(t)];
    const Eigen::Matrix<double, 3, 4> shapes = shape_gradients(mesh, mesh.nodes, t);
    Eigen::Matrix<double, 3, 4> u;
    for (int n = 0; n < 4; ++n)
      u.col(n) = x.col(nodes[static_cast<std::size_t>(n)]) - mesh.nodes.col(nodes[static_cast<std::size_t>(n)]);
    const Matrix3 found = u * shapes.transpose();
    for_each_point(mesh, t, [&](const QuadraturePoint& p) {
      const Vector3 exact = displacement(p.place);
      const Matrix3 exact_gradient = gradient(p.place);
      u_error += p.volume * (u * p.corners - exact).squaredNorm();
      u_size += p.volume * exact.squaredNorm();
      g_error += p.volume * (found - exact_gradient).squaredNorm();
      g_size += p.volume * exact_gradient.squaredNorm();
    });
  }
  return {std::sqrt(u_error / u_size), std::sqrt(g_error / g_size)};
}

}  // namespace acus
