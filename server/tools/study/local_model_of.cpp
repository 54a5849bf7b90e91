// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/tools/study/local_model_of.h"

#include <algorithm>
#include <numbers>

namespace acus {

namespace {

// m, of the target, of which the base makes a part within the tick. Small beside the way of a sliding needle in a tick,
// so that both ticks have the same pieces of the laws.
constexpr double kProbe = 1e-5;

haptics::Vector3 plain(const Vector3& v) { return {{v.x(), v.y(), v.z()}}; }
haptics::Quaternion plain(const Quaternion& q) { return {q.w(), q.x(), q.y(), q.z()}; }

// How far the base may go while the force (N) comes to a limit (N), m.
double way_to(double limit, double force, double stiffness) {
  return std::clamp((limit - force) / stiffness, 0.0, 1.0);
}

// As far as the laws tell of the needle as a whole: contact ends, the tissue opens, or friction and cutting together
// bear no more. `resistance` is the axial force against going on.
void set_limits(const Simulation& simulation, double resistance, double stiffness, haptics::LocalModel& model) {
  const NeedleReport& needle = simulation.report().needles[0];
  const Interaction& laws = simulation.scene().tissue.regions[0].interaction;
  if (!(stiffness > 0)) return;
  const double tip = needle.cutting_force.norm();
  if (needle.phase == Phase::contact) {
    model.forward = way_to(laws.puncture_force, tip, stiffness);
    model.forward_limit = haptics::Limit::puncture;
    model.backward = way_to(resistance, 0, stiffness);
    model.backward_limit = haptics::Limit::contact;
  } else if (needle.phase == Phase::inside) {
    const double friction = std::numbers::pi * simulation.scene().needles[0].outer_diameter * laws.friction_static *
                            shaft_pressure(simulation.scene().tissue.regions[0]) * needle.inserted_depth;
    model.forward = way_to(friction + (tip > 0 ? laws.cutting_force : 0), resistance, stiffness);
    model.forward_limit = tip > 0 ? haptics::Limit::cutting : haptics::Limit::slip;
    model.backward = way_to(friction, -resistance, stiffness);
    model.backward_limit = haptics::Limit::slip;
  }
}

}  // namespace

haptics::LocalModel step_with_local_model(Simulation& simulation, const Pose& target, std::uint64_t seq) {
  const State before = simulation.state();
  const Vector3 axis = target.orientation * Vector3::UnitX();
  Pose probe = target;
  probe.position -= kProbe * axis;
  simulation.command(0, {seq, probe, std::nullopt});
  simulation.step();
  const NeedleReport other = simulation.report().needles[0];
  simulation.restore(before);
  simulation.command(0, {seq, target, std::nullopt});
  simulation.step();
  const TickReport& tick = simulation.report();
  const NeedleReport& needle = tick.needles[0];

  const double way = axis.dot(needle.base.position - other.base.position);
  const double stiffness = way > 0 ? std::max(-axis.dot(needle.base_force - other.base_force) / way, 0.0) : 0;
  haptics::LocalModel model;
  model.tick = tick.tick;
  model.time = tick.time;
  model.seq = seq;
  model.base = {plain(needle.base.position), plain(target.orientation)};
  model.felt = {plain(needle.base_force), plain(needle.base_torque)};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) model.stiffness(i, j) = -stiffness * axis[i] * axis[j];
  set_limits(simulation, -axis.dot(needle.base_force), stiffness, model);
  return model;
}

}  // namespace acus
