// SPDX-License-Identifier: GPL-3.0-or-later
// The messages of clients, one whole message at a time, and those that have come and have to wait. Both are bounded:
// what does not fit stays with ZeroMQ, which has few places for each client and makes it wait.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <string_view>
#include <zmq.hpp>

namespace acus {

// Whom to answer, and about what.
struct Sender {
  std::string identity;    // the client's routing frame
  bool delimited = false;  // whether an empty frame stood before the payload, as REQ sends it
  std::uint64_t seq = 0;   // of the request
  int connection = -1;     // that the message came through, while it is open
};

struct Arrived {
  Sender sender;
  bool framed = false;  // as the protocol wants it: one frame, or an empty one and one more
  zmq::message_t payload;
  std::int64_t frames = 0, size = 0;  // of the whole message, and the bytes in them

  std::string_view bytes() const { return payload.to_string_view(); }
};

class Inbox {
 public:
  explicit Inbox(zmq::socket_t& socket) : socket_(socket) {}

  // The next message; nothing if none has come whole. Frames of one that has too many are read a number at a time, so
  // that a message of millions holds nothing else up.
  std::optional<Arrived> receive();

  // Messages that came and wait, first come, first served.
  bool full() const { return waiting_.size() >= kMaxWaiting || waiting_bytes_ >= kMaxWaitingBytes; }
  void put_aside(Arrived message);
  std::optional<Arrived> take_waiting();
  bool has_waiting() const { return !waiting_.empty(); }
  bool has_waiting_of(const std::string& client) const;
  void forget_connection(int connection);  // it has ended

 private:
  static constexpr std::size_t kMaxWaiting = 1024, kMaxWaitingBytes = 4 << 20;
  static constexpr int kFramesAtATime = 1024;

  bool begin();

  zmq::socket_t& socket_;
  Arrived arriving_;
  std::int64_t frames_ = -1;  // of arriving_ without its routing frame; -1 between two messages
  std::deque<Arrived> waiting_;
  std::size_t waiting_bytes_ = 0;
};

}  // namespace acus
