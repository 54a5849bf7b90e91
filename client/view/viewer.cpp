// SPDX-License-Identifier: MIT
#include "client/view/viewer.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

namespace acus::view {

namespace {

namespace beast = boost::beast;
namespace websocket = beast::websocket;
using nlohmann::json;

constexpr auto kBeat = std::chrono::microseconds(16'666);
constexpr std::uint64_t kOnTheWay = 3;                     // departures that the page has not told that it has taken in
constexpr auto kTokenPatience = std::chrono::seconds(10);  // for the token
constexpr std::size_t kMostRecalled = 10'000;              // messages that may wait
constexpr std::size_t kLargestToken = 1000, kLargestMessage = 32 << 20;  // bytes; a `restore` is as large

json run_of(const Gateway& gateway) {
  const Playback* run = gateway.run();
  if (run == nullptr) return nullptr;
  const auto rounded = [](double seconds) { return std::round(1e3 * seconds) / 1e3; };
  return {{"at", rounded(run->at())},
          {"length", rounded(run->length())},
          {"whole", run->whole()},
          {"playing", run->playing()},
          {"live", gateway.live()}};
}

}  // namespace

Viewer::Viewer(beast::tcp_stream stream, Gateway& gateway, Place place)
    : socket_(std::move(stream)), gateway_(gateway), place_(std::move(place)), clock_(socket_.get_executor()) {}

void Viewer::begin(const beast::http::request<beast::http::empty_body>& upgrade) {
  beast::get_lowest_layer(socket_).expires_never();  // WebSocket has its own
  auto timeout = websocket::stream_base::timeout::suggested(beast::role_type::server);
  timeout.idle_timeout = std::chrono::seconds(30);
  timeout.keep_alive_pings = true;
  socket_.set_option(timeout);
  socket_.auto_fragment(false);
  socket_.read_message_max(kLargestToken);
  place_.wait([viewer = weak_from_this()] {
    if (const auto self = viewer.lock()) beast::get_lowest_layer(self->socket_).close();
  });
  socket_.async_accept(upgrade, [self = shared_from_this()](const beast::error_code& error) {
    if (error) return;
    self->expect_token();
    self->read();
  });
}

void Viewer::expect_token() {
  clock_.expires_after(kTokenPatience);
  clock_.async_wait([self = shared_from_this()](const beast::error_code& error) {
    if (!error && !self->admitted_) self->close("no token came");
  });
}

void Viewer::read() {
  socket_.async_read(received_, [self = shared_from_this()](const beast::error_code& error, std::size_t) {
    if (error) {
      self->closed_ = true;
      self->clock_.cancel();
      self->gateway_.remove(*self);
      beast::get_lowest_layer(self->socket_).close();  // also where it is only half closed
      return;
    }
    const std::string message = beast::buffers_to_string(self->received_.data());
    self->received_.consume(self->received_.size());
    self->take(message);
    if (!self->closed_) self->read();
  });
}

void Viewer::take(const std::string& message) {
  if (socket_.got_text()) return take_text(message);
  if (!admitted_) return close("the token must come first");
  gateway_.drive(*this, message);
}

void Viewer::take_text(const std::string& text) {
  if (text.size() > kLargestToken) return close("expected a short text");
  const json message = json::parse(text, nullptr, false);
  if (!message.is_object()) return close("expected a JSON object");
  if (!admitted_) {
    const auto token = message.find("token");
    if (token == message.end() || !token->is_string() || !gateway_.is_token(token->get<std::string>()))
      return close("wrong token: open the URL that acus-view printed");
    if (!gateway_.add(*this)) return close("too many pages look already");
    admitted_ = true;
    place_.serve();
    socket_.read_message_max(kLargestMessage);
    send_text(gateway_.choices());
    tell_of_the_scene();
    gateway_.welcome();
    return beat();
  }
  if (const auto beat = message.find("beat"); beat != message.end() && beat->is_number_unsigned())
    seen_ = std::min(beats_, beat->get<std::uint64_t>());
  if (const auto drive = message.find("drive"); drive != message.end() && drive->is_boolean()) {
    if (drive->get<bool>()) {
      gateway_.begin_driving(*this);
    } else {
      gateway_.end_driving(*this);
    }
  }
  const auto play = message.find("play");
  if (play != message.end() && play->is_string()) gateway_.play(*this, play->get<std::string>());
  if (play != message.end() && play->is_null()) gateway_.stop_playing(*this);
  if (const auto run = message.find("run"); run != message.end() && run->is_boolean())
    gateway_.play_run(run->get<bool>());
  if (const auto seek = message.find("seek"); seek != message.end() && seek->is_number())
    gateway_.seek(seek->get<double>());
  if (const auto branch = message.find("branch"); branch != message.end() && branch->is_boolean())
    gateway_.branch(*this, branch->get<bool>());
}

void Viewer::jump(double moment) {
  if (leaving_.size() > kMostRecalled) return;
  outbox_.take();  // void
  send_text(json{{"jump", moment}}.dump());
}

void Viewer::recall(const Frame& frame) {
  if (leaving_.size() <= kMostRecalled) send(false, frame.bytes);
}

void Viewer::say(const std::string& words) {
  send_text(json{{"notice", words}}.dump(-1, ' ', false, json::error_handler_t::replace));
}

void Viewer::tell() {
  json standing{{"server", gateway_.source().here()}, {"driving", gateway_.is_driver(*this)}};
  standing["driven"] = gateway_.driven();
  standing["playing"] = gateway_.playing();
  standing["viewers"] = gateway_.viewers();
  standing["lost"] = outbox_.lost();
  standing["run"] = run_of(gateway_);
  const std::string text = standing.dump();
  if (text == told_) return;
  told_ = text;
  send_text(text);
}

void Viewer::tell_of_the_scene() {
  const Bytes hello = gateway_.source().hello(), describe = gateway_.source().describe();
  if (hello && hello != hello_) send(false, hello);
  if (describe && describe != describe_) send(false, describe);
  hello_ = hello;
  describe_ = describe;
}

void Viewer::beat() {
  if (closed_) return;
  if (leaving_.empty() && beats_ - seen_ < kOnTheWay) depart();
  clock_.expires_after(kBeat);
  clock_.async_wait([self = shared_from_this()](const beast::error_code& error) {
    if (!error) self->beat();
  });
}

void Viewer::depart() {
  tell();
  tell_of_the_scene();
  for (Bytes& bytes : outbox_.take()) send(false, std::move(bytes));
  if (!leaving_.empty()) send_text(json{{"beat", ++beats_}}.dump());
}

void Viewer::send_text(std::string text) { send(true, std::make_shared<const std::string>(std::move(text))); }

void Viewer::send(bool text, Bytes bytes) {
  leaving_.push_back({text, std::move(bytes)});
  if (leaving_.size() == 1) write();
}

void Viewer::write() {
  const Message& next = leaving_.front();
  socket_.text(next.text);
  socket_.async_write(boost::asio::buffer(*next.bytes),
                      [self = shared_from_this()](const beast::error_code& error, std::size_t) {
                        if (error) return;  // reading ends, too
                        self->leaving_.pop_front();
                        if (!self->leaving_.empty()) self->write();
                      });
}

void Viewer::close(const char* why) {
  if (closed_) return;
  closed_ = true;
  clock_.cancel();
  gateway_.remove(*this);
  socket_.async_close({websocket::close_code::policy_error, why},
                      [self = shared_from_this()](const beast::error_code&) {});
}

}  // namespace acus::view
