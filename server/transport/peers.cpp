// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/transport/peers.h"

#include <spdlog/spdlog.h>
#include <sys/socket.h>

#include <algorithm>
#include <utility>

namespace acus {

namespace {

constexpr double kLinesPerSecond = 20;

// What ZeroMQ knows of the connection that a message came through; empty if nothing.
std::string property(const zmq::message_t& message, const char* name) {
  const char* value = zmq_msg_gets(message.handle(), name);
  return value ? value : "";
}

// Of an ipc endpoint.
std::string process_behind(int connection) {
  ucred peer{};
  socklen_t size = sizeof peer;
  if (getsockopt(connection, SOL_SOCKET, SO_PEERCRED, &peer, &size) != 0 || peer.pid <= 0) return "this machine";
  return fmt::format("process {} of user {}", peer.pid, peer.uid);
}

}  // namespace

Peers::Peers(std::vector<protocol::PublicKey> keys) : keys_(std::move(keys)), log_limit_(kLinesPerSecond) {}

void Peers::note(const Arrived& message) {
  const auto [place, fresh] = peers_.try_emplace(message.sender.connection);
  if (!fresh || message.sender.connection < 0) return;
  place->second = {message.sender.identity, describe(message)};
  log(place->second, "connects");
}

void Peers::forget(int connection) {
  const auto peer = peers_.extract(connection);
  if (!peer.empty()) log(peer.mapped(), "disconnects");
}

std::string Peers::who(int connection) const {
  const auto peer = peers_.find(connection);
  return peer == peers_.end() || connection < 0 ? "nobody known" : peer->second.who;
}

std::string Peers::describe(const Arrived& message) const {
  const std::string address = property(message.payload, "Peer-Address"), key = property(message.payload, "User-Id");
  const std::string from = address.empty() ? process_behind(message.sender.connection) : address;
  if (key.empty()) return from;
  const auto known = std::ranges::find(keys_, key, &protocol::PublicKey::key);
  const bool named = known != keys_.end() && !known->name.empty();
  return named ? fmt::format("{} with the key of '{}', {}", from, known->name, key)
               : fmt::format("{} with the key {}", from, key);
}

void Peers::log(const Peer& peer, const char* what) {
  if (!log_limit_.allow("", RateLimiter::Clock::now())) {
    ++unlogged_;
    return;
  }
  const std::uint64_t others = std::exchange(unlogged_, 0);
  spdlog::info("client {} at {} {}{}", shown(peer.client), peer.who, what,
               others == 0 ? "" : fmt::format(" ({} such lines before it were left out)", others));
}

std::string shown(const std::string& client) {
  std::string text;
  for (const unsigned char byte : client) text += fmt::format("{:02x}", byte);
  return text;
}

}  // namespace acus
