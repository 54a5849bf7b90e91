// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/integration/raw_peer.h"

#include <arpa/inet.h>
#include <doctest/doctest.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <chrono>
#include <cstring>
#include <stdexcept>
#include <thread>

#include "tests/integration/server_process.h"

namespace acus::testing {
namespace {

const std::string kIpc = "ipc://", kTcp = "tcp://127.0.0.1:";

// A connected socket, or -1.
int connect_once(const std::string& endpoint) {
  sockaddr_un path{};
  sockaddr_in port{};
  const sockaddr* address = reinterpret_cast<const sockaddr*>(&path);
  socklen_t size = sizeof path;
  if (endpoint.starts_with(kIpc)) {
    path.sun_family = AF_UNIX;
    std::strncpy(path.sun_path, endpoint.c_str() + kIpc.size(), sizeof path.sun_path - 1);
  } else {
    port.sin_family = AF_INET;
    port.sin_port = htons(static_cast<std::uint16_t>(std::stoi(endpoint.substr(kTcp.size()))));
    port.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address = reinterpret_cast<const sockaddr*>(&port);
    size = sizeof port;
  }
  const int file = socket(address->sa_family, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (file < 0 || connect(file, address, size) == 0) return file;
  close(file);
  return -1;
}

bool readable(int file) {
  pollfd item{file, POLLIN, 0};
  return poll(&item, 1, static_cast<int>(kPatience.count())) == 1;
}

}  // namespace

RawPeer::RawPeer(const std::string& endpoint) {
  const auto deadline = std::chrono::steady_clock::now() + kPatience;
  while ((file_ = connect_once(endpoint)) < 0) {
    if (std::chrono::steady_clock::now() > deadline) throw std::runtime_error("nobody listens on " + endpoint);
    std::this_thread::sleep_for(5ms);
  }
}

RawPeer::~RawPeer() { close(file_); }

bool RawPeer::send(const std::string& bytes) {
  return ::send(file_, bytes.data(), bytes.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(bytes.size());
}

std::string RawPeer::receive(std::size_t size) {
  std::string bytes(size, '\0');
  for (std::size_t got = 0; got < size;) {
    REQUIRE(readable(file_));
    const ssize_t count = recv(file_, bytes.data() + got, size - got, 0);
    REQUIRE(count > 0);
    got += static_cast<std::size_t>(count);
  }
  return bytes;
}

void RawPeer::shake_hands(const std::string& socket_type) {
  send(zmtp3_greeting("NULL"));
  const std::string theirs = receive(64);
  REQUIRE(theirs.substr(12, 5) == std::string("NULL\0", 5));
  const std::string property = "Socket-Type";
  const std::string size{'\0', '\0', '\0', static_cast<char>(socket_type.size())};
  send_command("READY", static_cast<char>(property.size()) + property + size + socket_type);
  const Frame ready = receive_frame();
  REQUIRE(ready.command);
  REQUIRE(ready.body.substr(0, 6) == "\5READY");
}

void RawPeer::send_frame(const std::string& body, bool more) {
  REQUIRE(body.size() < 256);
  send(std::string{static_cast<char>(more ? 1 : 0), static_cast<char>(body.size())} + body);
}

void RawPeer::send_command(const std::string& name, const std::string& data) {
  const std::string body = static_cast<char>(name.size()) + name + data;
  REQUIRE(body.size() < 256);
  send(std::string{'\4', static_cast<char>(body.size())} + body);
}

RawPeer::Frame RawPeer::receive_frame() {
  const char flags = receive(1)[0];
  const bool long_size = (flags & 2) != 0;
  std::size_t size = 0;
  for (const char byte : receive(long_size ? 8 : 1)) size = size << 8 | static_cast<unsigned char>(byte);
  REQUIRE(size < (16u << 20));
  return {(flags & 1) != 0, (flags & 4) != 0, receive(size)};
}

std::string RawPeer::receive_message() {
  Frame frame = receive_frame();
  while (frame.more || frame.command) frame = receive_frame();
  return frame.body;
}

bool RawPeer::is_closed() {
  char dropped[4096];
  const auto deadline = std::chrono::steady_clock::now() + kPatience;
  while (std::chrono::steady_clock::now() < deadline && readable(file_)) {
    if (recv(file_, dropped, sizeof dropped, 0) <= 0) return true;
  }
  return false;
}

std::string zmtp3_greeting(const std::string& mechanism) {
  std::string greeting = "\xff" + std::string(8, '\0') + "\x7f" + std::string("\3\1", 2) + mechanism;
  greeting.resize(64, '\0');
  return greeting;
}

// The length counts the flags, too.
std::string zmtp1_frame(const std::string& body) {
  REQUIRE(body.size() < 254);
  return std::string{static_cast<char>(body.size() + 1), '\0'} + body;
}

std::string zmtp1_greeting() { return zmtp1_frame(""); }

std::string zmtp2_greeting(char socket_type) {
  return "\xff" + std::string(8, '\0') + "\x7f" + std::string{'\1', socket_type, '\0', '\0'};
}

// 'P' is a frame of 80 bytes, and the 'z' after them one of 122, which ends with the header.
std::string web_page_post(const std::string& body) {
  const std::string request = "POST / HTTP/1.1\r\nContent-Length: " + std::to_string(body.size()) + "\r\nX: ";
  std::string header = request + std::string(81 - request.size(), 'x') + 'z';
  header += std::string(81 + 1 + 122 - 4 - header.size(), 'x') + "\r\n\r\n";
  return header + body;
}

}  // namespace acus::testing
