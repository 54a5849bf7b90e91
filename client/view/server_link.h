// SPDX-License-Identifier: MIT
// The gateway's connections to the server: states for all viewers, and commands of the one that drives. Frames are
// handed on as they came; what the gateway has to know of them it reads with the protocol's codec.
//
// Belongs to the thread that runs the context.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "client/link/client.h"
#include "client/view/source.h"

namespace acus::view {

struct ServerAddress {
  std::string commands, states;
  std::optional<client::CurveKeys> keys;
};

// A ZeroMQ socket whose messages a context's thread takes in.
class WatchedSocket;

class ServerLink : public Source {
 public:
  ServerLink(boost::asio::io_context& context, ServerAddress address, Listener listener);
  ~ServerLink() override;

  // Whether the server has answered within the last seconds.
  bool here() const override { return here_; }
  bool lockstep() const override { return lockstep_; }
  Bytes hello() const override { return hello_; }
  Bytes describe() const override { return describe_; }
  void watch(bool wanted) override;
  // A connection of its own.
  void begin_driving() override;
  void end_driving() override;
  void drive(std::string_view message) override;

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
  Bytes hello_, describe_;
};

}  // namespace acus::view
