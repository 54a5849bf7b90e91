// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/transport/file_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace acus {

namespace {

constexpr int kTries = 100;  // another process may remove the file between opening and locking

}  // namespace

FileLock::FileLock(const std::string& path) : path_(path + ".lock") {
  for (int i = 0; i < kTries; ++i) {
    file_ = open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK, 0644);
    if (file_ < 0) break;
    const bool locked = flock(file_, LOCK_EX | LOCK_NB) == 0;
    if (locked && is_in_place()) return;
    const int why = errno;
    close(file_);
    if (locked) continue;
    if (why == EWOULDBLOCK) throw NotLocked(path + ": another server writes to it; give each its own");
    errno = why;
    break;
  }
  throw NotLocked(path_ + ": the file cannot be locked: " + std::strerror(errno));
}

// Only what was made for the lock is removed, while it is held.
FileLock::~FileLock() {
  struct stat status {};
  if (fstat(file_, &status) == 0 && status.st_size == 0 && is_in_place()) unlink(path_.c_str());
  close(file_);
}

bool FileLock::is_in_place() const {
  struct stat opened {
  }, named{};
  return fstat(file_, &opened) == 0 && lstat(path_.c_str(), &named) == 0 && opened.st_dev == named.st_dev &&
         opened.st_ino == named.st_ino;
}

}  // namespace acus
