// SPDX-License-Identifier: GPL-3.0-or-later
// At most so many answers a second to one client, with a burst of as many, so that a client that streams nonsense is
// told so without being flooded. Remembers a bounded number of clients; beyond it, it starts afresh.
#pragma once

#include <algorithm>
#include <chrono>
#include <string>
#include <unordered_map>

namespace acus {

class RateLimiter {
 public:
  using Clock = std::chrono::steady_clock;

  explicit RateLimiter(double per_second) : per_second_(per_second) {}

  bool allow(const std::string& client, Clock::time_point now) {
    if (clients_.size() >= kMaxClients && !clients_.contains(client)) clients_.clear();
    Credit& credit = clients_.try_emplace(client, Credit{per_second_, now}).first->second;
    const double elapsed = std::chrono::duration<double>(now - credit.updated).count();
    credit = {std::min(per_second_, credit.answers + elapsed * per_second_), now};
    if (credit.answers < 1) return false;
    credit.answers -= 1;
    return true;
  }

 private:
  static constexpr std::size_t kMaxClients = 1024;

  struct Credit {
    double answers;
    Clock::time_point updated;
  };
  const double per_second_;
  std::unordered_map<std::string, Credit> clients_;
};

}  // namespace acus
