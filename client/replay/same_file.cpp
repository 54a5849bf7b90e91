// SPDX-License-Identifier: MIT
#include "client/replay/same_file.h"

#include <filesystem>
#include <system_error>

namespace acus::client {

namespace {

// Where writing to the path ends up: links are followed, also one to a file that is not there yet.
std::filesystem::path destination(std::filesystem::path path) {
  constexpr int kMaxLinks = 40;  // as many as the kernel follows
  std::error_code error;
  for (int i = 0; i < kMaxLinks && std::filesystem::is_symlink(path, error); ++i) {
    path = path.parent_path() / std::filesystem::read_symlink(path, error);
  }
  path = std::filesystem::absolute(path);
  const auto canonical = std::filesystem::weakly_canonical(path, error);
  return error ? path.lexically_normal() : canonical;
}

}  // namespace

bool same_file(const std::string& a, const std::string& b) {
  std::error_code error;
  return destination(a) == destination(b) || std::filesystem::equivalent(a, b, error);
}

}  // namespace acus::client
