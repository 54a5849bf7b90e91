// SPDX-License-Identifier: GPL-3.0-or-later
// The borders between the regions of a tissue: what holds a tip that comes from one region at the surface of another.
// A border whose puncture force is not above the cutting force of the region that the tip comes from is no obstacle;
// the tip goes through it as it cuts.
#pragma once

#include <cassert>
#include <span>
#include <vector>

#include "server/engine/models/geometry/surface.h"
#include "server/engine/scene/scene.h"

namespace acus {

struct Border {
  double puncture_force = 0;    // f_p (N)
  double friction_contact = 0;  // mu (-)
  bool holds = false;
};

class Borders {
 public:
  // `regions` per tetrahedron, indices into tissue.regions. The mesh must outlive the borders.
  Borders(const Tissue& tissue, const TetrahedralMesh& mesh, std::span<const int> regions);

  // Whether any border of the mesh holds a tip.
  bool any() const { return any_; }
  const Border& at(int from, int into) const {
    assert(from >= 0 && from < regions_ && into >= 0 && into < regions_);
    return table_[static_cast<std::size_t>(from * regions_ + into)];
  }
  // The surface of a region inside the tissue; empty where nothing holds a tip that comes to it.
  const Surface& surface(int region) const { return surfaces_[static_cast<std::size_t>(region)]; }

 private:
  int regions_;
  bool any_ = false;
  std::vector<Border> table_;  // regions x regions
  std::vector<Surface> surfaces_;
};

}  // namespace acus
