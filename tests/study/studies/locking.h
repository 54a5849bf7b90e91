// SPDX-License-Identifier: GPL-3.0-or-later
// The locking table: how much too stiff tissue is as Poisson's ratio goes to 1/2, over elements and meshes, in statics
// about the rest shape. G is the shear modulus, n the number of cells.
//
// line     a cube of 0.1 m, four sides fixed, a force of 1 N/m along the nodes of the middle line between the open
//          sides, at right angles to it: mean displacement of the line times 4 pi G (-). It grows with ln(1/cell) without
//          end, so it has no reference; but it should grow alike for every Poisson's ratio.
// needle   the same with the give of a needle of 1 mm added that the mesh does not resolve (foundation_compliance()).
//          Reference: the finest mesh of its kind with nodal pressures. It tells how much of the answer is the mesh's,
//          not what a needle meets: a line of nodes is the softest place of a mesh.
// vortex   the same cube, fixed all around, and the load that holds u = (dpsi/dy, -dpsi/dx, 0),
//          psi = sin²(kx) sin²(ky) sin²(kz) 0.1 m, k = pi/(0.1 m): its work on the displacement found over that on u. It
//          changes no volume, so the load and the reference, 1, are the same for every Poisson's ratio.
// bending  a free bar of 0.1 x 0.025 x 0.025 m, 4n x n x n cells, bent by the tractions E kappa z on its ends: their work
//          over the exact M² L/(EI). Reference: 1.
//
// Each on the project's own box mesh and on one whose inner nodes are moved at random by up to 15 % of a cell, as the
// meshes of segmented organs are irregular: the regular one happens to lock little.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "server/engine/models/element/tissue_element.h"
#include "tests/study/studies/study.h"

namespace acus {

struct LockingRow {
  std::string measure;
  bool irregular = false;
  TissueElement element = TissueElement::linear;
  double poisson_ratio = 0;
  int cells = 0;
  int nodes = 0;
  std::size_t factor_entries = 0;  // of the stiffness
  double value = 0;                // -
  double reference = 0;            // -, NaN where there is none
  double error() const { return value / reference - 1; }
};

// All rows, every measure over four Poisson's ratios, four meshes (in the short form two) and both elements.
std::vector<LockingRow> locking_table(bool quick,
                                      const std::function<void(int done, int of, const std::string& next)>& progress);

// Writes them to locking.csv.
void study_locking(const StudyPlan& plan);

}  // namespace acus
