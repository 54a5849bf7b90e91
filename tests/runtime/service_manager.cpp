// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/runtime/service_manager.h"

#include <doctest/doctest.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <cstring>

#include "tests/support/temporary_folder.h"

namespace acus {
namespace {

using std::chrono::microseconds;
using std::chrono::seconds;

// The manager's end: a datagram socket of this name.
class Inbox {
 public:
  explicit Inbox(const std::string& name) : file_(socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::memcpy(address.sun_path, name.data(), name.size());
    if (name[0] == '@') address.sun_path[0] = '\0';
    const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + name.size());
    REQUIRE(bind(file_, reinterpret_cast<const sockaddr*>(&address), size) == 0);
  }
  ~Inbox() { close(file_); }
  Inbox(const Inbox&) = delete;
  Inbox& operator=(const Inbox&) = delete;

  // The next datagram, or nothing.
  std::string next() const {
    std::array<char, 8192> bytes{};
    const ssize_t size = recv(file_, bytes.data(), bytes.size(), MSG_DONTWAIT);
    return size < 0 ? std::string() : std::string(bytes.data(), static_cast<std::size_t>(size));
  }

 private:
  int file_;
};

struct Managed {
  TemporaryFolder folder;
  Inbox inbox{folder / "notify"};
  ServiceManager manager{{folder / "notify", seconds(2)}};
  ServiceManager::Clock::time_point now;
};

void set(const char* name, const std::string& value) { setenv(name, value.c_str(), 1); }

}  // namespace

TEST_CASE_FIXTURE(Managed, "a simulation thread that stands still sends no signs of life") {
  manager.ready("scene");
  CHECK(inbox.next() == "READY=1\nSTATUS=scene");
  manager.keep_informed(now, 7, "scene");
  CHECK(inbox.next() == "WATCHDOG=1\n");
  manager.keep_informed(now, 7, "scene");
  CHECK(inbox.next().empty());
  manager.keep_informed(now, 8, "scene");
  CHECK(inbox.next() == "WATCHDOG=1\n");
  manager.stopping();
  CHECK(inbox.next() == "STOPPING=1\nSTATUS=ending");
}

TEST_CASE_FIXTURE(Managed, "signs of life are due four times in the time that the manager waits") {
  manager.keep_informed(now, 1, "scene");
  CHECK_FALSE(manager.due(now + microseconds(499'999)));
  CHECK(manager.due(now + microseconds(500'000)));
}

TEST_CASE_FIXTURE(Managed, "a status is told when it changes, whether the simulation thread hangs or not") {
  manager.ready("one");
  manager.keep_informed(now, 1, "one");
  inbox.next(), inbox.next();
  manager.keep_informed(now, 1, "two");
  CHECK(inbox.next() == "STATUS=two\n");
}

TEST_CASE_FIXTURE(Managed, "the name of a scene cannot speak for the server") {
  manager.ready("a\nMAINPID=1\r\x01z");
  CHECK(inbox.next() == "READY=1\nSTATUS=a MAINPID=1  z");
}

TEST_CASE_FIXTURE(Managed, "a long status is cut before a character, and the sign of life stays readable") {
  manager.keep_informed(now, 1, std::string(299, 'a') + "é" + std::string(5000, 'b'));
  CHECK(inbox.next() == "WATCHDOG=1\nSTATUS=" + std::string(299, 'a') + "\n");
}

TEST_CASE("what a manager had no room for is sent later" * doctest::test_suite("gate")) {
  TemporaryFolder folder;
  const Inbox inbox(folder / "notify");
  ServiceManager manager({folder / "notify", seconds(2)});
  constexpr std::uint64_t kMany = 10'000;  // more than any socket keeps
  for (std::uint64_t turn = 0; turn < kMany; ++turn) manager.keep_informed({}, turn, std::to_string(turn));
  while (!inbox.next().empty()) {
  }
  manager.keep_informed({}, kMany - 1, std::to_string(kMany - 1));
  CHECK(inbox.next() == "WATCHDOG=1\nSTATUS=9999\n");
}

TEST_CASE("an abstract name, and no watchdog" * doctest::test_suite("gate")) {
  const std::string name = "@acus-test-" + std::to_string(getpid());
  const Inbox inbox(name);
  ServiceManager manager({name, {}});
  manager.keep_informed({}, 1, "scene");
  CHECK(inbox.next() == "STATUS=scene\n");
}

TEST_CASE("a manager that is gone, an address that is none, and no manager at all disturb nobody" *
          doctest::test_suite("gate")) {
  const std::string too_long = "/" + std::string(200, 'x');
  for (const std::string& name : {std::string("/nonexistent/notify"), std::string("vsock:2:1"), too_long, std::string()}) {
    ServiceManager manager({name, seconds(1)});
    manager.ready("scene");
    manager.keep_informed({}, 1, "scene");
    manager.stopping();
  }
  CHECK_FALSE(ServiceManager({"", seconds(1)}).due(ServiceManager::Clock::time_point::max()));
}

TEST_CASE("the environment names the socket, and the time if this process is meant" * doctest::test_suite("gate")) {
  set("NOTIFY_SOCKET", "/run/notify");
  set("WATCHDOG_USEC", "3000000");
  unsetenv("WATCHDOG_PID");
  CHECK(ServiceManager::address_from_environment().socket == "/run/notify");
  CHECK(ServiceManager::address_from_environment().watchdog == seconds(3));
  set("WATCHDOG_PID", std::to_string(getpid()));
  CHECK(ServiceManager::address_from_environment().watchdog == seconds(3));
  set("WATCHDOG_PID", "1");
  CHECK(ServiceManager::address_from_environment().watchdog == seconds(0));
  unsetenv("WATCHDOG_PID");
  set("WATCHDOG_USEC", "soon");
  CHECK(ServiceManager::address_from_environment().watchdog == seconds(0));
  unsetenv("WATCHDOG_USEC");
  unsetenv("NOTIFY_SOCKET");
  CHECK(ServiceManager::address_from_environment().socket.empty());
}

}  // namespace acus
