// SPDX-License-Identifier: GPL-3.0-or-later
// Requests that are with the simulation thread, and whom to answer.
#pragma once

#include <algorithm>
#include <cassert>
#include <cstdint>
#include <optional>
#include <string>
#include <unordered_map>
#include <utility>

#include "server/runtime/link.h"
#include "server/transport/inbox.h"

namespace acus {

class PendingRequests {
 public:
  explicit PendingRequests(Link& link) : link_(link) {}

  // Whether one more can be passed on.
  bool has_room() { return link_.requests.writable() != nullptr; }

  // Passes a request on, which needs room; nobody waits for an answer.
  template <class What>
  void post(What what) {
    Request* request = link_.requests.writable();
    assert(request);
    *request = Request{++last_, std::move(what)};
    link_.requests.commit();
    link_.to_simulation.signal();
  }
  // The same for a client.
  template <class What>
  void ask(const Sender& sender, std::uint64_t seq, What what) {
    post(std::move(what));
    waiting_[last_] = {sender.identity, sender.delimited, seq, sender.connection};
  }

  // Whom to answer now that it is done, if anybody.
  std::optional<Sender> finish(std::uint64_t id) {
    const auto found = waiting_.extract(id);
    return found.empty() ? std::nullopt : std::optional<Sender>(std::move(found.mapped()));
  }

  bool none() const { return waiting_.empty(); }
  bool any_of(const std::string& client) const {
    return std::ranges::any_of(waiting_, [&](const auto& each) { return each.second.identity == client; });
  }

  // Its connection has ended: a `step` of it goes no further.
  void abandon(int connection) {
    for (const auto& [id, sender] : waiting_)
      if (sender.connection == connection) link_.abandoned.store(id, std::memory_order_relaxed);
  }

 private:
  Link& link_;
  std::uint64_t last_ = 0;
  std::unordered_map<std::uint64_t, Sender> waiting_;
};

}  // namespace acus
