// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/state/bytes/state_check.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "server/engine/state/bytes/field_check.h"
#include "server/engine/state/bytes/state_bounds.h"
#include "server/engine/state/bytes/state_bytes.h"

namespace acus {

namespace {

constexpr double kUnitTolerance = 1e-7;     // of what rotation_log() is given products of
constexpr double kElementTolerance = 1e-3;  // of the rotations of elements, which only turn forces
constexpr double kLargestNumber = 1e15;

bool in_mesh(const Model& model, const MaterialPoint& point) {
  return 0 <= point.tetrahedron && point.tetrahedron < model.mesh.tetrahedron_count();
}

bool is_unit(const Quaternion& q) { return std::abs(q.norm() - 1) < kUnitTolerance; }

void check_path(const Model& model, const Path& path) {
  require_in_range(-1 <= path.needle && path.needle < model.needle_count(), "the needle of a path");
  if (path.empty() || path.needle < 0) require_in_range(path.exits.empty(), "the gaps of a path that no needle is in");
  if (path.empty()) return require_in_range(path.needle < 0, "the needle of a path");
  const auto inside = [&](const MaterialPoint& point) { return in_mesh(model, point); };
  require_in_range(std::all_of(path.vertices.begin(), path.vertices.end(), inside) && inside(path.end),
                   "a point of a path");
  require_in_range(path.spacing > 0 && path.head >= 0, "the spacing of a path");
  const int vertices = static_cast<int>(path.vertices.size());
  int before = 0;  // a part has a mouth and one more vertex
  for (const int exit : path.exits) {
    require_in_range(before < exit && exit < vertices - 1, "a gap of a path");
    before = exit + 1;
  }
}

void check_cell(const ShaftCell& cell, double needle_length, double surface_moved) {
  constexpr double kLeastLength = 1e-6;  // m
  require_in_range(cell.distance >= 0 && cell.moved <= surface_moved, "the look of a shaft for a surface");
  const bool touches = cell.length > 0;
  require_in_range(0 <= cell.s && cell.s <= needle_length && cell.contact.along >= 0 &&
                       (touches ? kLeastLength <= cell.length && cell.length <= needle_length &&
                                      std::abs(cell.normal.norm() - 1) < kUnitTolerance
                                : cell.length == 0 && cell.contact.along == 0),
                   "a contact of a shaft");
}

// `crept`: what Creep::along can be at most, in its unit.
void check_contact(const ContactState& contact, double crept, const StateBounds& bounds) {
  require_in_range(
      within(Eigen::Vector2d(contact.along, contact.torsion), bounds.force) && within(contact.across, bounds.force),
      "a force on a needle");
  require_in_range(within(contact.creep.across, bounds.way) && within(contact.creep.along, crept),
                   "what the tissue beside a needle remembers");
}

void check_contacts(const Insertion& insertion, const StateBounds& bounds) {
  check_contact(insertion.tip.contact, bounds.force, bounds);
  check_contact(insertion.tip.cut, bounds.way, bounds);
  for (const VertexState& vertex : insertion.vertices) check_contact(vertex.contact, bounds.way, bounds);
  for (const ShaftCell& cell : insertion.cells) check_contact(cell.contact, bounds.force, bounds);
  check_contact(insertion.hub, bounds.force, bounds);
}

void check_insertion(const Model& model, const State& state, int needle, const StateBounds& bounds) {
  const Insertion& insertion = state.insertions[needle];
  require_in_range(insertion.phase <= Phase::through, "the phase of a needle");
  require_in_range(-1 <= insertion.path && insertion.path < static_cast<int>(state.paths.size()),
                   "the path of a needle");
  const bool in_path = insertion.phase == Phase::inside || insertion.phase == Phase::through;
  require_in_range(in_path == (insertion.path >= 0), "the phase of a needle without path, or its path");
  if (in_path) {
    const Path& path = state.paths[insertion.path];
    require_in_range(!path.empty() && path.needle == needle, "the path of a needle");
    require_in_range(insertion.phase != Phase::through || path.exited, "the phase of a needle in its path");
  }
  const int regions = static_cast<int>(model.interactions.size());
  require_in_range(-1 <= insertion.border && insertion.border < regions, "the region that holds a needle");
  require_in_range(insertion.border < 0 || !model.borders.surface(insertion.border).empty(),
                   "the region that holds a needle");
  require_in_range(insertion.touched.tetrahedron == -1 || in_mesh(model, insertion.touched),
                   "the point that a needle touches");
  require_in_range((insertion.phase != Phase::contact) || touches(insertion), "the point that a needle touches");
  const int vertices = static_cast<int>(insertion.vertices.size());
  require_in_range(0 <= insertion.first_alongside && insertion.first_alongside <= vertices,
                   "the vertices along a needle");
  require_in_range(-1 <= insertion.last_alongside && insertion.last_alongside < vertices,
                   "the vertices along a needle");
  for (const ShaftCell& cell : insertion.cells) check_cell(cell, model.needles[needle].length, state.surface_moved);
  check_contacts(insertion, bounds);
  const bool may_touch = insertion.path >= 0 && model.scene.needles[needle].hub_diameter > 0;
  require_in_range(insertion.hub.along >= 0 && (may_touch || insertion.hub.along == 0), "the contact of a hub");
}

void check_rotations(const Model& model, const ElementRotations& rotations) {
  for (int t = 0; t < model.mesh.tetrahedron_count(); ++t) {
    double q[4];
    rotations.element(t, q);
    require_in_range(std::abs(Eigen::Map<const Eigen::Vector4d>(q).norm() - 1) < kElementTolerance,
                     "the rotation of an element");
  }
}

void check_tissue(const Model& model, const TissueState& tissue, const StateBounds& bounds) {
  require_in_range(tissue.guarded >= 0, "the number of guarded steps");
  require_in_range(within(tissue.x - model.mesh.nodes, bounds.way), "the place of a node");
  require_in_range(within(tissue.v, bounds.way / model.h), "the speed of a node");
  check_rotations(model, tissue.rotations);
  if (tissue.field) check_field(model, *tissue.field, bounds);
}

void check_monitor(const Model& model, const State& state, int needle) {
  const ShaftMonitor& monitor = state.monitors[needle];
  const int samples = monitor_samples(model.needles[needle].length);
  require_in_range(0 <= monitor.next && monitor.next < samples && 0 <= monitor.found && monitor.found <= samples &&
                       monitor.unheld >= 0,
                   "the watch over a shaft");
}

void check_motion(const BaseState& motion, std::uint64_t tick) {
  require_in_range(motion.command_tick <= tick, "the tick of a command");
  require_in_range(motion.rhythm.interval >= 0 && motion.rhythm.deviation >= 0, "the rhythm of commands");
  require_in_range(is_unit(motion.pose.orientation) && is_unit(motion.target.orientation),
                   "the orientation of a base or guide");
}

}  // namespace

void check_state(const Model& model, const State& state) {
  require_in_range(largest_number(state) < kLargestNumber, "a number");
  const StateBounds bounds(model);
  require_in_range(state.balance.largest_force >= 0, "the largest force");
  require_in_range(state.balance.contact_forces >= 0, "the forces of contacts");
  for (const NeedleState& needle : state.needles)
    require_in_range(std::ranges::all_of(needle.q, is_unit), "an orientation");
  for (const BaseState& base : state.bases) check_motion(base, state.tick);
  for (const GuideState& guide : state.guides) {
    check_motion(guide.motion, state.tick);
    check_contact(guide.contact, 0, bounds);
  }
  for (int i = 0; i < static_cast<int>(state.paths.size()); ++i) {
    const Path& path = state.paths[i];
    check_path(model, path);
    require_in_range(path.needle < 0 || state.insertions[path.needle].path == i, "the needle of a path");
  }
  check_tissue(model, state.tissue, bounds);
  for (int i = 0; i < model.needle_count(); ++i) {
    check_insertion(model, state, i, bounds);
    check_monitor(model, state, i);
  }
}

}  // namespace acus
