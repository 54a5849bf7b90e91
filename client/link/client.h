// SPDX-License-Identifier: MIT
// A client of acus-server: one link for commands, one for states; protocol/README.md says what travels on them. Both
// may be opened before the server runs and connect when it appears. A link belongs to one thread at a time; the two
// may be used from two threads. Nothing here allocates without bound: a link that is not read drops the newest states.
//
//   CommandLink commands;
//   const auto hello = commands.hello(10s);   // waits for a server that is not there yet
//   StateLink states;
//   states.subscribe("force");
//   commands.acquire({"needle"}, 1s);         // nobody else may command it then
//   commands.send(pose);
//   if (auto state = states.receive(1s)) ...
#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "client/link/curve_keys.h"
#include "client/link/errors.h"
#include "protocol/codec.h"
#include "protocol/messages.h"

namespace acus::client {

using Timeout = std::chrono::milliseconds;

class Socket;  // a ZeroMQ socket and its context

// Requests and their answers, and the streams of poses and spins.
class CommandLink {
 public:
  // Throws ClientError if ZeroMQ does not accept the endpoint or the keys.
  explicit CommandLink(const std::string& endpoint = protocol::kDefaultCommandsEndpoint,
                       const std::optional<CurveKeys>& keys = std::nullopt);
  ~CommandLink();
  CommandLink(CommandLink&&) noexcept;
  CommandLink& operator=(CommandLink&&) noexcept;

  // Each waits for its answer at most `timeout`, the time to connect included. They throw Vanished, Refused or
  // ProtocolMismatch.
  protocol::HelloReply hello(Timeout timeout);
  protocol::DescribeReply describe(Timeout timeout);
  // What this link holds afterwards. Only a link that holds a needle or guide may send it poses and spins. Refused with
  // ErrorCode::held while another client does. What it holds is released when its connection ends.
  protocol::Holding acquire(const std::vector<std::string>& needles, Timeout timeout);
  protocol::Holding release(const std::vector<std::string>& needles, Timeout timeout);
  protocol::HashReply hash(Timeout timeout);
  protocol::SnapshotReply snapshot(Timeout timeout);
  protocol::Done pause(Timeout timeout);
  protocol::Done resume(Timeout timeout);
  protocol::Done reset(Timeout timeout);
  protocol::Done load(const std::string& scene, Timeout timeout);       // path on the server's machine
  protocol::Done load_text(const std::string& scene, Timeout timeout);  // YAML
  protocol::Done restore(const std::vector<std::uint8_t>& snapshot, Timeout timeout);
  // Records into a new file of the server's folder for recordings, from the next tick on, until it shall end.
  protocol::Done record(const std::string& file, Timeout timeout);
  protocol::Done end_recording(Timeout timeout);
  protocol::Done step(std::uint32_t ticks, Timeout timeout);
  protocol::Done shutdown(Timeout timeout);

  // Whether the server is there, as far as is known now. Does not wait.
  bool connected();

  // Hands a command over without waiting. False if there is no connection to take it: the server is not there, or
  // does not read. An accepted command may still be rejected later, see next_rejection().
  [[nodiscard]] bool send(const protocol::Pose& pose);
  [[nodiscard]] bool send(const protocol::Spin& spin);

  // The oldest rejection of a pose or spin that was not asked for yet. Does not wait. The newest kMaxRejections are
  // kept while a request waits for its answer.
  std::optional<protocol::Error> next_rejection();
  static constexpr std::size_t kMaxRejections = 1000;

 private:
  template <class Answer, class Request>
  Answer request(Request request, Timeout timeout);
  template <class Message>
  bool send_now(const Message& message);
  void keep_rejection(const protocol::Error& error);

  std::unique_ptr<Socket> socket_;
  std::string buffer_;  // of the message being encoded
  std::uint64_t last_request_ = 0;
  std::deque<protocol::Error> rejections_;
};

// The published states of the subscribed topics, in the order in which the server sent them.
class StateLink {
 public:
  static constexpr int kCapacity = 100'000;

  // Holds at most `capacity` states that were not received yet. Throws ClientError if ZeroMQ does not accept the
  // endpoint or the keys.
  explicit StateLink(const std::string& endpoint = protocol::kDefaultStatesEndpoint, int capacity = kCapacity,
                     const std::optional<CurveKeys>& keys = std::nullopt);
  ~StateLink();
  StateLink(StateLink&&) noexcept;
  StateLink& operator=(StateLink&&) noexcept;

  // force, needle, tissue, event, stats or haptics. Takes effect when the server has heard of it, which is after this
  // returns: a `stats` message that arrives tells that every earlier subscription of this link is in effect.
  void subscribe(const std::string& topic);
  void unsubscribe(const std::string& topic);

  // The next state, or nothing if none came in time. Throws ProtocolMismatch.
  std::optional<protocol::State> receive(Timeout timeout);

 private:
  std::unique_ptr<Socket> socket_;
};

}  // namespace acus::client
