// SPDX-License-Identifier: MIT
// A file that a run is written into, with errors that name it. It replaces nothing but a file of its own kind, and that
// one is kept until there is something to write: a run that is refused costs nothing.
#pragma once

#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <utility>

#include "protocol/own_file.h"

namespace acus::client {

// The file system refused; what() names the file.
struct LogError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

class LogFile {
 public:
  // Whose own files begin with the header.
  LogFile(std::string path, std::string header) : LogFile(std::move(path), protocol::beginning_with(header), header) {}
  // Throws LogError if the file cannot be written, or holds something else. `header` comes before everything else.
  LogFile(std::string path, const protocol::IsOwn& is_own, std::string header = {})
      : path_(std::move(path)), header_(std::move(header)) {
    if (protocol::holds_another_file(path_, is_own)) throw LogError(path_ + protocol::kAnotherFile);
    std::error_code ignored;
    made_here_ = !std::filesystem::exists(std::filesystem::symlink_status(path_, ignored));
    open(std::ios::app);
    file_.close();
  }
  ~LogFile() {
    std::error_code ignored;
    if (made_here_ && !begun_) std::filesystem::remove(path_, ignored);
  }
  LogFile(const LogFile&) = delete;
  LogFile& operator=(const LogFile&) = delete;

  const std::string& path() const { return path_; }
  bool begun() const { return begun_; }

  // To write to. The first call empties the file. Throws LogError if that cannot be done.
  std::ofstream& out() {
    if (begun_) return file_;
    open(std::ios::trunc);
    begun_ = true;
    file_ << header_;
    return file_;
  }

  // Everything is on its way to the disk after this. Throws LogError if anything could not be written.
  void close() {
    if (!begun_) return;
    file_.close();
    if (!file_) throw LogError(path_ + ": writing failed; is the disk full?");
  }

 private:
  void open(std::ios::openmode how) {
    file_.open(path_, std::ios::out | std::ios::binary | how);
    if (!file_) throw LogError(path_ + ": cannot be written; does its folder exist?");
  }

  std::string path_, header_;
  std::ofstream file_;
  bool made_here_ = false;
  bool begun_ = false;
};

}  // namespace acus::client
