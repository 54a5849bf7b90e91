// SPDX-License-Identifier: GPL-3.0-or-later
// SIGINT, SIGTERM and SIGHUP as a file descriptor, so that the socket thread can wait for them beside its sockets, and
// no call of ours is ever interrupted by them. Create one, before any thread is started: threads inherit what it sets
// up. Once it is gone the process is ending, and further signals are ignored. A SIGHUP that was ignored, as under
// nohup, stays so.
#pragma once

#include <functional>
#include <thread>

#include "server/runtime/wakeup.h"

namespace acus {

class Termination {
 public:
  Termination();  // throws std::system_error
  ~Termination();
  Termination(const Termination&) = delete;
  Termination& operator=(const Termination&) = delete;

  // Readable once a signal has come.
  int file() const { return either_; }
  // Whether one has come.
  bool asked() const;

 private:
  int blocked_ = -1;  // signals that all threads block: ours do
  int handled_ = -1;  // signals that a thread took: libraries start some before main() that block none
  int either_ = -1;   // polls both
};

// Calls `end` on a thread of its own if a signal has come while it lives: during work that cannot be interrupted, such
// as the factorisation of a large scene.
class SignalWatch {
 public:
  SignalWatch(const Termination& termination, std::function<void()> end);
  ~SignalWatch();
  SignalWatch(const SignalWatch&) = delete;
  SignalWatch& operator=(const SignalWatch&) = delete;

 private:
  Wakeup over_;
  std::thread watcher_;
};

}  // namespace acus
