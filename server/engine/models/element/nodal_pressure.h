// SPDX-License-Identifier: GPL-3.0-or-later
// Element `nodal_pressure`: linear tetrahedra that do not lock. A linear tetrahedron has one volume change, and a mesh
// has five to six times as many of them as nodes: as nu -> 0.5 they forbid nearly every displacement. Here most of the
// bulk stiffness answers the mean volume change around a node instead, of which there is one per node:
//
//   Psi = sum_e V_e (mu |E_e|² + lambda_s/2 theta_e²) + sum_a V_a (lambda - lambda_s)/2 theta_a²
//   theta_e = tr E_e,   V_a = sum_e V_e/4,   theta_a = sum_e (V_e/4) theta_e / V_a,   over the elements e around node a
//
// With the pressures p_a = (lambda - lambda_s) theta_a (tension positive) its gradient is that of the element with one
// term more, P_e = R (2 mu E + (lambda_s theta_e + p_e) I), p_e the mean of the four p_a, and its second derivative
//
//   K = K_e(lambda_s) + sum_a (lambda - lambda_s)/V_a g_a g_aᵀ + sum_e V_e p_e d²theta_e,   g_a = sum_e (V_e/4)
//   dtheta_e
//
// so the energy is never above that of the linear element, a linear displacement is answered alike, forces balance
// element by element, and nodes couple that share the surroundings of a node (two edges apart).
// [Bonet, Burton 1998, "A simple average nodal pressure tetrahedral element for incompressible and nearly
// incompressible dynamic explicit applications", there with the volume ratio instead of tr E; Puso, Solberg 2006, "A
// stabilized nodally integrated tetrahedral", for the part that stays with the elements]
//
// A patch is a node within one region: at a border each region has its own mean, so that a stiff inclusion keeps its
// pressure to itself.
//
// The share of the elements, lambda_s = min(lambda, kElementShare mu), stands against displacements that change the
// elements' volumes but no node's mean; mu |E|² does, too, so none of them is free. Measured at nu = 0.499 with shares
// of 0, 0.5, 1, 2, 4 mu, cubes cut along one direction: of the vortex of studies/locking.h (12 cells, against its
// nodal values) 0.96, 0.95, 0.94, 0.93, 0.90 come about, with linear elements 0.16; under a point force on the surface
// (8 cells) the elements' volume changes are 0.23, 0.22, 0.21, 0.20, 0.18 of all strain, and the point goes in by 2.21,
// 2.17, 2.13, 2.06, 1.96 times F (1 - nu)/(4 mu cell), with linear elements by 0.64, and at nu = 0.3, where they do not
// lock, by 2.01. The lowest frequencies of a free cube differ by 0.3 %. One mu gives at every nu what linear elements
// give where they do not lock, and below nu = 0.25 it is the linear element.
//
// Limits: there is no inf-sup bound. In a closed box the smallest singular value of the nodal divergence falls with the
// element size (0.057, 0.038, 0.029 at 4, 6, 8 cells), so pressures may alternate from node to node where loads do not
// vary smoothly, and a mesh with few free nodes for its fixed ones still locks a little.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "server/engine/math/types.h"
#include "server/engine/models/element/element_kernel.h"
#include "server/engine/models/geometry/tetrahedral_mesh.h"

namespace acus {

// Constant after load. Without patches for element `linear`.
struct NodalPressure {
  static constexpr double kElementShare = 1;  // lambda_s / mu, of larger lambda

  VectorX volume;                              // per patch: V_a (m³)
  VectorX modulus;                             // per patch: lambda - lambda_s (Pa)
  VectorX damping;                             // per patch: beta (s)
  std::vector<std::array<int, 4>> of_element;  // per tetrahedron: the patches of its nodes
  std::vector<PatchBatch> batches;
  std::vector<int> first_node;                 // per patch, of its nodes in `nodes`; the end behind the last
  std::vector<int> nodes;                      // of each patch's elements, ascending

  int patches() const { return static_cast<int>(volume.size()); }
  std::span<const int> nodes_of(int patch) const {
    return std::span(nodes).subspan(static_cast<std::size_t>(first_node[patch]),
                                    static_cast<std::size_t>(first_node[patch + 1] - first_node[patch]));
  }
};

// `region_of` and `volumes` (m³) per tetrahedron, `modulus` (Pa) and `damping` (s) per region. No patches where every
// modulus is zero.
NodalPressure make_nodal_pressure(const TetrahedralMesh& mesh, std::span<const int> region_of,
                                  const std::vector<double>& volumes, const std::vector<double>& modulus,
                                  const std::vector<double>& damping);

// The mean pressure p_e (Pa) of an element from those of the patches.
double mean_pressure(const NodalPressure& model, int tetrahedron, const VectorX& pressures);

// The vectors g_a of a configuration.
class PatchGradients {
 public:
  explicit PatchGradients(const NodalPressure& model);

  void clear() { columns_.setZero(); }
  // Adds an element's share; `gradient` = V_e dtheta_e/dx (m²), one column for each of its nodes.
  void add(int tetrahedron, const std::array<int, 4>& nodes, const Eigen::Matrix<double, 3, 4>& gradient);

  // Calls visit(i, j, (lambda - lambda_s)/V_a g_i g_jᵀ in N/m, beta) for every pair i >= j of a patch's nodes.
  template <class Visit>
  void for_each_block(Visit visit) const {
    for (int patch = 0; patch < model_.patches(); ++patch) {
      if (model_.modulus[patch] == 0) continue;
      const auto nodes = model_.nodes_of(patch);
      const auto g = columns_.middleCols(model_.first_node[patch], static_cast<Eigen::Index>(nodes.size()));
      const double factor = model_.modulus[patch] / model_.volume[patch];
      for (int i = 0; i < static_cast<int>(nodes.size()); ++i)
        for (int j = 0; j <= i; ++j)
          visit(nodes[i], nodes[j], Matrix3(factor * g.col(i) * g.col(j).transpose()), model_.damping[patch]);
    }
  }

 private:
  const NodalPressure& model_;
  Matrix3X columns_;  // of all patches, numbered like NodalPressure::nodes (m²)
};

}  // namespace acus
