// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/study/studies/locking.h"
#include "server/engine/models/unresolved/local_compliance.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "server/engine/math/factor/sparse_cholesky.h"
#include "server/engine/models/geometry/material_point.h"
#include "server/engine/models/tissue/tissue_assembler.h"
#include "server/engine/scene/scene.h"
#include "server/engine/scene/scene_fields.h"
#include "tests/study/studies/csv.h"

namespace acus {

namespace {

constexpr double kPoissonRatios[] = {0.3, 0.45, 0.49, 0.499};
constexpr double kEdge = 0.1;           // m, of the cube; length of the bar
constexpr double kThickness = 0.025;    // m, of the bar
constexpr double kNeedle = 1e-3;        // m, diameter
constexpr double kIrregularity = 0.15;  // of a cell
constexpr double kYoungModulus = 10e3;  // Pa; no measure depends on it

enum class Measure { line, vortex, bending };

// Cells across, coarse to fine. Those of the line are even, so that nodes are on it.
std::vector<int> cells_of(Measure measure, bool quick) {
  std::vector<int> cells;
  switch (measure) {
    case Measure::line:
      cells = {6, 10, 14, 20};
      break;
    case Measure::vortex:
      cells = {6, 9, 12, 16};
      break;
    case Measure::bending:
      cells = {2, 3, 4, 6};
      break;
  }
  if (quick) cells.resize(2);
  return cells;
}

struct Case {
  Measure measure;
  bool irregular;
  TissueElement element;
  int cells;
};

bool on_sides(const Vector3& p) { return p.head<2>().cwiseAbs().maxCoeff() > 0.5 * kEdge - 1e-9; }
bool on_surface(const Vector3& p, const Vector3& size) { return (p.cwiseAbs() - size / 2).maxCoeff() > -1e-9; }
bool on_line(const Vector3& p) { return p.head<2>().norm() < 1e-9; }

TetrahedralMesh make_mesh(const Case& c) {
  const bool bar = c.measure == Measure::bending;
  const Vector3 size = bar ? Vector3(kEdge, kThickness, kThickness) : Vector3::Constant(kEdge);
  TetrahedralMesh mesh = make_box_mesh(size, {bar ? 4 * c.cells : c.cells, c.cells, c.cells});
  if (!c.irregular) return mesh;
  std::mt19937 random(1);
  const double scale = kIrregularity * size.z() / c.cells * 2 / static_cast<double>(std::mt19937::max());
  for (int i = 0; i < mesh.node_count(); ++i) {
    auto node = mesh.nodes.col(i);
    if (on_surface(node, size) || (c.measure == Measure::line && on_line(node))) continue;
    for (double& x : node) x += scale * (static_cast<double>(random()) - 0.5 * std::mt19937::max());
  }
  build_topology(mesh);
  return mesh;
}

std::vector<bool> fixed_nodes(const Case& c, const TetrahedralMesh& mesh) {
  std::vector<bool> fixed;
  for (int i = 0; i < mesh.node_count(); ++i) {
    const Vector3 p = mesh.nodes.col(i);
    fixed.push_back(c.measure == Measure::line     ? on_sides(p)
                    : c.measure == Measure::vortex ? on_surface(p, Vector3::Constant(kEdge))
                                                   : false);
  }
  return fixed;
}

Material material_of(double poisson_ratio) {
  Material material;
  material.young_modulus = kYoungModulus;
  material.poisson_ratio = poisson_ratio;
  return material;
}

double shear_modulus(const Material& material) { return material.young_modulus / (2 * (1 + material.poisson_ratio)); }

// Forces on the nodes (3 x nodes), and their work on the exact displacement, NaN where that is not known.
struct Load {
  Matrix3X forces;
  double exact_work = std::numeric_limits<double>::quiet_NaN();
};

// 1 N/m along x on the line.
Load line_load(const TetrahedralMesh& mesh, int cells) {
  Load load{Matrix3X::Zero(3, mesh.node_count())};
  for (int i = 0; i < mesh.node_count(); ++i) {
    if (!on_line(mesh.nodes.col(i))) continue;
    const bool at_end = std::abs(mesh.nodes(2, i)) > kEdge / 2 - 1e-9;
    load.forces(0, i) = kEdge / cells * (at_end ? 0.5 : 1);
  }
  return load;
}

// The load per volume that holds the vortex, -G laplace(u), over G (1/m), and its work on u over G (m³).
struct Vortex {
  static constexpr double k = std::numbers::pi / kEdge;
  static constexpr double kWorkPerShear = 15.0 / 16 * kEdge * (kEdge * k) * (kEdge * k) * (kEdge * k) * (kEdge * k);

