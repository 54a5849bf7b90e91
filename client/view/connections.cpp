// SPDX-License-Identifier: MIT
#include "client/view/connections.h"

#include <utility>

namespace acus::view {

bool Connections::make_room() {
  if (count_ < kMost) return true;
  if (waiting_.empty()) return false;
  Entry& first = *waiting_.front();
  waiting_.pop_front();
  first.waiting = first.counted = false;
  --count_;
  std::exchange(first.end, {})();
  return true;
}

Place::Place(std::shared_ptr<Connections> connections)
    : connections_(std::move(connections)), entry_(std::make_unique<Connections::Entry>()) {
  ++connections_->count_;
}

Place::~Place() {
  if (!entry_) return;
  serve();
  if (entry_->counted) --connections_->count_;
}

void Place::wait(std::function<void()> end) {
  serve();
  if (!entry_->counted) return end();
  entry_->end = std::move(end);
  entry_->waiting = true;
  connections_->waiting_.push_back(entry_.get());
}

void Place::serve() {
  if (!entry_->waiting) return;
  connections_->waiting_.remove(entry_.get());
  entry_->waiting = false;
  entry_->end = {};
}

}  // namespace acus::view
