// SPDX-License-Identifier: GPL-3.0-or-later
// Equilibrium of a block of tissue under prescribed displacements of its fixed nodes and loads on its free ones, by
// solvers that the server does not use: conjugate gradients on the assembled stiffness. And integrals over its
// elements.
#pragma once

#include <functional>

#include "server/engine/math/random.h"
#include "tests/models/bench_tissue.h"

namespace acus {

using VectorField = std::function<Vector3(const Vector3&)>;
using MatrixField = std::function<Matrix3(const Vector3&)>;

// A cube of edge 2 m around the origin, `cells` along each edge; `jitter` is how far nodes inside are moved at random,
// of a cell.
TetrahedralMesh make_cube(int cells, double jitter);
bool on_cube(const Vector3& p);

// Positions (m) in equilibrium, small displacements: K0 (x - X) = load (N, 3 x nodes) at the free nodes; the fixed ones
// are displaced by `boundary` (m).
Matrix3X solve_linear(const TissueModel& model, const VectorField& boundary, const Matrix3X& load);

// The same with the corotational forces, by Newton's method on the exact Hessian, from the start given (m).
Matrix3X solve_corotational(const TissueModel& model, Matrix3X start, const Matrix3X& load);

// Points and weights (m³) of a rule of degree five in a tetrahedron; barycentric weights of the corners.
struct QuadraturePoint {
  Eigen::Vector4d corners;
  Vector3 place;
  double volume;
};
void for_each_point(const TetrahedralMesh& mesh, int tetrahedron, const std::function<void(const QuadraturePoint&)>& f);

// Nodal loads of a force per volume (N/m³): integrals of N_a b.
Matrix3X body_load(const TetrahedralMesh& mesh, const VectorField& force);

// Integrals over the cube of the squared errors of displacement (m) and its gradient (-), as roots, relative to those
// of the exact fields.
struct FieldErrors {
  double displacement, gradient;
};
FieldErrors field_errors(const TetrahedralMesh& mesh, const Matrix3X& x, const VectorField& displacement,
                         const MatrixField& gradient);

}  // namespace acus
