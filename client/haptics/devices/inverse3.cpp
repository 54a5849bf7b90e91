// SPDX-License-Identifier: MIT
#include "client/haptics/devices/inverse3.h"

#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>
#include <utility>

namespace acus::haptics {

// What one message of the service tells; fields that it lacks stay as they were.
struct Inverse3State {
  std::string device;
  Device::Reading reading;
};

namespace {

namespace beast = boost::beast;
namespace websocket = beast::websocket;
using Tcp = boost::asio::ip::tcp;
using nlohmann::json;

constexpr auto kAnswerPatience = std::chrono::seconds(2);
constexpr auto kSilence = std::chrono::milliseconds(500);  // without a message: the service is gone
constexpr std::size_t kLargest = 1 << 20;                  // bytes of a message

// Chosen, not measured: low damping, and a millisecond for the service and its USB.
DeviceProperties properties_of(double rate) {
  DeviceProperties properties;
  properties.rate = rate;
  properties.delay = 1e-3;
  properties.translation = {0.2, 0.5, 0.05, 20e-6, 10};
  properties.rotation.largest_force = 0;  // three axes of force
  return properties;
}

// Throws json::exception for a message of another form.
void take_message(const json& message, Inverse3State& state) {
  if (!message.is_object()) throw json::other_error::create(501, "no JSON object", &message);
  if (const auto found = message.find("inverse3"); found != message.end() && found->is_array() && !found->empty()) {
    const json& device = found->front();
    state.device = device.value("device_id", state.device);
    if (const json position = device.value("state", json::object()).value("cursor_position", json());
        position.is_object())
      state.reading.pose.position = {{position.value("x", 0.0), position.value("y", 0.0), position.value("z", 0.0)}};
  }
  for (const char* kind : {"wireless_verse_grip", "verse_grip"}) {
    const auto found = message.find(kind);
    if (found == message.end() || !found->is_array() || found->empty()) continue;
    const json grip = found->front().value("state", json::object());
    if (const json q = grip.value("orientation", json()); q.is_object())
      state.reading.pose.orientation =
          normalized({q.value("w", 1.0), q.value("x", 0.0), q.value("y", 0.0), q.value("z", 0.0)});
    state.reading.clutch = grip.value("buttons", json::object()).value("a", false);
  }
}

std::string force_message(const std::string& device, const Vector3& force) {
  const json values{{"x", force[0]}, {"y", force[1]}, {"z", force[2]}};
  return json{
      {"inverse3", json::array({{{"device_id", device}, {"commands", {{"set_cursor_force", {{"values", values}}}}}}})}}
      .dump();
}

}  // namespace

// The connection, which a thread of its own serves: each message of the service is answered by the newest force.
class Inverse3::Link {
 public:
  // Throws std::exception if there is no connection within kAnswerPatience.
  Link(const std::string& host, const std::string& port) {
    Tcp::resolver resolver(context_);
    const auto addresses = resolver.resolve(host, port);
    beast::error_code outcome = boost::asio::error::would_block;
    beast::get_lowest_layer(socket_).async_connect(addresses, [&](beast::error_code trouble, const Tcp::endpoint&) {
      if ((outcome = trouble)) return;
      outcome = boost::asio::error::would_block;
      beast::get_lowest_layer(socket_).socket().set_option(Tcp::no_delay(true));
      beast::get_lowest_layer(socket_).expires_never();
      socket_.set_option(websocket::stream_base::timeout{kAnswerPatience, kSilence, false});
      socket_.read_message_max(kLargest);
      socket_.async_handshake(host + ":" + port, "/", [&](beast::error_code refused) { outcome = refused; });
    });
    // All of it within one limit: a service that answers byte by byte does not answer.
    context_.run_for(kAnswerPatience);
    if (outcome == boost::asio::error::would_block) throw std::runtime_error("it does not answer");
    if (outcome) throw std::runtime_error(outcome.message());
    context_.restart();
    listen();
    thread_ = std::thread([this] { context_.run(); });
  }

  ~Link() {
    {
      std::unique_lock lock(mutex_);
      force_ = {};
      closing_ = true;
      changed_.wait_for(lock, kSilence, [this] { return let_go_; });
    }
    context_.stop();
    thread_.join();
  }

  bool wait_for_device() {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, kAnswerPatience, [this] { return !state_.device.empty() || !failure_.empty(); });
    return !state_.device.empty();
  }

  Reading reading() {
    const std::lock_guard lock(mutex_);
    if (!failure_.empty()) throw DeviceError("inverse3: " + failure_);
    return state_.reading;
  }

  void set_force(const Vector3& force) {
    const std::lock_guard lock(mutex_);
    if (failure_.empty()) force_ = force;
  }

 private:
  void listen() {
    socket_.async_read(buffer_, [this](beast::error_code trouble, std::size_t) {
      if (trouble) return fail(trouble.message());
      const json message = json::parse(beast::buffers_to_string(buffer_.data()), nullptr, false);
      buffer_.clear();
      answer(message);
    });
  }

  void answer(const json& message) {
    bool last = false;
    {
      const std::lock_guard lock(mutex_);
      try {
        take_message(message, state_);
      } catch (const json::exception& error) {
        failure_ = std::string("the service sent a message of another form: ") + error.what();
        force_ = {};  // the last that it hears
      }
      reply_ = force_message(state_.device, force_);
      last = closing_ || !failure_.empty();
    }
    changed_.notify_all();
    socket_.async_write(boost::asio::buffer(reply_), [this, last](beast::error_code trouble, std::size_t) {
      if (trouble) return fail(trouble.message());
      if (!last) return listen();
      {
        const std::lock_guard lock(mutex_);
        let_go_ = true;
      }
      changed_.notify_all();
    });
  }

  void fail(const std::string& why) {
    {
      const std::lock_guard lock(mutex_);
      if (failure_.empty()) failure_ = why;
      let_go_ = true;  // nothing more can be said
    }
    changed_.notify_all();
  }

  boost::asio::io_context context_;
  websocket::stream<beast::tcp_stream> socket_{context_};
  beast::flat_buffer buffer_;
  std::string reply_;

  std::mutex mutex_;  // of all below
  std::condition_variable changed_;
  Inverse3State state_;
  Vector3 force_;
  std::string failure_;
  bool closing_ = false;
  bool let_go_ = false;  // no force is left, as far as it can be said

  std::thread thread_;
};

Inverse3::Inverse3(const std::string& address, double rate) : rate_(rate) {
  const std::string scheme = "ws://";
  const auto colon = address.rfind(':');
  if (address.rfind(scheme, 0) != 0 || colon < scheme.size() || colon + 1 >= address.size())
    throw DeviceError("inverse3: expected an address as ws://HOST:PORT, found '" + address + "'");
  host_ = address.substr(scheme.size(), colon - scheme.size());
  port_ = address.substr(colon + 1);
}

Inverse3::~Inverse3() { close(); }

DeviceProperties Inverse3::open() {
  try {
    link_ = std::make_unique<Link>(host_, port_);
  } catch (const std::exception& error) {
    throw DeviceError("inverse3: the service at ws://" + host_ + ":" + port_ + ": " + error.what());
  }
  if (!link_->wait_for_device()) {
    link_.reset();
    throw DeviceError("inverse3: the service at ws://" + host_ + ":" + port_ + " tells of no Inverse3");
  }
  return properties_of(rate_);
}

Device::Reading Inverse3::read() { return link_->reading(); }

void Inverse3::write(const Wrench& wrench) { link_->set_force(wrench.force); }

void Inverse3::close() { link_.reset(); }

}  // namespace acus::haptics
