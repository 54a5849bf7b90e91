// SPDX-License-Identifier: MIT
#include "protocol/own_file.h"

#include <filesystem>
#include <fstream>
#include <system_error>
#include <utility>

namespace acus::protocol {

IsOwn beginning_with(std::string text) {
  return [text = std::move(text)](std::string_view beginning) { return beginning.starts_with(text); };
}

IsOwn json_of_acus() { return beginning_with(std::string("{\n  \"") + kWrittenBy + "\": \"" + kWriter + '"'); }

bool holds_another_file(const std::string& path, const IsOwn& is_own) {
  std::error_code error;
  const std::filesystem::file_status there = std::filesystem::status(path, error);
  if (!exists(there)) return false;
  if (is_directory(there)) return true;
  if (!is_regular_file(there) || std::filesystem::file_size(path, error) == 0) return false;
  std::string beginning(kBeginning, '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(beginning.data(), static_cast<std::streamsize>(beginning.size()));
  beginning.resize(static_cast<std::size_t>(file.gcount()));
  return !is_own(beginning);
}

}  // namespace acus::protocol
