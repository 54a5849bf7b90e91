// SPDX-License-Identifier: GPL-3.0-or-later
// Takes what the simulation thread tells, in its order, and passes it on: states to the publisher, a tick's times to
// the statistics, answers and limits to who deals with clients. Publishes `stats`.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <string>
#include <zmq.hpp>

#include "server/runtime/link.h"
#include "server/transport/listening.h"
#include "server/transport/publisher.h"
#include "server/transport/served_world.h"
#include "server/transport/tick_statistics.h"

namespace acus {

class StateFeed {
 public:
  using Clock = std::chrono::steady_clock;
  struct ForClients {
    std::function<void(Acknowledgement&)> acknowledged;
    std::function<void(const LimitRecord&)> limited;
  };
  // Of `stats`, what others know.
  struct Standing {
    bool paused = false;
    std::uint64_t rejected = 0;
    protocol::RecordingState recording = protocol::RecordingState::off;
  };

  // Binds; throws CannotListen.
  StateFeed(zmq::context_t& context, const std::string& endpoint, const Admission& admission, bool lockstep, Link& link,
            ForClients for_clients);

  zmq::socket_t& socket() { return publisher_.socket(); }
  std::string endpoint() const { return publisher_.endpoint(); }
  std::uint64_t dropped() const { return link_.dropped.load(std::memory_order_relaxed) + publisher_.dropped(); }

  // Takes notices of subscriptions in, and tells the simulation thread what is wanted.
  void update_wanted();
  // A bounded number of records, so that messages have their turn.
  void pass_on(const ServedWorld& world);
  void publish_stats(const ServedWorld& world, const Standing& standing);

  bool all_sent() const { return all_sent_; }  // nothing that the simulation thread said up to pass_on() waits
  bool blocked() const { return blocked_; }    // the publisher holds a state back
  std::chrono::milliseconds until_stats() const {
    return std::chrono::ceil<std::chrono::milliseconds>(begun_ + period_ - Clock::now());
  }

 private:
  bool pass_on_records(const ServedWorld& world);
  bool pass_on_frames(LoadedScene& world);
  void pass_on(Record& record, const LoadedScene& world);
  void add_hash(const ServedWorld& world, protocol::Stats& stats) const;

  Link& link_;
  Publisher publisher_;
  const ForClients for_clients_;
  const bool lockstep_;
  TopicSet wanted_ = 0;
  TickStatistics statistics_;
  Clock::time_point begun_;  // the period of `stats`
  std::chrono::milliseconds period_;
  bool blocked_ = false, all_sent_ = false;
};

}  // namespace acus
