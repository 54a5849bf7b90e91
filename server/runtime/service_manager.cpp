// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/runtime/service_manager.h"

#include <spdlog/spdlog.h>
#include <sys/time.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <optional>

namespace acus {
namespace {

using std::chrono::microseconds;

constexpr microseconds kReportPeriod = std::chrono::seconds(1);  // between two looks at what is new
constexpr int kSignsPerWatchdog = 4;                       // signs of life in the time that the manager waits for one
constexpr std::size_t kMaxStatus = 300;                    // bytes; the manager reads 4096 of a datagram
constexpr timeval kSendPatience{1, 0};  // s, for a manager that reads nothing, where this server waits for it

std::optional<std::uint64_t> number_in(const char* name) {
  const char* text = std::getenv(name);
  if (!text) return std::nullopt;
  std::uint64_t value = 0;
  const char* end = text + std::strlen(text);
  const auto [rest, error] = std::from_chars(text, end, value);
  if (error == std::errc() && rest == end) return value;
  spdlog::warn("${} is '{}', which is no number, and is ignored", name, text);
  return std::nullopt;
}

// The status may hold the name of a scene that a client sent: it must not begin lines of its own, which would speak for
// this server.
std::string in_one_line(std::string_view text) {
  std::size_t size = std::min(text.size(), kMaxStatus);
  while (size < text.size() && size > 0 && (text[size] & 0xC0) == 0x80) --size;  // not in the middle of a character
  std::string line(text.substr(0, size));
  std::replace_if(
      line.begin(), line.end(), [](unsigned char c) { return c < 0x20 || c == 0x7F; }, ' ');
  return line;
}

}  // namespace

ServiceManager::Address ServiceManager::address_from_environment() {
  Address address;
  if (const char* socket = std::getenv("NOTIFY_SOCKET")) address.socket = socket;
  const auto meant = number_in("WATCHDOG_PID");
  if (meant && *meant != static_cast<std::uint64_t>(getpid())) return address;
  if (const auto watchdog = number_in("WATCHDOG_USEC")) address.watchdog = microseconds(*watchdog);
  return address;
}

ServiceManager::ServiceManager(const Address& address) : watchdog_(address.watchdog) {
  const std::string& name = address.socket;
  if (name.empty()) return;
  if ((name[0] != '/' && name[0] != '@') || name.size() >= sizeof address_.sun_path) {
    spdlog::warn("$NOTIFY_SOCKET is '{}', which is neither a path nor an abstract name: nobody is told how it goes",
                 name);
    return;
  }
  address_.sun_family = AF_UNIX;
  std::memcpy(address_.sun_path, name.data(), name.size());
  if (name[0] == '@') address_.sun_path[0] = '\0';
  address_size_ = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + name.size());
  file_ = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (file_ < 0) spdlog::warn("cannot tell the service manager anything: {}", std::strerror(errno));
  setsockopt(file_, SOL_SOCKET, SO_SNDTIMEO, &kSendPatience, sizeof kSendPatience);
}

ServiceManager::~ServiceManager() {
  if (file_ >= 0) close(file_);
}

bool ServiceManager::send(const std::string& lines, int flags) const {
  const auto* address = reinterpret_cast<const sockaddr*>(&address_);
  return sendto(file_, lines.data(), lines.size(), flags | MSG_NOSIGNAL, address, address_size_) >= 0;
}

void ServiceManager::ready(std::string_view status) {
  if (file_ < 0) return;
  status_ = in_one_line(status);
  if (send("READY=1\nSTATUS=" + status_, 0)) return;
  spdlog::warn("cannot tell the service manager that the server is ready: {}", std::strerror(errno));
}

std::chrono::milliseconds ServiceManager::period() const {
  const bool watched = watchdog_ > microseconds(0);
  const microseconds longest = kReportPeriod;
  return std::chrono::ceil<std::chrono::milliseconds>(watched ? std::min(longest, watchdog_ / kSignsPerWatchdog)
                                                              : longest);
}

void ServiceManager::keep_informed(Clock::time_point now, std::uint64_t turns, std::string_view status) {
  const bool watched = watchdog_ > microseconds(0);
  due_ = now + period();
  const std::string line = in_one_line(status);
  std::string lines;
  if (watched && turns != turns_) lines += "WATCHDOG=1\n";
  if (line != status_) lines += "STATUS=" + line + "\n";
  if (lines.empty() || !send(lines, MSG_DONTWAIT)) return;
  turns_ = turns;
  status_ = line;
}

void ServiceManager::stopping() {
  if (file_ >= 0) send("STOPPING=1\nSTATUS=ending", 0);
}

}  // namespace acus
