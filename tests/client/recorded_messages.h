// SPDX-License-Identifier: GPL-3.0-or-later
// The messages of a file that acus-replay --shapes wrote.
#pragma once

#include <msgpack.hpp>
#include <string>
#include <vector>

#include "tests/support/file_content.h"

namespace acus::test {

inline std::vector<std::string> read_messages(const std::string& path) {
  const std::string bytes = content_of(path);
  std::vector<std::string> messages;
  for (std::size_t begin = 0, end = 0; begin < bytes.size(); begin = end) {
    msgpack::unpack(bytes.data(), bytes.size(), end);
    messages.push_back(bytes.substr(begin, end - begin));
  }
  return messages;
}

}  // namespace acus::test
