// SPDX-License-Identifier: MIT
// One page that looks, over its WebSocket.
#pragma once

#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <deque>
#include <memory>
#include <string>

#include "client/view/connections.h"
#include "client/view/gateway.h"
#include "client/view/outbox.h"

namespace acus::view {

class Viewer final : public Page, public std::enable_shared_from_this<Viewer> {
 public:
  Viewer(boost::beast::tcp_stream stream, Gateway& gateway, Place place);

  void begin(const boost::beast::http::request<boost::beast::http::empty_body>& upgrade);

  void put(const Frame& frame) override { outbox_.put(frame); }
  void say(const std::string& words) override;
  void tell_of_the_scene() override;
  void jump(double moment) override;
  void recall(const Frame& frame) override;

 private:
  using Bytes = std::shared_ptr<const std::string>;
  struct Message {
    bool text;
    Bytes bytes;
  };

  void expect_token();
  void read();
  void take_text(const std::string& text);
  void take(const std::string& message);
  void beat();  // sends what there is, some sixty times a second, if the page keeps up
  void depart();
  void tell();  // how things stand, if that has changed
  void send_text(std::string text);
  void send(bool text, Bytes bytes);
  void write();
  void close(const char* why);

  boost::beast::websocket::stream<boost::beast::tcp_stream> socket_;
  Gateway& gateway_;
  Place place_;
  boost::asio::steady_timer clock_;
  boost::beast::flat_buffer received_;
  Outbox outbox_;
  std::deque<Message> leaving_;
  std::string told_;
  Bytes hello_, describe_;              // that were sent last
  std::uint64_t beats_ = 0, seen_ = 0;  // departures, and those that the page has taken in
  bool admitted_ = false, closed_ = false;
};

}  // namespace acus::view
