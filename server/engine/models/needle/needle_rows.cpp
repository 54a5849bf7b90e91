// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/models/needle/needle_rows.h"

#include <algorithm>
#include <cassert>

#include "server/engine/models/needle/needle_base.h"

namespace acus {

namespace {

void add_base_compliances(const NeedleModel& model, std::span<const int> places, Eigen::Ref<MatrixX> W,
                          NeedleScratch& scratch) {
  const int count = static_cast<int>(scratch.rows.size());
  for (int r = 0; r < count; ++r)
    scratch.base_rows.row(r) =
        scratch.base_factor.matrixL().solve(follow_node(model, scratch, r, scratch.follow)).transpose();
  for (int r = 0; r < count; ++r)
    for (int s = 0; s <= r; ++s)
      W(std::max(places[r], places[s]), std::min(places[r], places[s])) +=
          scratch.base_rows.row(r).dot(scratch.base_rows.row(s));
}

}  // namespace

int add_needle_row(int beam, const Vector12& force, NeedleScratch& scratch) {
  assert(scratch.rows.size() < scratch.rows.capacity());
  scratch.rows.push_back({beam, force});
  return static_cast<int>(scratch.rows.size()) - 1;
}

void add_needle_compliances(const NeedleModel& model, std::span<const int> places, Eigen::Ref<MatrixX> W,
                            NeedleScratch& scratch) {
  if (!model.rigid) scratch.compliance.add_to(scratch.matrix, scratch.rows, places, W);
  if (scratch.held) add_base_compliances(model, places, W, scratch);
}

double free_displacement(const NeedleModel& model, const NeedleScratch& scratch, int row) {
  if (model.rigid) return scratch.held ? follow_node(model, scratch, row, scratch.follow).dot(scratch.base_free) : 0;
  const auto& [beam, force] = scratch.rows[row];
  const double far = force.tail<6>().dot(scratch.dq_free.segment<6>(6 * beam));
  return far + force.head<6>().dot(beam == 0 ? scratch.base_free : Vector6(scratch.dq_free.segment<6>(6 * (beam - 1))));
}

}  // namespace acus
