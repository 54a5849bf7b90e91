// SPDX-License-Identifier: MIT
// A ZeroMQ socket whose messages the thread of an Asio context takes in as they come.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/post.hpp>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "client/link/socket.h"

namespace acus::view {

class WatchedSocket {
 public:
  using Take = std::function<void(std::string_view)>;

  template <class Configure>
  WatchedSocket(boost::asio::io_context& context, zmq::socket_type type, const std::string& endpoint,
                const std::optional<client::CurveKeys>& keys, Take take, Configure configure)
      : core_(std::make_shared<Core>(context, type, endpoint, keys, std::move(take), configure)) {
    core_->wait();
  }
  ~WatchedSocket() { core_->close(); }
  WatchedSocket(const WatchedSocket&) = delete;
  WatchedSocket& operator=(const WatchedSocket&) = delete;

  zmq::socket_t& raw() { return core_->socket.raw(); }

  // Without waiting; false if nobody is there to take it.
  bool send(std::string_view bytes) {
    const bool sent = core_->socket.send(bytes);
    core_->take_all_soon();  // ZeroMQ's descriptor tells once of what came meanwhile
    return sent;
  }

 private:
  struct Core : std::enable_shared_from_this<Core> {
    template <class Configure>
    Core(boost::asio::io_context& context, zmq::socket_type type, const std::string& endpoint,
         const std::optional<client::CurveKeys>& keys, Take on_message, Configure configure)
        : socket(type, endpoint, keys, configure),
          descriptor(context, socket.raw().get(zmq::sockopt::fd)),
          take(std::move(on_message)) {}

    // The descriptor is readable when the socket's state may have changed, and not again before that was looked at.
    void wait() {
      descriptor.async_wait(descriptor.wait_read, [self = shared_from_this()](const boost::system::error_code& error) {
        if (error || self->closed) return;
        self->take_all();
        if (!self->closed) self->wait();
      });
    }
    void take_all() {
      for (std::string_view bytes; !closed && socket.receive(bytes);) take(bytes);
    }
    void take_all_soon() {
      boost::asio::post(descriptor.get_executor(), [self = shared_from_this()] {
        if (!self->closed) self->take_all();
      });
    }
    void close() {
      closed = true;
      descriptor.release();  // it is ZeroMQ's
    }

    client::Socket socket;
    boost::asio::posix::stream_descriptor descriptor;
    Take take;
    bool closed = false;
  };

  std::shared_ptr<Core> core_;
};

}  // namespace acus::view
