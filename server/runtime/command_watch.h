// SPDX-License-Identifier: GPL-3.0-or-later
// How well commands for one needle or guide come in, tick by tick, and what becomes of the force that a hand feels when
// they do not: fresh commands keep it whole, stale ones ramp it down to nothing.
#pragma once

#include <algorithm>
#include <bitset>
#include <cmath>
#include <cstdint>

namespace acus {

// Constant after loading.
struct CommandLimits {
  double time_step = 1e-3;    // s
  double stale_after = 0.1;   // s without a command, > 0, may be infinite
  double ramp = 0.05;         // s in which the force goes from whole to nothing, and back
};

class CommandMonitor {
 public:
  static constexpr std::size_t kWindow = 100;  // ticks

  explicit CommandMonitor(const CommandLimits& limits = {}) : limits_(limits) {}

  // A tick that took a fresh command in, or did not. Returns whether commands have just become stale.
  bool tick(bool fresh) {
    commanded_ = commanded_ || fresh;
    recent_ = (recent_ << 1) | std::bitset<kWindow>(fresh ? 1 : 0);
    ticks_without_ = fresh ? 0 : ticks_without_ + 1;
    const bool was_stale = stale_;
    abandoned_ = abandoned_ && !fresh;
    stale_ = commanded_ && (abandoned_ || age() > limits_.stale_after);
    const double step = limits_.ramp > 0 ? limits_.time_step / limits_.ramp : 1;
    if (commanded_) share_ = std::clamp(share_ + (stale_ ? -step : step), 0.0, 1.0);
    return stale_ && !was_stale;
  }

  // Its client is gone: commands are stale from the next tick on, until another comes.
  void abandon() { abandoned_ = true; }

  // A new epoch of the same world: no command was given in it. A force that is ramped down stays so till the first.
  void begin_epoch() {
    const double share = share_;
    *this = CommandMonitor(limits_);
    share_ = share;
  }

  bool stale() const { return stale_; }
  double age() const {  // s of ticks since the last command; 0 before the first
    return commanded_ ? static_cast<double>(ticks_without_) * limits_.time_step : 0;
  }
  double fresh_share() const { return static_cast<double>(recent_.count()) / kWindow; }
  void limit() { ++limited_; }  // a command asked for more than the scene allows
  std::uint64_t limited() const { return limited_; }
  double force_share() const { return share_; }  // in [0, 1], of the force, that a hand shall feel

 private:
  CommandLimits limits_;
  bool commanded_ = false, abandoned_ = false, stale_ = false;
  std::uint64_t ticks_without_ = 0, limited_ = 0;
  double share_ = 1;
  std::bitset<kWindow> recent_;
};

// What the commands' own numbers say.
struct CommandOrigin {
  double time = 0;              // s, of the newest command, on its client's clock
  std::uint64_t lost = 0;       // numbers that never came
  std::uint64_t reordered = 0;  // commands whose number was not above those before
};

// Takes a client's next command in: its number, after the largest one before (0: this is the first), and its time. One
// that comes late was counted as lost.
inline void count_command(CommandOrigin& origin, std::uint64_t& largest_seq, std::uint64_t seq, double time) {
  origin.time = time;
  if (largest_seq > 0 && seq > largest_seq) origin.lost += seq - largest_seq - 1;
  if (seq <= largest_seq) {
    ++origin.reordered;
    if (seq < largest_seq && origin.lost > 0) --origin.lost;
  }
  largest_seq = std::max(largest_seq, seq);
}

}  // namespace acus
