// SPDX-License-Identifier: GPL-3.0-or-later
// Whether a real-time loop should economise: from a tick whose work took too long until none has for a while. That
// while keeps a loop whose work is just about too much from changing its mind at every tick.
//
// A relapse, which comes before as long a while has gone well with everything, doubles the while, up to kMostWaits
// times the first: a loop whose work is too much for good tries all of it ever less often. Once a while has gone well,
// the next overrun finds the first again.
#pragma once

#include <algorithm>
#include <cstdint>

namespace acus {

class OverrunPolicy {
 public:
  static constexpr std::int64_t kMostWaits = 64;

  explicit OverrunPolicy(std::int64_t recovery) : recovery_(recovery) {}  // ns, 1 to 2^56

  // Takes in a tick that ended at `now` (ns, never falling, >= 0); true if the next one shall do with less.
  bool update(std::int64_t now, bool overran) {
    if (overran) {
      if (!economizing_) wait_ = now - since_ < wait_ ? std::min(2 * wait_, kMostWaits * recovery_) : recovery_;
      economizing_ = true;
      since_ = now;
    } else if (economizing_ && now - since_ >= wait_) {
      economizing_ = false;
      since_ = now;
    }
    return economizing_;
  }

  bool economizing() const { return economizing_; }

 private:
  std::int64_t recovery_;
  std::int64_t wait_ = 0;   // ns, until it recovers and until a relapse is forgiven; 0 before the first overrun
  std::int64_t since_ = 0;  // ns, of the last overrun while economising, else of the recovery
  bool economizing_ = false;
};

}  // namespace acus
