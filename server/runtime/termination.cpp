// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/runtime/termination.h"

#include <poll.h>
#include <pthread.h>
#include <signal.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <array>
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

constexpr std::array kSignals{SIGINT, SIGTERM, SIGHUP};

// Of these, in a set. nohup has SIGHUP ignored.
sigset_t signals_to_take() {
  sigset_t signals;
  sigemptyset(&signals);
  for (const int number : kSignals) sigaddset(&signals, number);
  struct sigaction hangup {};
  if (sigaction(SIGHUP, nullptr, &hangup) == 0 && hangup.sa_handler == SIG_IGN) sigdelset(&signals, SIGHUP);
  return signals;
}

void add(int epoll_file, int file) {
  epoll_event event{};
  event.events = EPOLLIN;
  checked(epoll_ctl(epoll_file, EPOLL_CTL_ADD, file, &event));
}

}  // namespace

Termination::Termination() {
  const sigset_t signals = signals_to_take();
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
  for (const int number : kSignals)
    if (sigismember(&signals, number) == 1) checked(sigaction(number, &action, nullptr));
}

bool Termination::asked() const {
  pollfd item{either_, POLLIN, 0};
  return poll(&item, 1, 0) == 1;
}

// The signal may still be on its way to a library's thread, where the default would end the process with it.
Termination::~Termination() {
  for (const int number : kSignals) signal(number, SIG_IGN);
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
