// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/runtime/termination.h"

#include <poll.h>
#include <pthread.h>
#include <signal.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <system_error>
#include <utility>

namespace acus {
namespace {

volatile sig_atomic_t handled_file = -1;  // what the handler writes to

void note_signal(int) {
  const int saved_error = errno;
  const std::uint64_t one = 1;
  [[maybe_unused]] const auto written = write(handled_file, &one, sizeof one);
  errno = saved_error;
}

int checked(int result) {
  if (result < 0) throw std::system_error(errno, std::generic_category(), "cannot watch for signals");
  return result;
}

bool is_ignored(int signal) {
  struct sigaction action {};
  return sigaction(signal, nullptr, &action) == 0 && action.sa_handler == SIG_IGN;
}

void add(int epoll_file, int file) {
  epoll_event event{};
  event.events = EPOLLIN;
  checked(epoll_ctl(epoll_file, EPOLL_CTL_ADD, file, &event));
}

}  // namespace

Termination::Termination() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  const bool hangup = !is_ignored(SIGHUP);
  if (hangup) sigaddset(&signals, SIGHUP);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  blocked_ = checked(signalfd(-1, &signals, SFD_CLOEXEC | SFD_NONBLOCK));
  handled_ = checked(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK));
  either_ = checked(epoll_create1(EPOLL_CLOEXEC));
  add(either_, blocked_);
  add(either_, handled_);

  handled_file = handled_;
  struct sigaction action {};
  action.sa_handler = note_signal;
  action.sa_flags = SA_RESTART;
  checked(sigaction(SIGINT, &action, nullptr));
  checked(sigaction(SIGTERM, &action, nullptr));
  if (hangup) checked(sigaction(SIGHUP, &action, nullptr));
}

bool Termination::asked() const {
  pollfd item{either_, POLLIN, 0};
  return poll(&item, 1, 0) == 1;
}

// The signal may still be on its way to a library's thread, where the default would end the process with it.
Termination::~Termination() {
  signal(SIGINT, SIG_IGN);
  signal(SIGTERM, SIG_IGN);
  signal(SIGHUP, SIG_IGN);
  for (int file : {either_, handled_, blocked_}) close(file);
}

SignalWatch::SignalWatch(const Termination& termination, std::function<void()> end)
    : watcher_([this, &termination, end = std::move(end)] {
        pollfd items[] = {{termination.file(), POLLIN, 0}, {over_.file(), POLLIN, 0}};
        while (poll(items, 2, -1) < 0 && errno == EINTR) continue;
        if (items[0].revents != 0) end();
      }) {}

SignalWatch::~SignalWatch() {
  over_.signal();
  watcher_.join();
}

}  // namespace acus
