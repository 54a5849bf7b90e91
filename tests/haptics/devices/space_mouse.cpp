// SPDX-License-Identifier: GPL-3.0-or-later
// The SpaceMouse, on a stand-in for spacenavd that speaks its first protocol: events of eight integers.
#include "client/haptics/devices/space_mouse.h"

#include <doctest/doctest.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <string>
#include <thread>

#include "tests/support/temporary_folder.h"

using namespace acus::haptics;

namespace {

class Daemon {
 public:
  Daemon() {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strncpy(address.sun_path, path().c_str(), sizeof address.sun_path - 1);
    REQUIRE(bind(listening_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0);
    REQUIRE(listen(listening_, 1) == 0);
    setenv("SPNAV_SOCKET", path().c_str(), 1);
  }
  ~Daemon() {
    close(client_);
    close(listening_);
    unsetenv("SPNAV_SOCKET");
  }

  void accept_client() {
    pollfd waiting{listening_, POLLIN, 0};
    REQUIRE(poll(&waiting, 1, 60'000) == 1);
    client_ = accept(listening_, nullptr, nullptr);
  }
  void send(const std::array<std::int32_t, 8>& event) const {
    REQUIRE(write(client_, event.data(), sizeof event) == static_cast<ssize_t>(sizeof event));
  }

 private:
  std::string path() const { return folder_ / "spnav.sock"; }

  acus::TemporaryFolder folder_;
  int listening_ = socket(AF_UNIX, SOCK_STREAM, 0);
  int client_ = -1;
};

}  // namespace

TEST_CASE("a SpaceMouse that is pushed away from the hand pushes the needle in, any button is the clutch" *
          doctest::test_suite("gate")) {
  Daemon daemon;
  double now = 0;
  SpaceMouse mouse(250, [&] { return now; });
  mouse.open();
  daemon.accept_client();
  mouse.read();
  daemon.send({0, 0, 0, 350, 0, 0, 0, 16});  // motion: x, y, z, turns, period
  daemon.send({1, 3, 0, 0, 0, 0, 0, 0});     // button 3 goes down
  Device::Reading reading;
  for (int i = 0; i < 10000 && !reading.clutch; ++i) {
    reading = mouse.read();
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  CHECK(reading.clutch);
  const double before = reading.pose.position[0];
  for (int i = 0; i < 50; ++i) {
    now += 0.01;
    reading = mouse.read();
  }
  CHECK(std::abs(reading.pose.position[0] - before) == doctest::Approx(0.5 * 0.03).epsilon(0.02));
  CHECK(std::abs(reading.pose.position[1]) < 1e-12);
  mouse.close();
}

TEST_CASE("without spacenavd a SpaceMouse is an error" * doctest::test_suite("gate")) {
  setenv("SPNAV_SOCKET", "/nowhere/spnav.sock", 1);
  SpaceMouse mouse(250, [] { return 0.0; });
  CHECK_THROWS_AS(mouse.open(), DeviceError);
  unsetenv("SPNAV_SOCKET");
}
