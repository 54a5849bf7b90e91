// SPDX-License-Identifier: GPL-3.0-or-later
// Ends connections through which a client would use up the process, where ZeroMQ has no bound of its own: a message
// that never ends (its frames wait in memory for the last one), subscriptions without end, connections without end.
// Where clients have keys, those of whom no message was read yet may be strangers: they have less room, and where there
// are many the oldest one goes.
//
// What waits of a connection are the bytes that the system has received from it, less those of messages that were read
// whole and an allowance for what ZeroMQ says by itself. Of TCP alone: for ipc the system does not count.
//
// Looks from a thread of its own: ZeroMQ takes all subscriptions in that have come, however many, and holds up the
// thread that asks it for one.
#pragma once

#include <chrono>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>
#include <thread>
#include <zmq.hpp>

#include "server/transport/connection_monitor.h"
#include "server/transport/inbox.h"
#include "server/transport/rate_limiter.h"

namespace acus {

class ConnectionGuard {
 public:
  // To be made when the process has opened what it needs to serve. Watches the subscribers of `states` by itself, and
  // those who command as note() tells.
  ConnectionGuard(zmq::context_t& context, zmq::socket_t& states, bool keys);
  ~ConnectionGuard();
  ConnectionGuard(const ConnectionGuard&) = delete;
  ConnectionGuard& operator=(const ConnectionGuard&) = delete;

  void note(const ConnectionChange& change) { note(change, false); }
  void took(const Arrived& message);

 private:
  // The sockets' monitors tell of their connections at different times, so that one may end after another has begun
  // that has its descriptor.
  struct Key {
    int connection = -1;
    bool subscribes = false;

    auto operator<=>(const Key&) const = default;
  };
  struct Account {
    std::int64_t settled = 0;  // bytes that do not wait, of those received
    std::int64_t read = 0;     // bytes of messages since the last look
    std::uint64_t stranger =
        0;                   // number in strangers_ of one that may have no key: no message of it was read; 0: has one
    bool suspected = false;  // it had more than a stranger may at the last look
  };
  using Accounts = std::map<Key, Account>;

  void note(const ConnectionChange& change, bool subscribes);
  void forget(const Key& key);
  void cut_stranger(const Key& key);
  void run(const std::stop_token& stop);
  void wait_and_look();
  void look(double seconds);  // since the last time
  Accounts begin_look();
  void settle(const Accounts& seen);
  void cut(const Key& key, const char* why);

  const std::size_t most_;  // connections
  const bool keys_;
  ConnectionMonitor subscribers_;
  std::mutex mutex_;
  Accounts accounts_;
  std::map<std::uint64_t, Key> strangers_;  // in the order in which they came
  std::uint64_t last_stranger_ = 0;
  std::int64_t resident_;  // bytes of the process when hardly anything waited, before the first cut
  std::chrono::steady_clock::time_point last_look_, last_cut_;
  bool has_cut_ = false;  // for the end of a message
  RateLimiter log_limit_;
  std::jthread thread_;
};

}  // namespace acus
