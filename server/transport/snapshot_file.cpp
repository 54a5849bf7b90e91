// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/transport/snapshot_file.h"

#include <fcntl.h>
#include <spdlog/spdlog.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <span>
#include <stdexcept>
#include <system_error>
#include <thread>

#include "protocol/own_file.h"
#include "server/engine/state/bytes/snapshot.h"
#include "server/runtime/is_ready.h"

namespace acus {

namespace {

constexpr mode_t kMode = 0644;
constexpr std::chrono::seconds kPatience{1}, kSlow{10};

[[noreturn]] void fail() { throw std::system_error(errno, std::generic_category()); }

class File {
 public:
  // Without waiting, where it is a pipe.
  explicit File(const std::string& path)
      : file_(open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK, kMode)) {
    if (file_ < 0) fail();
    struct stat status {};
    if (fstat(file_, &status) == 0 && S_ISREG(status.st_mode)) return;
    close(file_);
    throw std::runtime_error(path + " is no file; remove it");
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

std::string fresh_of(const std::string& path) { return path + ".new"; }

void replace(const std::string& path, std::span<const std::byte> bytes) {
  if (const std::string problem = SnapshotFile::problem_with(path); !problem.empty()) throw std::runtime_error(problem);
  const std::string fresh = fresh_of(path);
  File(fresh).write(bytes);
  if (std::rename(fresh.c_str(), path.c_str()) != 0) fail();
}

}  // namespace

SnapshotFile::SnapshotFile(std::string path) : path_(std::move(path)) {
  if (!path_.empty()) lock_ = std::make_shared<const FileLock>(path_);
}

SnapshotFile::~SnapshotFile() {
  if (writing_.valid() && writing_.wait_for(kPatience) != std::future_status::ready)
    spdlog::error("--snapshot {}: the newest is not on the disk, which does not answer", path_);
}

std::string SnapshotFile::problem_with(const std::string& path) {
  for (const std::string& file : {path, fresh_of(path)}) {
    std::error_code error;
    const auto there = std::filesystem::status(file, error);
    const bool lost =
        protocol::holds_another_file(file, begins_as_snapshot) || (exists(there) && !is_regular_file(there));
    if (lost) return file + protocol::kAnotherFile;
  }
  return "";
}

bool SnapshotFile::ready() const { return !path_.empty() && (!writing_.valid() || is_ready(writing_)); }

void SnapshotFile::write(std::uint64_t fingerprint, std::unique_ptr<State> state) {
  std::packaged_task<void()> work(
      [path = path_, lock = lock_, fingerprint, state = std::shared_ptr<State>(std::move(state))] {
        try {
          replace(path, make_snapshot(fingerprint, *state));
        } catch (const std::exception& error) {
          spdlog::error("--snapshot {}: {}", path, error.what());
        }
      });
  writing_ = work.get_future();
  begun_ = Clock::now();
  told_ = false;
  try {
    std::thread(std::move(work)).detach();
  } catch (const std::system_error& error) {
    writing_ = {};
    spdlog::error("--snapshot {}: no thread to write it: {}", path_, error.what());
  }
}

void SnapshotFile::tell_if_slow(Clock::time_point now) {
  if (told_ || !writing() || now - begun_ < kSlow) return;
  told_ = true;
  spdlog::error("--snapshot {}: it has been written for {} s, and no other can be meanwhile; is the disk there?", path_,
                std::chrono::duration_cast<std::chrono::seconds>(now - begun_).count());
}

}  // namespace acus
