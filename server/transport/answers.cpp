// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/transport/answers.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <new>

#include "server/transport/readable_text.h"
#include "server/transport/request_rules.h"

namespace acus {
namespace {

constexpr double kErrorsPerSecond = 10;                         // to one client, about its streams
constexpr double kErrorLinesPerSecond = 10;                     // about one client
constexpr std::size_t kMaxTypeTold = 100, kMaxSentence = 2000;  // bytes of an error's texts

std::vector<std::string> types_of_requests() {
  std::vector<std::string> types;
  for (const RequestRule& rule : kRequestRules)
    if (!rule.stream) types.emplace_back(rule.type);
  return types;
}

// Throws std::bad_alloc.
zmq::message_t message_of(const std::string& bytes) {
  try {
    return {bytes.data(), bytes.size()};
  } catch (const zmq::error_t&) {
    throw std::bad_alloc();
  }
}

bool is_request(std::string_view type) { return std::ranges::find(request_types(), type) != request_types().end(); }

}  // namespace

const std::vector<std::string>& request_types() {
  static const std::vector<std::string> types = types_of_requests();
  return types;
}

Answers::Answers(zmq::socket_t& commands, const Peers& peers)
    : commands_(commands), peers_(peers), error_limit_(kErrorsPerSecond), log_limit_(kErrorLinesPerSecond) {}

void Answers::reject(const Sender& sender, const protocol::DecodeError& error) {
  ++rejected_;
  const auto now = RateLimiter::Clock::now();
  const bool request = error.type && is_request(*error.type);
  if (!request && !error_limit_.allow(sender.identity, now)) return;
  if (spdlog::should_log(spdlog::level::debug) && log_limit_.allow(sender.identity, now))
    spdlog::debug("rejects '{}' of client {}: {}", readable(error.type.value_or(""), kMaxTypeTold),
                  shown(sender.identity), readable(error.what(), kMaxSentence));
  std::optional<std::string> rejected;
  if (error.type) rejected = readable(*error.type, kMaxTypeTold);
  send(sender, protocol::Error{error.seq, std::move(rejected), error.code(), readable(error.what(), kMaxSentence)});
}

void Answers::log(const Sender& sender, const std::string& what) {
  if (log_limit_.allow(sender.identity, RateLimiter::Clock::now()))
    spdlog::info("client {} at {} {}", shown(sender.identity), peers_.who(sender.connection), what);
}

// The memory is asked for before the first part leaves: after it the rest must follow.
void Answers::send_bytes(const Sender& sender) {
  zmq::message_t body = message_of(bytes_);
  const auto more = zmq::send_flags::sndmore | zmq::send_flags::dontwait;
  if (!commands_.send(zmq::buffer(sender.identity), more)) return;
  if (sender.delimited) commands_.send(zmq::message_t(), more);
  commands_.send(body, zmq::send_flags::dontwait);
}

}  // namespace acus
