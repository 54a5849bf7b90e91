// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/models/needle/needle_scratch.h"

namespace acus {

NeedleScratch::NeedleScratch(const NeedleModel& model, double time_step, int max_rows)
    : h(time_step), compliance(model.beams, max_rows) {
  const auto nodes = static_cast<std::size_t>(model.nodes());
  iterate.shape.x.setZero(3, model.nodes());
  iterate.shape.frames.assign(nodes, Matrix3::Identity());
  iterate.q.assign(nodes, Quaternion::Identity());
  carried = trial = iterate;
  material.assign(static_cast<std::size_t>(model.beams), Matrix12::Zero());
  g.setZero(6, model.nodes());
  trial_g = g;
  const int free_nodes = model.rigid ? 0 : model.beams;
  if (free_nodes > 0) matrix.resize(free_nodes);
  dq_free.setZero(6 * free_nodes);
  dq = applied = dq_free;
  rows.reserve(static_cast<std::size_t>(max_rows));
  if (!model.hold) return;
  held.emplace(*model.hold, h);
  follow.setZero(6 * free_nodes, 6);
  base_rows.setZero(max_rows, 6);
}

}  // namespace acus
