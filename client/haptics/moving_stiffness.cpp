// SPDX-License-Identifier: MIT
#include "client/haptics/moving_stiffness.h"

#include <algorithm>
#include <cmath>

namespace acus::haptics {

void MovingStiffness::learn_softest(double met, bool touches, double force_then, double force_now) {
  if (touches && met > 0 && met * kDeepest >= force_now) softest_ = softest_ > 0 ? std::min(softest_, met) : met;
  if (!touches && softest_ > 0 && force_now > force_then) softest_ = std::max(softest_, met);
}

void MovingStiffness::add(const LocalModel& model, double stiffness, double ahead) {
  newest_ = (newest_ + 1) % kKept;
  count_ = std::min(count_ + 1, kKept);
  const bool free = model.is_free();
  past_[static_cast<std::size_t>(newest_)] = {model.base.position, model.felt.force, stiffness, free};
  free_ticks_ = free ? free_ticks_ + 1 : 0;
  if (free) free_ = stiffness;
  if (free && (value_ == 0 || free_ticks_ > kTicks)) value_ = stiffness;
  const bool touches = model.backward_limit == Limit::contact;
  if (free) softest_ = 0;
  const Vector3 axis = model.base.orientation * Vector3{{1, 0, 0}};
  double told = 0;  // N, by the stiffness of the ticks on the way
  for (int i = 1; i < count_ && !free; ++i) {
    const Past& then = past_[static_cast<std::size_t>((newest_ - i + kKept) % kKept)];
    const Past& next = past_[static_cast<std::size_t>((newest_ - i + 1 + kKept) % kKept)];
    if (then.free) return;
    told += next.stiffness * dot(axis, next.position - then.position);
    const double way = dot(axis, model.base.position - then.position);
    if (std::abs(way) < kShortest) continue;
    const double met = std::max(dot(axis, then.force - model.felt.force) / way, 0.0);
    value_ = std::max(told / way - met, 0.0);
    learn_softest(met, touches, norm(then.force), norm(model.felt.force));
    if (i >= kTicks && std::abs(way) >= std::abs(ahead)) return;
  }
}

}  // namespace acus::haptics
