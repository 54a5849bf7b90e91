// SPDX-License-Identifier: MIT
// The gateway's connections to the server: states for all viewers, and commands of the one that drives. Frames are
// handed on as they came; what the gateway has to know of them it reads with the protocol's codec.
//
// Belongs to the thread that runs the context.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "client/client.h"
#include "client/view/outbox.h"

namespace acus::view {

struct ServerAddress {
  std::string commands, states;
  std::optional<client::CurveKeys> keys;
};

// A ZeroMQ socket whose messages a context's thread takes in.
class WatchedSocket;

class ServerLink {
 public:
  struct Listener {
    std::function<void(const Frame&)> state;   // of the states socket
    std::function<void(const Frame&)> answer;  // to what drive() sent
    std::function<void()> arrived;             // the server is here, which it was not
  };

  ServerLink(boost::asio::io_context& context, ServerAddress address, Listener listener);
  ~ServerLink();

  // Whether the server has answered within the last seconds.
  bool here() const { return here_; }
  bool lockstep() const { return lockstep_; }
  // The server's newest `hello_reply` and the `describe_reply` of its epoch's scene, as they came; null: none yet.
  const std::shared_ptr<const std::string>& hello() const { return hello_; }
  const std::shared_ptr<const std::string>& describe() const { return describe_; }

  // Whether states are asked for: only while somebody looks.
  void watch(bool wanted);

  // A connection of its own for the commands of one viewer. What it holds is released when it ends.
  void begin_driving();
  void end_driving();
  void drive(std::string_view message);  // nothing happens while no server is here

 private:
  void ask_again();
  void take_answer(std::string_view bytes);
  void take_hello(const protocol::HelloReply& hello, std::string_view bytes);

  boost::asio::io_context& context_;
  ServerAddress address_;
  Listener listener_;
  std::unique_ptr<WatchedSocket> states_, questions_, driving_;
  boost::asio::steady_timer clock_;
  bool here_ = false, watching_ = false, lockstep_ = false;
  int unanswered_ = 0;  // times that `hello` was sent since the last answer
  std::uint64_t seq_ = 0;
  std::optional<std::pair<std::uint64_t, std::uint64_t>> described_;  // instance and epoch
  std::shared_ptr<const std::string> hello_, describe_;
};

}  // namespace acus::view
