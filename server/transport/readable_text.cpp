// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/transport/readable_text.h"

#include <nlohmann/json.hpp>

namespace acus {

std::string readable(std::string_view text, std::size_t most) {
  using nlohmann::json;
  const std::string whole = json(text.substr(0, most)).dump(-1, ' ', false, json::error_handler_t::replace);
  return json::parse(whole).get<std::string>() + (text.size() > most ? "..." : "");
}

}  // namespace acus
