// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/transport/connection_guard.h"

#include <linux/tcp.h>
#include <netinet/in.h>
#include <spdlog/spdlog.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <system_error>
#include <utility>

namespace acus {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kLookPeriod{50};
constexpr auto kToFree = kLookPeriod;             // for ZeroMQ to free what it has of a connection that was cut
constexpr std::int64_t kMaxGrowth = 640 << 20;    // bytes of the process; 16 messages of the largest size fit
constexpr std::int64_t kQuiet = kMaxGrowth / 32;  // bytes that wait; each takes less than 32 in memory
constexpr std::int64_t kMaxUnreadNotices = 1 << 20;  // bytes of a subscriber, beyond the allowance
constexpr std::int64_t kMaxOfStranger = 1 << 20;     // bytes of a connection whose first message has not come
constexpr std::size_t kStrangersShare = 2;           // one of so many connections may be a stranger's
constexpr double kHeartbeats = 64;                // bytes/s, not counted
constexpr double kTopics = 1024;                  // bytes/s of a subscriber, likewise: topics that come and go
constexpr std::int64_t kFraming = 64;             // bytes of a frame beside what is in it, at most; with keys about 40
constexpr std::size_t kSpareFiles = 8;            // for recordings, snapshots, scenes and the reader of their meshes,
constexpr std::size_t kSpareShare = 8;  // and one in so many for connections that come faster than they are ended
constexpr double kCutLinesPerSecond = 1;

std::int64_t bytes_received(int connection) {
  tcp_info info{};
  socklen_t size = sizeof info;
  if (getsockopt(connection, IPPROTO_TCP, TCP_INFO, &info, &size) != 0) return 0;  // not TCP, or ended meanwhile
  return static_cast<std::int64_t>(info.tcpi_bytes_received);
}

// 0 if the system does not tell.
std::int64_t resident_bytes() {
  std::int64_t pages = 0, resident = 0;
  std::ifstream("/proc/self/statm") >> pages >> resident;
  return resident * sysconf(_SC_PAGESIZE);
}

std::size_t most_connections() {
  rlimit files{};
  getrlimit(RLIMIT_NOFILE, &files);
  std::error_code unknown;
  const auto own = std::distance(std::filesystem::directory_iterator("/proc/self/fd", unknown), {});
  const std::size_t taken = static_cast<std::size_t>(own) + kSpareFiles + files.rlim_cur / kSpareShare;
  return files.rlim_cur > taken ? files.rlim_cur - taken : 1;
}

}  // namespace

ConnectionGuard::ConnectionGuard(zmq::context_t& context, zmq::socket_t& states, bool keys)
    : most_(most_connections()),
      keys_(keys),
      subscribers_(context, states, "states"),
      resident_(resident_bytes()),
      last_look_(Clock::now()),
      last_cut_(last_look_ - kToFree),
      log_limit_(kCutLinesPerSecond),
      thread_([this](const std::stop_token& stop) { run(stop); }) {}

ConnectionGuard::~ConnectionGuard() = default;

void ConnectionGuard::note(const ConnectionChange& change, bool subscribes) {
  Key key{change.connection, subscribes};
  const char* why = nullptr;
  {
    const std::lock_guard lock(mutex_);
    forget(key);
    if (!change.begun) return;
    Account& account = accounts_[key] = {};
    if (keys_ && !subscribes) {
      account.stranger = ++last_stranger_;
      strangers_[account.stranger] = key;
    }
    if (accounts_.size() > most_) why = "there are as many as the limit of open files allows";
    if (strangers_.size() > std::max<std::size_t>(1, most_ / kStrangersShare)) {
      key = strangers_.begin()->second;
      why = "it has said nothing for longer than others, which are many";
    }
  }
  if (why != nullptr) cut(key, why);
}

void ConnectionGuard::forget(const Key& key) {
  const auto account = accounts_.find(key);
  if (account == accounts_.end()) return;
  strangers_.erase(account->second.stranger);
  accounts_.erase(account);
}

