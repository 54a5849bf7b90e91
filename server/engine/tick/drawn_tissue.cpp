// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/tick/drawn_tissue.h"

#include <algorithm>
#include <cassert>
#include <cstddef>

#include "server/engine/state/capacities.h"
#include "server/engine/state/limits.h"
#include "server/engine/tick/insertion/finding/hub.h"
#include "server/engine/tick/insertion/finding/shaft_contact.h"
#include "server/engine/tick/insertion/path_wall.h"
#include "server/engine/tick/scratch.h"

namespace acus {

namespace {

// Of a needle: where its tip or hub presses on a surface, its tip inside, a mouth and an exit for each part of its
// path, and the points of its shaft's contacts.
std::size_t most_dents(const Needle& needle) {
  return 3 + 2 * (kMaxGaps + 1) + static_cast<std::size_t>(kContactPoints * shaft_cells(needle));
}

// r/R from which a dent shows nothing.
constexpr double kShallowest = 0.9;

void add_dent(const Vector3& centre, const Vector3& move, const LoadRadii& radii, DrawnTissue& drawn) {
  if (radii.inner > kShallowest * radii.outer) return;
  assert(drawn.dents.size() < drawn.dents.capacity());
  drawn.dents.push_back({centre, Vector3::Zero(), radii});
  drawn.wanted.push_back(move);
}

void add_dimple(const InsertionView& at, const Insertion& insertion, DrawnTissue& drawn) {
  const MaterialPoint& touched = insertion.touched;
  const Vector3 centre = at.tissue.position(touched);
  const Vector3 move = at.needle.tip().position - centre;
  const double d = at.parameters.outer_diameter, f = insertion.tip.contact.along;
  DimpleSpring dimple = at.tissue.dimple_spring(touched, d, at.tissue.disc_load(touched, d, f, move.norm()));
  dimple.relax(at.tissue.relaxation_of(touched), insertion.tip.contact.creep.along);
  // The mesh shows a dimple as wide as its elements, but not where in it the tip is.
  LoadRadii radii = dimple.radii(f);
  radii.outer = std::max(radii.outer, 1.2 * radii.inner);
  add_dent(centre, move, radii, drawn);
}

void add_hub_dent(const InsertionView& at, const Path& path, const ContactState& hub, DrawnTissue& drawn) {
  if (hub.along == 0) return;
  const Obstacle skin = surface_under_hub(at, path, hub);
  add_dent(at.tissue.position(skin.material), -skin.dimple_before * skin.at.normal, skin.dimple.radii(hub.along),
           drawn);
}

void add_grooves(const InsertionView& at, const Insertion& insertion, DrawnTissue& drawn) {
  const TissueView& tissue = at.tissue;
  const double d = at.needle.model.diameter;
  for (const ShaftCell& cell : insertion.cells) {
    if (cell.contact.along == 0) continue;
    for (int i = 0; i < kContactPoints; ++i) {
      const Vector3 p = at.needle.start_position(contact_place(cell.s, cell.length, i, at.needle.model.length));
      const SurfacePoint under = surface_under(tissue, p, cell.normal, kContactMargin);
      const double deep = std::max(0.0, cell.normal.dot(under.position - p));
      const MaterialPoint material = tissue.surface.material(under);
      GrooveSpring groove = tissue.groove_spring(material, d, cell.length);
      groove.relax(tissue.relaxation_of(material), cell.contact.creep.along);
      add_dent(under.position, -deep * cell.normal, groove.radii(cell.contact.along), drawn);
    }
  }
}

bool is_mouth_or_exit(const Path& path, int vertex) {
  return vertex == 0 || path.air_behind(vertex) || path.air_behind(vertex - 1);
}

void add_path_dents(const InsertionView& at, const Path& path, const Insertion& insertion, DrawnTissue& drawn) {
  const double d = at.parameters.outer_diameter;
  add_hub_dent(at, path, insertion.hub, drawn);
  for (int i = 0; i < static_cast<int>(path.vertices.size()); ++i)
    if (is_mouth_or_exit(path, i) && is_alongside(insertion, i))
      add_dent(at.tissue.position(path.vertices[i]), wall_move(at, path, insertion, i),
               at.tissue.shaft_radii(path.vertices[i], d), drawn);
  if (is_out(at, path, insertion))
    add_dent(at.tissue.position(path.end), exit_move(at, path, insertion), at.tissue.shaft_radii(path.end, d), drawn);
  if (insertion.phase == Phase::through) return;
  const TipWall tip = tip_wall(at, path, insertion);
  add_dent(tip.place, tip.move, tip.radii, drawn);
}

void add_dents(const InsertionView& at, const State& state, DrawnTissue& drawn) {
  const Insertion& insertion = state.insertions[static_cast<std::size_t>(at.needle_index)];
  if (touches(insertion)) add_dimple(at, insertion, drawn);
  add_grooves(at, insertion, drawn);
  if (insertion.path >= 0) add_path_dents(at, state.paths[static_cast<std::size_t>(insertion.path)], insertion, drawn);
}

void add_path(const Path& path, const TissueView& tissue, DrawnTissue& drawn) {
  for (int i = 0; i < path.points(); ++i) {
    const Vector3 place = tissue.position(path.point(i));
    drawn.path_points.col(drawn.points + i) = place + displacement(drawn.dents, place);
  }
  drawn.points += path.points();
  drawn.path_sizes.push_back(path.points());
}

// Vertices beside a needle touch it, and the end where it is through; `first` column of its path.
void put_walls(const InsertionView& at, const Path& path, const Insertion& insertion, int first, DrawnTissue& drawn) {
  const int count = static_cast<int>(path.vertices.size());
  for (int i = 0; i < count; ++i)
    if (is_alongside(insertion, i))
      drawn.path_points.col(first + i) = at.tissue.position(path.vertices[i]) + wall_move(at, path, insertion, i);
  if (is_out(at, path, insertion))
    drawn.path_points.col(first + count) = at.tissue.position(path.end) + exit_move(at, path, insertion);
}

}  // namespace

DrawnTissue::DrawnTissue(const Model& model)
    : path_points(3, kMaxPaths * (model.path_vertices + 1)), shapes(model.needles.size()) {
  std::size_t most = 0;
  for (const Needle& needle : model.scene.needles) most += most_dents(needle);
  dents.reserve(most);
  wanted.reserve(dents.capacity());
  path_sizes.reserve(kMaxPaths);
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    const auto nodes = static_cast<std::size_t>(model.needles[i].nodes());
    shapes[i].x.resize(3, static_cast<Eigen::Index>(nodes));
    shapes[i].frames.resize(nodes);
  }
}

void draw_tissue(const Model& model, const State& state, DrawnTissue& drawn) {
  drawn.dents.clear();
  drawn.wanted.clear();
  drawn.path_sizes.clear();
  drawn.points = 0;
  const TissueView tissue = tissue_view(model, state.tissue.x, state.tissue.x);
  const auto view = [&](int i) {
    const NeedleShape& shape = drawn.shapes[static_cast<std::size_t>(i)];
    return InsertionView{
        i, model.scene.needles[i], {model.needles[i], shape, shape, model.h}, tissue, tip_cutting(model, state, i)};
  };
  for (int i = 0; i < model.needle_count(); ++i) {
    put_shape(state.needles[i], drawn.shapes[i]);
    add_dents(view(i), state, drawn);
  }
  set_moves(drawn.wanted, drawn.dents);
  for (const Path& path : state.paths) {
    if (path.empty()) continue;
    const int first = drawn.points;
    add_path(path, tissue, drawn);
    if (path.needle >= 0) put_walls(view(path.needle), path, state.insertions[path.needle], first, drawn);
  }
}

}  // namespace acus
