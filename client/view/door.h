// SPDX-License-Identifier: MIT
// Serves the files of the page, recordings and the WebSockets of pages on one port of this machine.
//
// Whoever asks must name this machine (Host: 127.0.0.1 or localhost), and a page that opens a WebSocket must come from
// where it asks (Origin), so that no other site reaches the gateway through a browser.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <memory>
#include <string>

#include "client/view/connections.h"
#include "client/view/gateway.h"

namespace acus::view {

class Door {
 public:
  // Takes the port, 0: any that is free. Throws boost::system::system_error if it is not free.
  Door(boost::asio::io_context& context, unsigned short port);

  // Lets in from now on whoever comes to the gateway, which must live as long as the context runs.
  void open(Gateway& gateway);

  // With the gateway's token.
  std::string url(const Gateway& gateway) const;

 private:
  void accept(Gateway& gateway);
  void accept_later(Gateway& gateway);

  std::shared_ptr<Connections> connections_ = std::make_shared<Connections>();
  boost::asio::ip::tcp::acceptor acceptor_;
  boost::asio::steady_timer pause_;
};

}  // namespace acus::view
