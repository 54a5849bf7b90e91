// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/study/studies/local_model_of.h"

namespace acus {

namespace {

haptics::Vector3 plain(const Vector3& v) { return {{v.x(), v.y(), v.z()}}; }
haptics::Quaternion plain(const Quaternion& q) { return {q.w(), q.x(), q.y(), q.z()}; }

}  // namespace

haptics::LocalModel step_with_local_model(Simulation& simulation, const Pose& target, std::uint64_t seq) {
  simulation.command(0, {seq, target, std::nullopt});
  simulation.step();
  const TickReport& tick = simulation.report();
  const NeedleReport& needle = tick.needles[0];
  const BaseStiffness& base = simulation.base_stiffnesses()[0];
  haptics::LocalModel model;
  model.tick = tick.tick;
  model.time = tick.time;
  model.seq = seq;
  model.base = {plain(needle.commanded.position), plain(needle.commanded.orientation)};
  model.felt = {plain(base.lasting.head<3>()), plain(base.lasting.tail<3>())};
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j) model.stiffness(i, j) = base.stiffness(i, j);
  model.put_limits(base.forward_yield, base.backward_yield, base.forward_limit == ModelLimit::cutting);
  return model;
}

}  // namespace acus
