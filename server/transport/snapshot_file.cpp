// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/transport/snapshot_file.h"

#include <fcntl.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <span>
#include <system_error>

#include "server/engine/state/snapshot.h"

namespace acus {

namespace {

constexpr mode_t kMode = 0644;

[[noreturn]] void fail() { throw std::system_error(errno, std::generic_category()); }

class File {
 public:
  explicit File(const std::string& path)
      : file_(open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NOFOLLOW, kMode)) {
    if (file_ < 0) fail();
  }
  ~File() { close(file_); }
  File(const File&) = delete;
  File& operator=(const File&) = delete;

  void write(std::span<const std::byte> bytes) {
    while (!bytes.empty()) {
      const ssize_t written = ::write(file_, bytes.data(), bytes.size());
      if (written < 0 && errno != EINTR) fail();
      if (written > 0) bytes = bytes.subspan(static_cast<std::size_t>(written));
    }
    if (fsync(file_) != 0) fail();
  }

 private:
  int file_;
};

void replace(const std::string& path, std::span<const std::byte> bytes) {
  const std::string fresh = path + ".new";
  File(fresh).write(bytes);
  if (std::rename(fresh.c_str(), path.c_str()) != 0) fail();
}

}  // namespace

bool SnapshotFile::ready() const {
  return !path_.empty() &&
         (!writing_.valid() || writing_.wait_for(std::chrono::seconds(0)) == std::future_status::ready);
}

void SnapshotFile::write(std::uint64_t fingerprint, std::unique_ptr<State> state) {
  const auto work = [path = path_, fingerprint, state = std::shared_ptr<State>(std::move(state))] {
    try {
      replace(path, make_snapshot(fingerprint, *state));
    } catch (const std::exception& error) {
      spdlog::error("--snapshot {}: {}", path, error.what());
    }
  };
  try {
    writing_ = std::async(std::launch::async, work);
  } catch (const std::system_error&) {  // no thread to be had
    work();
  }
}

}  // namespace acus
