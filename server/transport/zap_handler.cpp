// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/transport/zap_handler.h"

#include <spdlog/spdlog.h>

#include <array>
#include <string_view>

namespace acus {
namespace {

constexpr const char* kAddress = "inproc://zeromq.zap.01";  // where ZeroMQ asks
constexpr std::string_view kVersion = "1.0";
constexpr std::size_t kRawKey = 32, kTextKey = 41;  // bytes; the text with its end
constexpr double kRefusalLinesPerSecond = 1;
constexpr int kAnswersPerTurn = 64;

// The frames of a question after the empty one of ROUTER's envelope.
enum Frame : std::size_t { version, request, domain, address, identity, mechanism, credentials };

std::string as_text(const std::string& raw_key) {
  std::array<char, kTextKey> text{};
  if (raw_key.size() != kRawKey) return {};
  zmq_z85_encode(text.data(), reinterpret_cast<const std::uint8_t*>(raw_key.data()), kRawKey);
  return text.data();
}

}  // namespace

ZapHandler::ZapHandler(zmq::context_t& context, const std::vector<protocol::PublicKey>& clients)
    : socket_(context, zmq::socket_type::router), log_limit_(kRefusalLinesPerSecond) {
  for (const protocol::PublicKey& client : clients) clients_.insert(client.key);
  socket_.set(zmq::sockopt::linger, 0);
  socket_.bind(kAddress);
}

void ZapHandler::answer() {
  for (int i = 0; i < kAnswersPerTurn && answer_one(); ++i) {
  }
}

bool ZapHandler::answer_one() {
  zmq::message_t frame;
  if (!socket_.recv(frame, zmq::recv_flags::dontwait)) return false;
  const std::string asking = frame.to_string();
  std::vector<std::string> frames;
  while (frame.more()) {
    [[maybe_unused]] const auto received = socket_.recv(frame, zmq::recv_flags::none);
    if (!frames.empty() || frame.size() > 0) frames.push_back(frame.to_string());
  }
  frames.resize(Frame::credentials + 1);
  const std::string key = as_text(frames[Frame::credentials]);
  const bool admitted = admits(frames[Frame::mechanism], key);
  if (!admitted) log_refusal(frames[Frame::address], key);
  const std::array<std::string_view, 8> answer{asking,
                                               "",
                                               kVersion,
                                               frames[Frame::request],
                                               admitted ? "200" : "400",
                                               admitted ? "OK" : "the server does not know this client's public key",
                                               admitted ? std::string_view(key) : "",
                                               ""};
  for (const std::string_view& part : answer) {
    const auto more = &part == &answer.back() ? zmq::send_flags::none : zmq::send_flags::sndmore;
    socket_.send(zmq::buffer(part), more | zmq::send_flags::dontwait);
  }
  return true;
}

bool ZapHandler::admits(const std::string& mechanism, const std::string& key) const {
  return mechanism == "CURVE" && clients_.contains(key);
}

void ZapHandler::log_refusal(const std::string& address, const std::string& key) {
  ++refused_;
  if (!log_limit_.allow("", RateLimiter::Clock::now())) return;
  spdlog::warn(
      "a client at {} is refused: its public key '{}' is not among those of --curve-clients ({} since the last "
      "such line)",
      address.empty() ? "this machine" : address, key, refused_);
  refused_ = 0;
}

}  // namespace acus