  static double square(double t) { return std::pow(std::sin(k * t), 2); }
  static double slope(double t) { return k * std::sin(2 * k * t); }
  static double bend(double t) { return 2 * k * k * std::cos(2 * k * t); }
  static double laplacian(double x, double y, double z) {  // of square(x) slope(y) square(z)
    return bend(x) * slope(y) * square(z) - 4 * k * k * square(x) * slope(y) * square(z) +
           square(x) * slope(y) * bend(z);
  }

  static Vector3 load(const Vector3& p) {
    return -kEdge * Vector3(laplacian(p.x(), p.y(), p.z()), -laplacian(p.y(), p.x(), p.z()), 0);
  }
};

Load vortex_load(const TetrahedralMesh& mesh, double shear) {
  Load load{Matrix3X::Zero(3, mesh.node_count()), shear * Vortex::kWorkPerShear};
  const double far = (5 - std::sqrt(5.0)) / 20, near = 1 - 3 * far;  // Gauss points of degree two
  for (int t = 0; t < mesh.tetrahedron_count(); ++t)
    for (int q = 0; q < 4; ++q) {
      Eigen::Vector4d weights = Eigen::Vector4d::Constant(far);
      weights[q] = near;
      const Vector3 p = material_position(mesh, mesh.nodes, {t, weights}).array() + kEdge / 2;
      const Vector3 force = shear * rest_volume(mesh, t) / 4 * Vortex::load(p);
      for (int k = 0; k < 4; ++k) load.forces.col(mesh.tetrahedra[t][k]) += weights[k] * force;
    }
  return load;
}

// Tractions E z along +-x on the ends, of a curvature of 1/m.
Load bending_load(const TetrahedralMesh& mesh) {
  Load load{Matrix3X::Zero(3, mesh.node_count()), kYoungModulus * std::pow(kThickness, 4) / 12 * kEdge};
  for (const auto& face : mesh.surface) {
    const Vector3 a = mesh.nodes.col(face[0]), b = mesh.nodes.col(face[1]), c = mesh.nodes.col(face[2]);
    const Vector3 area = (b - a).cross(c - a) / 2;
    if (std::abs(area.x()) < 0.5 * area.norm()) continue;
    for (const int node : face)
      load.forces(0, node) += kYoungModulus * area.x() / 12 * (a.z() + b.z() + c.z() + mesh.nodes(2, node));
  }
  return load;
}

Load load_of(const Case& c, const TetrahedralMesh& mesh, const Material& material) {
  switch (c.measure) {
    case Measure::line:
      return line_load(mesh, c.cells);
    case Measure::vortex:
      return vortex_load(mesh, shear_modulus(material));
    case Measure::bending:
      return bending_load(mesh);
  }
  return {};
}

// Holds a free body against rigid motions, in which its balanced load does no work: 1e-7 E per metre of its edge.
double inertia_factor(const TissueModel& model) {
  return model.fixed_nodes.empty() ? 1e-7 * kYoungModulus * kEdge / model.mass.sum() : 0;
}

// The work of a load on the displacement that it causes; the factor is analysed the first time.
double work_done(const TissueModel& model, const Load& load, SparseCholesky& factor) {
  ElementRotations unturned(model);
  SparseMatrix stiffness;
  TissueAssembler(model).assemble(model.mesh->nodes, unturned, Tangent::rest,
                                  {.mass = inertia_factor(model), .stiffness = 1}, stiffness);
  if (factor.size() == 0) factor.analyze(stiffness, 3);
  if (!factor.factorize(stiffness)) throw std::runtime_error("locking: a stiffness is not positive definite");
  factor.keep(Precision::double_precision);
  VectorX y(model.unknowns());
  for (int i = 0; i < model.unknowns(); ++i) y[factor.position(i)] = load.forces(i % 3, model.free_nodes[i / 3]);
  MatrixX panel_rows = factor.make_panel_rows();
  factor.forward(y, panel_rows);
  return y.squaredNorm();
}

// The edge of a regular tetrahedron of the mean volume (m), as the simulation has it.
double element_size(const TetrahedralMesh& mesh) {
  return std::cbrt(6 * std::numbers::sqrt2 * std::pow(kEdge, 3) / mesh.tetrahedron_count());
}

void add_rows(const Case& c, std::vector<LockingRow>& rows) {
  const TetrahedralMesh mesh = make_mesh(c);
  const std::vector<int> region(static_cast<std::size_t>(mesh.tetrahedron_count()), 0);
  SparseCholesky factor;
  for (const double poisson_ratio : kPoissonRatios) {
    const Material material = material_of(poisson_ratio);
    const TissueModel model =
        make_tissue_model(mesh, region, {&material, 1}, fixed_nodes(c, mesh), Vector3::Zero(), c.element);
    const Load load = load_of(c, mesh, material);
    const double work = work_done(model, load, factor);
    LockingRow row{"", c.irregular, c.element, poisson_ratio, c.cells, mesh.node_count(), factor.factor_entries()};
    if (c.measure == Measure::line) {
      const double scale = 4 * std::numbers::pi * shear_modulus(material);
      row.measure = "line";
      row.value = scale * work / kEdge;
      row.reference = std::numeric_limits<double>::quiet_NaN();
      rows.push_back(row);
      row.measure = "needle";
      row.value += scale * foundation_compliance(material, element_size(mesh), kNeedle);
    } else {
      row.measure = c.measure == Measure::vortex ? "vortex" : "bending";
      row.value = work / load.exact_work;
      row.reference = 1;
    }
    rows.push_back(row);
  }
}

// The finest mesh with nodal pressures is the reference of the others of its kind.
void set_needle_references(std::vector<LockingRow>& rows) {
  for (LockingRow& row : rows) {
    if (row.measure != "needle") continue;
    int finest = 0;
    for (const LockingRow& other : rows) {
      if (other.measure != row.measure || other.irregular != row.irregular ||
          other.poisson_ratio != row.poisson_ratio || other.element == TissueElement::linear || other.cells < finest)
        continue;
      finest = other.cells;
      row.reference = other.value;
    }
  }
}

}  // namespace

std::vector<LockingRow> locking_table(bool quick,
                                      const std::function<void(int done, int of, const std::string& next)>& progress) {
  std::vector<Case> cases;
  for (const Measure measure : {Measure::line, Measure::vortex, Measure::bending})
    for (const int cells : cells_of(measure, quick))
      for (const bool irregular : {false, true})
        for (const TissueElement element : {TissueElement::linear, TissueElement::nodal_pressure})
          cases.push_back({measure, irregular, element, cells});
  std::vector<LockingRow> rows;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    progress(static_cast<int>(i), static_cast<int>(cases.size()),
             "locking, " + std::to_string(cases[i].cells) + " cells, " + name_of(cases[i].element));
    add_rows(cases[i], rows);
  }
  set_needle_references(rows);
  return rows;
}

void study_locking(const StudyPlan& plan) {
  CsvFile file(plan.out + "/locking.csv", {"measure", "mesh", "element", "poisson_ratio", "cells", "nodes",
                                           "factor_entries", "value", "reference", "error"});
  for (const LockingRow& row : locking_table(plan.quick, plan.progress))
    file.row({row.measure, row.irregular ? "irregular" : "regular", name_of(row.element), row.poisson_ratio, row.cells,
              row.nodes, row.factor_entries, row.value, row.reference, row.error()});
}

}  // namespace acus
