// SPDX-License-Identifier: GPL-3.0-or-later
// Tells the service manager that started this server (systemd) how it is, in the protocol of sd_notify(3): datagrams of
// lines NAME=VALUE to the socket that $NOTIFY_SOCKET names. Nothing happens in a server that no service manager started.
//
// libsystemd would send the same datagrams, and bring libgcrypt and three compression libraries into a process that
// locks its memory. The protocol is documented and stable, and its manual advises programs that want nothing else of
// libsystemd to send the datagrams by themselves.
#pragma once

#include <sys/socket.h>
#include <sys/un.h>

#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>

namespace acus {

class ServiceManager {
 public:
  using Clock = std::chrono::steady_clock;

  struct Address {
    std::string socket;                     // a path, or @ and an abstract name; empty: nobody is to be told
    std::chrono::microseconds watchdog{0};  // it ends a server that shows no sign of life for so long; 0: it waits
  };
  // As $NOTIFY_SOCKET, $WATCHDOG_USEC and $WATCHDOG_PID say.
  static Address address_from_environment();

  explicit ServiceManager(const Address& address);
  ~ServiceManager();
  ServiceManager(const ServiceManager&) = delete;
  ServiceManager& operator=(const ServiceManager&) = delete;

  // Clients can connect from now on. `status` is a line for people.
  void ready(std::string_view status);

  // From one call of keep_informed() to the next.
  std::chrono::milliseconds period() const;
  // Whether it is time to call keep_informed() again, which costs a system call.
  bool due(Clock::time_point now) const { return file_ >= 0 && now >= due_; }
  // Sends a changed status, and a sign of life if `turns`, which the simulation thread counts up, has changed since the
  // last one. Waits for nobody: what cannot be sent is sent at the next call.
  void keep_informed(Clock::time_point now, std::uint64_t turns, std::string_view status);

  // The server is about to end.
  void stopping();

 private:
  bool send(const std::string& lines, int flags) const;

  int file_ = -1;
  sockaddr_un address_{};
  socklen_t address_size_ = 0;
  std::chrono::microseconds watchdog_;
  Clock::time_point due_;
  std::uint64_t turns_ = ~std::uint64_t{0};
  std::string status_;
};

}  // namespace acus
