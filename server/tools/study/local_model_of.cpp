// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/tools/study/local_model_of.h"

#include <algorithm>
#include <cmath>

namespace acus {

namespace {

// m, of the target, of which the base makes a part within the tick. Small beside the way of a sliding needle in a tick, so
// that both ticks have the same pieces of the laws.
constexpr double kProbe = 1e-5;

haptics::Vector3 plain(const Vector3& v) { return {{v.x(), v.y(), v.z()}}; }
haptics::Quaternion plain(const Quaternion& q) { return {q.w(), q.x(), q.y(), q.z()}; }

// As far as the laws of the tip tell: contact ends, the tissue opens, the tip begins to cut.
void set_limits(const Simulation& simulation, double axial, double stiffness, haptics::LocalModel& model) {
  const NeedleReport& needle = simulation.report().needles[0];
  const Interaction& laws = simulation.scene().tissue.regions[0].interaction;
  if (!(stiffness > 0)) return;
  const double tip = needle.cutting_force.norm();
  if (needle.phase == Phase::contact) {
    model.forward = std::clamp((laws.puncture_force - tip) / stiffness, 0.0, 1.0);  // .inf: never
    model.forward_limit = haptics::Limit::puncture;
    model.backward = std::clamp(-axial / stiffness, 0.0, 1.0);
    model.backward_limit = haptics::Limit::contact;
  } else if (needle.phase == Phase::inside) {
    model.forward = std::clamp((laws.cutting_force - tip) / stiffness, 0.0, 1.0);
    model.forward_limit = haptics::Limit::cutting;
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
  set_limits(simulation, axis.dot(needle.base_force), stiffness, model);
  return model;
}

}  // namespace acus
