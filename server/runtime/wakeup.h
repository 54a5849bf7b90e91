// SPDX-License-Identifier: GPL-3.0-or-later
// Wakes another thread that waits in poll(). Signals add up to one; signalling never blocks.
#pragma once

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <system_error>

namespace acus {

class Wakeup {
 public:
  Wakeup() : file_(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {
    if (file_ < 0) throw std::system_error(errno, std::generic_category(), "cannot create an eventfd");
  }
  ~Wakeup() { close(file_); }
  Wakeup(const Wakeup&) = delete;
  Wakeup& operator=(const Wakeup&) = delete;

  int file() const { return file_; }

  void signal() {
    const std::uint64_t one = 1;
    [[maybe_unused]] const auto written = write(file_, &one, sizeof one);  // fails only if a signal waits already
  }

  // Forgets the signals so far. To be called before looking for the work they announced.
  void clear() {
    std::uint64_t count = 0;
    [[maybe_unused]] const auto got = read(file_, &count, sizeof count);  // fails only if there was no signal
  }

  // Waits for a signal, at most this long, and clears it.
  void wait(int timeout_ms) {
    pollfd item{file_, POLLIN, 0};
    poll(&item, 1, timeout_ms);
    clear();
  }

 private:
  int file_;
};

}  // namespace acus
