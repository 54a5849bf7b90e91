// SPDX-License-Identifier: GPL-3.0-or-later
// Whether a real-time loop should economise: from a tick that came late until none has for a while. That while keeps
// a loop whose work is just about too much from changing its mind at every tick.
#pragma once

#include <cstdint>

namespace acus {

class OverrunPolicy {
 public:
  explicit OverrunPolicy(std::int64_t recovery) : recovery_(recovery) {}  // ns, > 0

  // Takes in a tick that ended at `now` (ns, never falling); true if the next one shall do with less.
  bool update(std::int64_t now, bool late) {
    if (late) last_late_ = now;
    economizing_ = late || (economizing_ && now - last_late_ < recovery_);
    return economizing_;
  }

  bool economizing() const { return economizing_; }

 private:
  std::int64_t recovery_;
  std::int64_t last_late_ = 0;  // ns, the end of the last late tick
  bool economizing_ = false;
};

}  // namespace acus
