// SPDX-License-Identifier: MIT
// A file that a run is written into, with errors that name it.
#pragma once

#include <fstream>
#include <stdexcept>
#include <string>

namespace acus::client {

// The file system refused; what() names the file.
struct LogError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

inline std::ofstream create_log(const std::string& path) {
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  if (!file) throw LogError(path + ": cannot be written; does its folder exist?");
  return file;
}

// Everything is on its way to the disk after this.
inline void close_log(std::ofstream& file, const std::string& path) {
  file.close();
  if (!file) throw LogError(path + ": writing failed; is the disk full?");
}

}  // namespace acus::client
