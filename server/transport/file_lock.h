// SPDX-License-Identifier: GPL-3.0-or-later
// A name of a file that one process at a time writes to. A file NAME.lock beside it stands for it, as what is written
// is put in place anew each time. The lock ends with the process, however that ends.
#pragma once

#include <stdexcept>
#include <string>

namespace acus {

// what() says of which name and why.
struct NotLocked : std::runtime_error {
  using std::runtime_error::runtime_error;
};

class FileLock {
 public:
  // Throws NotLocked where another process has it, or no file can be made.
  explicit FileLock(const std::string& path);
  ~FileLock();
  FileLock(const FileLock&) = delete;
  FileLock& operator=(const FileLock&) = delete;

 private:
  bool is_in_place() const;

  const std::string path_;  // of the file that stands for it
  int file_ = -1;
};

}  // namespace acus
