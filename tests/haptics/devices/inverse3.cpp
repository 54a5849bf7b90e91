// SPDX-License-Identifier: GPL-3.0-or-later
// The Inverse3, on a stand-in for Haply's service that was made from its documentation.
#include "client/haptics/devices/inverse3.h"

#include <doctest/doctest.h>

#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>

using namespace acus::haptics;

namespace {

namespace beast = boost::beast;
using Tcp = boost::asio::ip::tcp;
using nlohmann::json;

// Serves one client on a port of its own: sends a state, waits for the force, moves the handle by a micrometre per
// newton.
class Service {
 public:
  explicit Service(std::string device = "049A") : device_(std::move(device)), thread_([this] { serve(); }) {}
  ~Service() {
    stop_ = true;
    thread_.join();
  }

  std::string address() const { return "ws://127.0.0.1:" + std::to_string(acceptor_.local_endpoint().port()); }
  double force() const { return force_; }
  int messages() const { return messages_; }
  bool ended() const { return ended_; }
  void say(const std::string& text) {
    const std::lock_guard lock(mutex_);
    say_ = text;
  }

 private:
  std::string state() {
    const std::lock_guard lock(mutex_);
    if (!say_.empty()) return say_;
    json devices = json::array();
    if (!device_.empty())
      devices.push_back({{"device_id", device_},
                         {"config", json::object()},
                         {"state",
                          {{"cursor_position", {{"x", 0.01}, {"y", -0.02}, {"z", 1e-6 * force_}}},
                           {"cursor_velocity", {{"x", 0}, {"y", 0}, {"z", 0}}}}}});
    return json{{"session_id", 7},
                {"inverse3", devices},
                {"wireless_verse_grip",
                 {{{"device_id", "61576"},
                   {"state",
                    {{"orientation", {{"x", 0}, {"y", 0}, {"z", 1}, {"w", 0}}},
                     {"buttons", {{"a", true}, {"b", false}, {"c", false}}}}}}}}}
        .dump();
  }

  void serve() {
    try {
      acceptor_.non_blocking(true);
      Tcp::socket socket(context_);
      for (beast::error_code trouble; !stop_;) {
        acceptor_.accept(socket, trouble);
        if (!trouble) break;
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      }
      if (stop_) return;
      socket.non_blocking(false);
      beast::websocket::stream<Tcp::socket> stream(std::move(socket));
      stream.accept();
      stream.text(true);
      while (!stop_) {
        stream.write(boost::asio::buffer(state()));
        beast::flat_buffer buffer;
        stream.read(buffer);
        const json command = json::parse(beast::buffers_to_string(buffer.data()));
        const json& device = command.at("inverse3").at(0);
        if (device.at("device_id") == device_)
          force_ = device.at("commands").at("set_cursor_force").at("values").at("z").get<double>();
        ++messages_;
      }
    } catch (const std::exception&) {
      // The client has gone.
    }
    ended_ = true;
  }

  boost::asio::io_context context_;
  Tcp::acceptor acceptor_{context_, {boost::asio::ip::make_address("127.0.0.1"), 0}};
  std::mutex mutex_;
  std::string device_, say_;
  std::atomic<double> force_ = 0;
  std::atomic<int> messages_ = 0;
  std::atomic<bool> stop_ = false, ended_ = false;
  std::thread thread_;
};

// Generous: for what happens at once on an idle machine.
template <class Condition>
bool soon(Condition condition) {
  for (int i = 0; i < 10000 && !condition(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  return condition();
}

}  // namespace

TEST_CASE("an Inverse3 tells where it is, and how its grip is held" * doctest::test_suite("gate")) {
  Service service;
  Inverse3 device(service.address(), 1000);
  const DeviceProperties properties = device.open();
  CHECK(properties.rate == 1000);
  CHECK(properties.rotation.largest_force == 0);
  const Device::Reading reading = device.read();
  CHECK(reading.pose.position[0] == doctest::Approx(0.01));
  CHECK(reading.pose.position[1] == doctest::Approx(-0.02));
  CHECK(reading.pose.orientation.z == doctest::Approx(1));
  CHECK(reading.clutch);
}

TEST_CASE("an Inverse3 gets its force with every message, and none once it is closed" * doctest::test_suite("gate")) {
  Service service;
  Inverse3 device(service.address(), 1000);
  device.open();
  device.write({{{0, 0, 2.5}}, {}});
  CHECK(soon([&] { return service.force() == 2.5; }));
  CHECK(soon([&] { return device.read().pose.position[2] == doctest::Approx(2.5e-6); }));
  device.close();
  CHECK(soon([&] { return service.force() == 0; }));
  device.close();
}

TEST_CASE("no service, a service without a device, an address of another form" * doctest::test_suite("gate")) {
  CHECK_THROWS_AS(Inverse3("http://localhost:10001", 1000), DeviceError);
  Inverse3 nobody("ws://127.0.0.1:9", 1000);
  CHECK_THROWS_AS(nobody.open(), DeviceError);
  Service empty("");
  Inverse3 device(empty.address(), 1000);
  CHECK_THROWS_AS(device.open(), DeviceError);
}

TEST_CASE("a service that sends something else is an error, and does no harm" * doctest::test_suite("gate")) {
  for (const char* nonsense : {"[1, 2]", "no JSON", R"({"inverse3": [{"device_id": 7, "state": 3}]})"}) {
    Service service;
    Inverse3 device(service.address(), 1000);
    device.open();
    device.write({{{0, 0, 2.5}}, {}});
    REQUIRE(soon([&] { return service.force() == 2.5; }));
    service.say(nonsense);
    CHECK(soon([&] {
      try {
        device.read();
        return false;
      } catch (const DeviceError&) {
        return true;
      }
    }));
    device.close();
    CHECK(soon([&] { return service.force() == 0; }));  // on its thread
  }
}

TEST_CASE("a service that answers byte by byte does not answer" * doctest::test_suite("gate")) {
  boost::asio::io_context context;
  Tcp::acceptor acceptor(context, {boost::asio::ip::make_address("127.0.0.1"), 0});
  std::atomic<bool> stop = false;
  std::thread dripping([&] {
    Tcp::socket socket(context);
    acceptor.accept(socket);
    beast::error_code trouble;
    for (const char letter : std::string("HTTP/1.1 101 Switching Protocols\r\nX-Wait: ") + std::string(1000, 'x')) {
      if (stop || trouble) return;
      socket.write_some(boost::asio::buffer(&letter, 1), trouble);
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
  });
  Inverse3 device("ws://127.0.0.1:" + std::to_string(acceptor.local_endpoint().port()), 1000);
  CHECK_THROWS_WITH_AS(device.open(), doctest::Contains("does not answer"), DeviceError);
  stop = true;
  dripping.join();
}
