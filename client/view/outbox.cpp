// SPDX-License-Identifier: MIT
#include "client/view/outbox.h"

#include <algorithm>
#include <cmath>

namespace acus::view {

void Outbox::put(const Frame& frame) {
  ++count_;
  if (frame.topic == "force") {
    const auto [place, is_new] = forces_.try_emplace(frame.needle);
    Forces& forces = place->second;
    if (is_new || frame.force < forces.least.force) forces.least = frame, forces.least_at = count_;
    if (is_new || frame.force > forces.most.force) forces.most = frame, forces.most_at = count_;
    forces.last = frame, forces.last_at = count_;
  } else if (frame.topic == "needle" || frame.topic == "tissue" || frame.topic == "stats") {
    newest_[{frame.topic, frame.needle}] = frame;
  } else {
    const bool event = frame.topic == "event";
    std::deque<Frame>& queue = event ? events_ : others_;
    queue.push_back(frame);
    if (queue.size() <= (event ? kMostEvents : kMostOthers)) return;
    queue.pop_front();
    ++lost_;
  }
}

std::vector<std::shared_ptr<const std::string>> Outbox::take() {
  std::vector<std::shared_ptr<const std::string>> leaving;
  const auto leave = [&](const Frame& frame) { leaving.push_back(frame.bytes); };
  std::for_each(others_.begin(), others_.end(), leave);
  std::for_each(events_.begin(), events_.end(), leave);
  for (const auto& [needle, forces] : forces_) {
    std::pair<std::uint64_t, const Frame*> kept[] = {
        {forces.least_at, &forces.least}, {forces.most_at, &forces.most}, {forces.last_at, &forces.last}};
    std::sort(std::begin(kept), std::end(kept));
    for (std::size_t i = 0; i < std::size(kept); ++i)
      if (i == 0 || kept[i].first != kept[i - 1].first) leave(*kept[i].second);
  }
  for (const auto& [key, frame] : newest_) leave(frame);
  others_.clear();
  events_.clear();
  forces_.clear();
  newest_.clear();
  return leaving;
}

}  // namespace acus::view
