// SPDX-License-Identifier: MIT
// Numbers on standard input, one a line, as the share of a hand on a shared needle.
#pragma once

#include <poll.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <atomic>
#include <cstdio>
#include <string>
#include <string_view>
#include <thread>

namespace acus::haptics {

// Until it goes out of scope, or there is no more input.
class ShareInput {
 public:
  explicit ShareInput(std::atomic<double>& share) : share_(share), thread_([this] { listen(); }) {}
  ~ShareInput() {
    ends_ = true;
    thread_.join();
  }
  ShareInput(const ShareInput&) = delete;
  ShareInput& operator=(const ShareInput&) = delete;

 private:
  void listen() {
    std::string line;
    while (!ends_) {
      pollfd input{STDIN_FILENO, POLLIN, 0};
      if (poll(&input, 1, 100) <= 0) continue;
      char read_now[256];
      const ssize_t count = read(STDIN_FILENO, read_now, sizeof read_now);
      if (count <= 0) return;
      for (const char each : std::string_view(read_now, static_cast<std::size_t>(count))) {
        if (each != '\n') {
          line += each;
          continue;
        }
        take(line);
        line.clear();
      }
    }
  }
  void take(std::string& line) {
    double value = 0;
    if (CLI::detail::lexical_cast(line, value) && value >= 0 && value <= 1)
      share_ = value;
    else if (!line.empty())
      std::fprintf(stderr, "acus-haptic: share: expected a number from 0 to 1, found '%s'\n", line.c_str());
  }

  std::atomic<double>& share_;
  std::atomic<bool> ends_ = false;
  std::thread thread_;
};

}  // namespace acus::haptics
