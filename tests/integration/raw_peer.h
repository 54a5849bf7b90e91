// SPDX-License-Identifier: GPL-3.0-or-later
// A peer that writes the bytes of ZMTP, ZeroMQ's protocol on the wire (rfc.zeromq.org/spec/23), by hand, so that it can
// say what no ZeroMQ socket would.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace acus::testing {

class RawPeer {
 public:
  // Connects to ipc://PATH, or to tcp://127.0.0.1:PORT. Throws std::runtime_error if nobody is there within kPatience.
  explicit RawPeer(const std::string& endpoint);
  ~RawPeer();
  RawPeer(const RawPeer&) = delete;
  RawPeer& operator=(const RawPeer&) = delete;

  // False if the other side has closed the connection.
  bool send(const std::string& bytes);

  // Greeting with mechanism NULL and READY, and the other side's; fails the test if it does not answer so.
  void shake_hands(const std::string& socket_type);

  // One frame of a message; a command if it is one.
  struct Frame {
    bool more = false;
    bool command = false;
    std::string body;
  };
  void send_frame(const std::string& body, bool more = false);
  void send_command(const std::string& name, const std::string& data);
  Frame receive_frame();

  // The next message's last frame, commands left out; fails the test if none comes.
  std::string receive_message();

  // Whether the other side closes the connection within kPatience; what it sends until then is dropped.
  bool is_closed();

 private:
  std::string receive(std::size_t size);

  int file_ = -1;
};

// What ZMTP 3.1 says first, with mechanism NULL or CURVE.
std::string zmtp3_greeting(const std::string& mechanism);

// A message of one frame as ZMTP 1.0 knows it, and what such a peer says first: that it has no identity.
std::string zmtp1_frame(const std::string& body);
std::string zmtp1_greeting();

// What ZMTP 2.0 says first: its version, the type of its socket, and that it has no identity.
std::string zmtp2_greeting(char socket_type);

// A POST whose header is shaped so that ZMTP 1.0 reads it as identity and one message, and the body as what follows.
std::string web_page_post(const std::string& body);

}  // namespace acus::testing
