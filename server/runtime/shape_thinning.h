// SPDX-License-Identifier: GPL-3.0-or-later
// Which of the shapes that are due go out. Where a tick that packed shapes took longer than its period, by its own
// work, the next publish_every - 1 shapes of its topic are left out, of the tissue where both were packed: it is the
// larger one. Then one is tried again. So shapes are left out in at most publish_every - 1 times as many ticks as took
// too long, and a tick that took too long without them costs none.
#pragma once

#include <algorithm>
#include <array>

#include "server/runtime/link.h"

namespace acus {

class ShapeThinning {
 public:
  explicit ShapeThinning(int every) : left_out_after_(std::max(every, 1) - 1) {}

  // Begins a tick in which shapes of these topics, needle or tissue, are due; returns those that go out.
  TopicSet begin(TopicSet due) {
    packed_ = 0;
    left_out_ = false;
    for (const Topic topic : {Topic::needle, Topic::tissue}) {
      if (!(due & bit(topic))) continue;
      int& left = left_[topic == Topic::tissue];
      left_out_ = left_out_ || left > 0;
      if (left > 0)
        --left;
      else
        packed_ |= bit(topic);
    }
    return packed_;
  }
  // Ends it.
  void end(bool overran) {
    if (overran && packed_ != 0) left_[(packed_ & bit(Topic::tissue)) != 0] = left_out_after_;
  }
  // Whether a shape was left out in this tick.
  bool left_out() const { return left_out_; }

 private:
  int left_out_after_;
  std::array<int, 2> left_{};  // shapes of needle, tissue that are yet to be left out
  TopicSet packed_ = 0;
  bool left_out_ = false;
};

}  // namespace acus
