// SPDX-License-Identifier: GPL-3.0-or-later
// Who holds which needle or guide, and what each was told last: takes poses and spins from holders and passes them to
// the simulation thread as newest values.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "server/runtime/link.h"
#include "server/transport/answers.h"
#include "server/transport/holders.h"
#include "server/transport/served_world.h"

namespace acus {

class CommandStreams {
 public:
  using Clock = std::chrono::steady_clock;

  // In lockstep no client falls silent.
  CommandStreams(const ServedWorld& world, bool lockstep, Link& link, Answers& answers);

  // Another world is commanded from now on; nobody holds anything of it.
  void begin_world();
  // What was commanded before ends.
  void begin_epoch();

  void acquire(const Sender& sender, const protocol::Acquire& request);
  void release(const Sender& sender, const protocol::Release& request);
  void take(const Sender& sender, const protocol::Pose& pose, Clock::time_point now);
  void take(const Sender& sender, const protocol::Spin& spin, Clock::time_point now);

  bool may_change_world(const std::string& client) const { return holders_.may_change_world(client); }
  std::vector<std::string> held() const;  // names

  // Who came through a connection that has ended holds nothing any more.
  void forget_connection(int connection);
  // Descriptors are used again, and a message may be read after its connection has ended: another client that speaks
  // through a connection says that the one before is gone.
  void keep_one_client(const Sender& sender);

  // To whoever sent the body its newest command, as long as the epoch is the command's.
  void tell_limit(const LimitRecord& beyond);

 private:
  // What a needle or guide was told.
  struct Commanded {
    Command newest;  // pose and spin together, whichever message they came in
    CommandOrigin origin;
    Clock::time_point at;
    Sender by;
  };

  template <class Message>
  std::optional<std::vector<int>> find_bodies(const Sender& sender, const Message& message);
  void answer_holding(const Sender& sender, std::uint64_t seq);
  // Calls change(command) on the body's newest command.
  template <class Stream, class Change>
  void update(const Sender& sender, const Stream& stream, Clock::time_point now, Change&& change);

  const ServedWorld& world_;
  const bool lockstep_;
  Link& link_;
  Answers& answers_;
  std::vector<Commanded> bodies_;
  Holders holders_;
  std::unordered_map<int, std::string> clients_;  // that hold something, by their connections
};

}  // namespace acus
