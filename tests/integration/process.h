// SPDX-License-Identifier: GPL-3.0-or-later
// A child process that does not outlive its owner.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <optional>
#include <string>
#include <vector>

namespace acus::testing {

class Process {
 public:
  // Starts the program argv[0]; throws std::system_error if it cannot be started. What it prints goes to the file
  // `output`, if one is given.
  explicit Process(const std::vector<std::string>& argv, std::optional<int> output = {});

  // Kills it if it still runs.
  ~Process();
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  pid_t id() const { return id_; }
  void send_signal(int signal);

  // Its exit status, or minus the signal that ended it; nothing if it still runs after the timeout.
  std::optional<int> wait(std::chrono::milliseconds timeout);

 private:
  pid_t id_ = 0;
  std::optional<int> status_;
};

}  // namespace acus::testing
