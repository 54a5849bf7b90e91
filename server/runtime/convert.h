// SPDX-License-Identifier: GPL-3.0-or-later
// The simulation's types as the protocol's and back.
#pragma once

#include <array>

#include "protocol/messages.h"
#include "server/engine/math/rotation.h"
#include "server/engine/math/types.h"
#include "server/engine/state/report.h"
#include "server/engine/tick/drawn_tissue.h"
#include "server/engine/tick/simulation.h"

namespace acus {

inline protocol::Vector3 to_wire(const Vector3& v) { return {v.x(), v.y(), v.z()}; }
inline protocol::Quaternion to_wire(const Quaternion& q) { return {q.w(), q.x(), q.y(), q.z()}; }
inline Vector3 from_wire(const protocol::Vector3& v) { return {v[0], v[1], v[2]}; }
inline Quaternion from_wire(const protocol::Quaternion& q) { return {q.w, q.x, q.y, q.z}; }

// What a tick says of a needle; the fields that are about its commands and the run are left alone.
inline void put(const NeedleReport& needle, protocol::Force& force) {
  const Quaternion base_from_world = needle.base.orientation.conjugate();
  force.seq = needle.command_seq;
  force.phase = needle.phase;
  force.depth = needle.inserted_depth;
  force.unheld = needle.unheld;
  force.base_position = to_wire(needle.base.position);
  force.base_orientation = to_wire(needle.base.orientation);
  force.commanded_position = to_wire(needle.commanded.position);
  force.commanded_orientation = to_wire(needle.commanded.orientation * rotation_exp({-needle.spin, 0, 0}));
  force.spin = needle.spin;
  force.tip_position = to_wire(needle.tip_position);
  force.tip_force = to_wire(needle.tip_force);
  force.base_force = to_wire(needle.base_force);
  force.base_torque = to_wire(needle.base_torque);
  force.base_force_in_base = to_wire(base_from_world * needle.base_force);
  force.base_torque_in_base = to_wire(base_from_world * needle.base_torque);
  force.cutting_force = to_wire(needle.cutting_force);
  force.friction_force = to_wire(needle.friction_force);
  force.lateral_force = to_wire(needle.lateral_force);
  force.guide_force = to_wire(needle.guide_force);
  force.needle_force = to_wire(needle.needle_force);
}

inline protocol::Event to_wire(const Event& event, std::uint64_t epoch, double time, const Scene& scene) {
  return {epoch,
          event.tick,
          time,
          scene.needles[static_cast<std::size_t>(event.needle)].name,
          event.kind,
          scene.tissue.regions[static_cast<std::size_t>(event.region)].name,
          to_wire(event.position),
          event.force};
}

// Points (3 x n) as x, y, z of one after the other; `packed` holds 3 n numbers already.
template <class Number>
void pack(const Eigen::Ref<const Matrix3X>& points, std::vector<Number>& packed) {
  Eigen::Map<Eigen::Matrix<Number, 3, Eigen::Dynamic>>(packed.data(), 3, points.cols()) = points.cast<Number>();
}

// The shape of a needle after a tick. Here and below names and epochs are left alone.
inline void put(const Simulation& simulation, int needle, protocol::NeedleShape& shape) {
  shape.tick = simulation.report().tick;
  shape.time = simulation.report().time;
  const auto positions = simulation.needle_positions(needle);
  shape.positions.resize(static_cast<std::size_t>(positions.size()));
  pack(positions, shape.positions);
  shape.orientations.clear();
  for (const Quaternion& q : simulation.needle_orientations(needle))
    shape.orientations.insert(shape.orientations.end(), {q.w(), q.x(), q.y(), q.z()});
}

// The shape of the tissue, whose `positions` have their size already, of the paths in it and its dents.
inline void put(const Simulation& simulation, DrawnTissue& drawn, protocol::TissueShape& shape) {
  shape.tick = simulation.report().tick;
  shape.time = simulation.report().time;
  pack(simulation.tissue_positions(), shape.positions);
  draw_tissue(simulation.model(), simulation.state(), drawn);
  shape.path_points.resize(static_cast<std::size_t>(3 * drawn.points));
  pack(drawn.path_points.leftCols(drawn.points), shape.path_points);
  shape.path_sizes.assign(drawn.path_sizes.begin(), drawn.path_sizes.end());
  shape.dent_centres.clear();
  shape.dent_moves.clear();
  shape.dent_radii.clear();
  const auto append = [](std::vector<float>& numbers, const auto& more) {
    for (const double number : more) numbers.push_back(static_cast<float>(number));
  };
  for (const Dent& dent : drawn.dents) {
    append(shape.dent_centres, dent.centre);
    append(shape.dent_moves, dent.move);
    append(shape.dent_radii, std::array{dent.radii.inner, dent.radii.outer});
  }
}

}  // namespace acus