void ConnectionGuard::took(const Arrived& message) {
  const std::lock_guard lock(mutex_);
  const auto account = accounts_.find({message.sender.connection, false});
  if (account == accounts_.end()) return;
  account->second.read += message.size + kFraming * message.frames;
  strangers_.erase(account->second.stranger);
  account->second.stranger = 0;
}

void ConnectionGuard::run(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    try {
      wait_and_look();
    } catch (const std::exception& error) {  // as without memory
      spdlog::error("connections are not watched: {}", error.what());
      std::this_thread::sleep_for(kLookPeriod);
    }
  }
}

void ConnectionGuard::wait_and_look() {
  zmq::pollitem_t item{subscribers_.socket().handle(), 0, ZMQ_POLLIN, 0};
  zmq::poll(&item, 1, kLookPeriod);
  while (const auto change = subscribers_.next_change()) note(*change, true);
  const auto now = Clock::now();
  if (now - last_look_ < kLookPeriod) return;
  look(std::chrono::duration<double>(now - last_look_).count());
  last_look_ = now;
}

void ConnectionGuard::look(double seconds) {
  Accounts seen = begin_look();
  std::int64_t sum = 0, most = -1;
  Key longest;
  for (auto& [key, account] : seen) {
    const std::int64_t received = bytes_received(key.connection);
    const auto allowed = static_cast<std::int64_t>(std::ceil((key.subscribes ? kTopics : kHeartbeats) * seconds));
    account.settled = std::min(received, account.settled + account.read + allowed);
    const std::int64_t waiting = received - account.settled;
    if (key.subscribes) {
      if (waiting > kMaxUnreadNotices) cut(key, "it subscribes without end");
      continue;
    }
    if (account.stranger != 0 && waiting > kMaxOfStranger) cut_stranger(key);
    sum += waiting;
    if (waiting > most) most = waiting, longest = key;
  }
  settle(seen);
  if (Clock::now() - last_cut_ < kToFree) return;
  const std::int64_t resident = resident_bytes();
  if (resident == 0) return;
  if (sum < kQuiet) {
    if (!has_cut_) resident_ = resident;  // memory that is locked does not go back when it is freed
  } else if (resident > resident_ + kMaxGrowth) {
    cut(longest, "what it has sent waits in memory for the end of a message");
    last_cut_ = Clock::now();
    has_cut_ = true;
  }
}

// At the second look: at the first one, whole messages may wait for the thread that reads them.
void ConnectionGuard::cut_stranger(const Key& key) {
  {
    const std::lock_guard lock(mutex_);
    const auto account = accounts_.find(key);
    if (account == accounts_.end() || account->second.stranger == 0) return;
    if (!std::exchange(account->second.suspected, true)) return;
  }
  cut(key, "it has sent more than 1 MiB, and no message of it was read yet");
}

// A copy, so that nobody waits while the system is asked about each connection.
ConnectionGuard::Accounts ConnectionGuard::begin_look() {
  const std::lock_guard lock(mutex_);
  Accounts seen = accounts_;
  for (auto& [key, account] : accounts_) account.read = 0;
  return seen;
}

// A connection whose descriptor was used again meanwhile has received less, and is settled at the next look.
void ConnectionGuard::settle(const Accounts& seen) {
  const std::lock_guard lock(mutex_);
  for (auto& [key, account] : accounts_) {
    const auto known = seen.find(key);
    if (known != seen.end()) account.settled = known->second.settled;
  }
}

// ZeroMQ finds it ended, frees what waits of it, and tells so. A descriptor may have been closed and used again since:
// then another client has to connect anew, which ZeroMQ does by itself.
void ConnectionGuard::cut(const Key& key, const char* why) {
  bool told = false;
  {
    const std::lock_guard lock(mutex_);
    forget(key);
    told = log_limit_.allow("", RateLimiter::Clock::now());
  }
  const linger at_once{.l_onoff = 1, .l_linger = 0};  // the system forgets what it has of it, too
  setsockopt(key.connection, SOL_SOCKET, SO_LINGER, &at_once, sizeof at_once);
  ::shutdown(key.connection, SHUT_RDWR);
  if (told) spdlog::warn("a connection is ended: {}", why);
}

}  // namespace acus
