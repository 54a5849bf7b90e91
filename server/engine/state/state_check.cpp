// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/state/state_check.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "server/engine/state/state_bytes.h"

namespace acus {

namespace {

constexpr double kUnitTolerance = 1e-7;     // of what rotation_log() is given products of
constexpr double kElementTolerance = 1e-3;  // of the rotations of elements, which only turn forces
constexpr double kLargestNumber = 1e15;

void require(bool holds, const std::string& what) {
  if (!holds) throw std::runtime_error(what + " is out of range");
}

bool in_mesh(const Model& model, const MaterialPoint& point) {
  return 0 <= point.tetrahedron && point.tetrahedron < model.mesh.tetrahedron_count();
}

bool is_unit(const Quaternion& q) { return std::abs(q.norm() - 1) < kUnitTolerance; }

void check_path(const Model& model, const Path& path) {
  require(-1 <= path.needle && path.needle < model.needle_count(), "the needle of a path");
  if (path.empty() || path.needle < 0) require(path.exits.empty(), "the gaps of a path that no needle is in");
  if (path.empty()) return require(path.needle < 0, "the needle of a path");
  const auto inside = [&](const MaterialPoint& point) { return in_mesh(model, point); };
  require(std::all_of(path.vertices.begin(), path.vertices.end(), inside) && inside(path.end), "a point of a path");
  require(path.spacing > 0 && path.head >= 0, "the spacing of a path");
  const int vertices = static_cast<int>(path.vertices.size());
  int before = 0;  // a part has a mouth and one more vertex
  for (const int exit : path.exits) {
    require(before < exit && exit < vertices - 1, "a gap of a path");
    before = exit + 1;
  }
}

void check_cell(const ShaftCell& cell, double needle_length, double surface_moved) {
  constexpr double kLeastLength = 1e-6;  // m
  require(cell.distance >= 0 && cell.moved <= surface_moved, "the look of a shaft for a surface");
  const bool touches = cell.length > 0;
  require(0 <= cell.s && cell.s <= needle_length && cell.contact >= 0 &&
              (touches ? kLeastLength <= cell.length && cell.length <= needle_length &&
                             std::abs(cell.normal.norm() - 1) < kUnitTolerance
                       : cell.length == 0 && cell.contact == 0),
          "a contact of a shaft");
}

void check_insertion(const Model& model, const State& state, int needle) {
  const Insertion& insertion = state.insertions[needle];
  require(insertion.phase <= Phase::through, "the phase of a needle");
  require(-1 <= insertion.path && insertion.path < static_cast<int>(state.paths.size()), "the path of a needle");
  const bool in_path = insertion.phase == Phase::inside || insertion.phase == Phase::through;
  require(in_path == (insertion.path >= 0), "the phase of a needle without path, or its path");
  if (in_path) {
    const Path& path = state.paths[insertion.path];
    require(!path.empty() && path.needle == needle, "the path of a needle");
    require(insertion.phase != Phase::through || path.exited, "the phase of a needle in its path");
  }
  const int regions = static_cast<int>(model.interactions.size());
  require(-1 <= insertion.border && insertion.border < regions, "the region that holds a needle");
  require(insertion.border < 0 || !model.borders.surface(insertion.border).empty(), "the region that holds a needle");
  require(insertion.touched.tetrahedron == -1 || in_mesh(model, insertion.touched), "the point that a needle touches");
  require((insertion.phase != Phase::contact) || touches(insertion), "the point that a needle touches");
  const int vertices = static_cast<int>(insertion.vertices.size());
  require(0 <= insertion.first_alongside && insertion.first_alongside <= vertices, "the vertices along a needle");
  require(-1 <= insertion.last_alongside && insertion.last_alongside < vertices, "the vertices along a needle");
  for (const ShaftCell& cell : insertion.cells) check_cell(cell, model.needles[needle].length, state.surface_moved);
}

void check_rotations(const Model& model, const ElementRotations& rotations) {
  for (int t = 0; t < model.mesh.tetrahedron_count(); ++t) {
    double q[4];
    rotations.element(t, q);
    require(std::abs(Eigen::Map<const Eigen::Vector4d>(q).norm() - 1) < kElementTolerance, "the rotation of an element");
  }
}

void check_held(const Model& model, const Bounded<HeldNode>& held, const std::string& what) {
  std::vector<bool> there(model.tissue.free_nodes.size());
  for (const HeldNode& node : held) {
    require(0 <= node.free && node.free < static_cast<int>(there.size()) && !there[node.free], what);
    there[node.free] = true;
  }
}

void check_field(const Model& model, const FieldState& field) {
  require(0 <= field.tick && field.tick <= model.scene.tissue.window, "the tick of a window");
  require(field.window->begun + static_cast<std::uint64_t>(field.tick) == field.ticks, "the ticks before a window");
  require(field.window->grown >= 0 && field.window->share > 0 && field.window->share <= 1, "the share of a defect");
  require(field.held.capacity() == field.window->held.capacity(), "the room for held nodes");
  check_held(model, field.held, "a held node");
  check_held(model, field.window->held, "a node held when the window began");
  for (int i = 0; i < model.mesh.node_count(); ++i)
    require(std::abs(field.window->rotations.col(i).norm() - 1) < kElementTolerance, "the rotation of a node");
}

void check_monitor(const Model& model, const State& state, int needle) {
  const ShaftMonitor& monitor = state.monitors[needle];
  const int samples = monitor_samples(model.needles[needle].length);
  require(0 <= monitor.next && monitor.next < samples && 0 <= monitor.found && monitor.found <= samples &&
              monitor.unheld >= 0,
          "the watch over a shaft");
}

void check_motion(const BaseState& motion, std::uint64_t tick) {
  require(motion.command_tick <= tick, "the tick of a command");
  require(motion.rhythm.interval >= 0 && motion.rhythm.deviation >= 0, "the rhythm of commands");
  require(is_unit(motion.pose.orientation) && is_unit(motion.target.orientation), "the orientation of a base or guide");
}

}  // namespace

void check_state(const Model& model, const State& state) {
  require(largest_number(state) < kLargestNumber, "a number");
  require(state.tissue.guarded >= 0, "the number of guarded steps");
  require(state.balance.largest_force >= 0, "the largest force");
  require(state.balance.contact_forces >= 0, "the forces of contacts");
  for (const NeedleState& needle : state.needles) require(std::ranges::all_of(needle.q, is_unit), "an orientation");
  for (const BaseState& base : state.bases) check_motion(base, state.tick);
  for (const GuideState& guide : state.guides) check_motion(guide.motion, state.tick);
  for (int i = 0; i < static_cast<int>(state.paths.size()); ++i) {
    const Path& path = state.paths[i];
    check_path(model, path);
    require(path.needle < 0 || state.insertions[path.needle].path == i, "the needle of a path");
  }
  check_rotations(model, state.tissue.rotations);
  if (state.tissue.field) check_field(model, *state.tissue.field);
  for (int i = 0; i < model.needle_count(); ++i) {
    check_insertion(model, state, i);
    check_monitor(model, state, i);
  }
}

}  // namespace acus
