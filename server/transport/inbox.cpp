// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/transport/inbox.h"

#include <algorithm>
#include <utility>

#include "server/transport/connection_monitor.h"

namespace acus {

// Frames: identity, an empty one if the client is a REQ, payload.
std::optional<Arrived> Inbox::receive() {
  if (frames_ < 0 && !begin()) return std::nullopt;
  zmq::message_t frame;
  for (int i = 0; i < kFramesAtATime; ++i) {
    [[maybe_unused]] const auto received = socket_.recv(frame, zmq::recv_flags::none);
    const bool last = !frame.more();
    arriving_.size += static_cast<std::int64_t>(frame.size());
    if (++frames_ == 1 && !last) arriving_.sender.delimited = frame.size() == 0;
    if (!last) continue;
    arriving_.frames = frames_;
    arriving_.framed = std::exchange(frames_, -1) == (arriving_.sender.delimited ? 2 : 1);
    arriving_.sender.connection = connection_of(frame);
    arriving_.payload = std::move(frame);
    return std::move(arriving_);
  }
  return std::nullopt;
}

bool Inbox::begin() {
  zmq::message_t routing;
  if (!socket_.recv(routing, zmq::recv_flags::dontwait)) return false;
  arriving_ = {};
  arriving_.sender.identity = routing.to_string();
  frames_ = 0;
  return true;
}

void Inbox::put_aside(Arrived message) {
  waiting_bytes_ += message.payload.size();
  waiting_.push_back(std::move(message));
}

std::optional<Arrived> Inbox::take_waiting() {
  if (waiting_.empty()) return std::nullopt;
  Arrived message = std::move(waiting_.front());
  waiting_.pop_front();
  waiting_bytes_ -= message.payload.size();
  return message;
}

bool Inbox::has_waiting_of(const std::string& client) const {
  return std::any_of(waiting_.begin(), waiting_.end(), [&](const Arrived& m) { return m.sender.identity == client; });
}

void Inbox::forget_connection(int connection) {
  for (Arrived& message : waiting_)
    if (message.sender.connection == connection) message.sender.connection = -1;
}

}  // namespace acus
