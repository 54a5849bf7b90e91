// SPDX-License-Identifier: GPL-3.0-or-later
// Whether a real-time loop should economise: from a tick whose work took too long until none has for a while. That
// while keeps a loop whose work is just about too much from changing its mind at every tick.
#pragma once

#include <cstdint>

namespace acus {

class OverrunPolicy {
 public:
  explicit OverrunPolicy(std::int64_t recovery) : recovery_(recovery) {}  // ns, > 0

  // Takes in a tick that ended at `now` (ns, never falling); true if the next one shall do with less.
  bool update(std::int64_t now, bool overran) {
    if (overran) last_overrun_ = now;
    economizing_ = overran || (economizing_ && now - last_overrun_ < recovery_);
    return economizing_;
  }

  bool economizing() const { return economizing_; }

 private:
  std::int64_t recovery_;
  std::int64_t last_overrun_ = 0;  // ns, when the last such tick ended
  bool economizing_ = false;
};

}  // namespace acus
