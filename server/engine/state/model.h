// SPDX-License-Identifier: GPL-3.0-or-later
// What a scene is made into when it is loaded: constant from then on, and shared by all ticks.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "server/engine/models/geometry/surface.h"
#include "server/engine/models/needle/needle.h"
#include "server/engine/models/tissue/tissue_system.h"
#include "server/engine/models/unresolved/bevel.h"
#include "server/engine/scene/scene.h"
#include "server/engine/state/borders.h"
#include "server/engine/state/limits.h"
#include "server/engine/state/needle/base_state.h"

namespace acus {

// Told before each step of loading a scene what that step makes: "mesh", "regions", ..., "factor", ...
using Progress = std::function<void(const char* what)>;

struct Model {
  // Factorises, with the scene's mesh as read_mesh() gives it, or reads that first; throws SceneError. `equilibrium` of
  // the tissue, where it begins in one (tick/static_start.h), is read only here.
  explicit Model(const Scene& scene, const Progress& progress = {}, std::optional<TetrahedralMesh> own_mesh = {},
                 const TissueState* equilibrium = nullptr);
  Model(const Model&) = delete;  // parts refer to each other
  Model& operator=(const Model&) = delete;

  int needle_count() const { return static_cast<int>(scene.needles.size()); }
  int guide_count() const { return static_cast<int>(scene.guides.size()); }
  // Whether the rung iterates to a tolerance.
  bool iterates() const { return scene.tissue.rung == TissueRung::refined || scene.tissue.rung == TissueRung::exact; }
  // Of the region through which the needle steers most.
  const Vector3& cutting_direction(int needle) const;
  // Solutions of a tick at most, each a step of stages 2 to 8.
  int max_tick_steps() const { return iterates() ? scene.newton.max_iterations : kMaxTickSteps; }

  Scene scene;
  double h;                                // s, 1/rate
  TetrahedralMesh mesh;                    // at its place in the world
  std::vector<int> regions;                // per tetrahedron
  std::vector<Interaction> interactions;   // per region, pressure filled in
  std::vector<RelaxationStep> relaxation;  // per region, none where no tissue relaxes
  std::vector<double> element_sizes;       // per tetrahedron: the edge of a regular one of the same volume (m)
  std::uint64_t fingerprint;               // which scene it is (scene/fingerprint.h)
  double force_rounding;                   // N, what rounding may leave of a sum of the elements' forces
  TissueModel tissue;
  Surface surface;
  Borders borders;
  TissueSystem tissue_system;
  std::vector<NeedleModel> needles;
  std::vector<std::vector<Vector3>> cutting_directions;  // per needle and region, in the tip's frame, unit
  std::vector<BaseLimits> needle_limits, guide_limits;  // of the bases' and the guides' motions
  std::vector<int> guide_needles;          // per guide, the needle in it
  int path_vertices = 0;                   // that a path can have: any needle may pick it up
  int max_rows = 0;                        // scalar rows of the laws in one tick
};

// How a needle with `point_side` steers through tissue of the region: straight on if it is rigid.
BevelPath steered_path(const Needle& needle, const NeedleModel& model, const Region& region);

// Rows between a needle and the tissue, and of all guides and contacts between needles, in one tick, at most.
int max_tissue_rows(const Scene& scene, const Needle& needle);
int max_rows_of_needles_alone(const Scene& scene);

}  // namespace acus
