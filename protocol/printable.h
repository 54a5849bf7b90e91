// SPDX-License-Identifier: MIT
// Text of others, as names of scenes, for a person's terminal: control characters are shown, none is sent.
#pragma once

#include <cstdio>
#include <string>
#include <string_view>

namespace acus::protocol {

enum class Newlines { shown, kept };

// "\n" and "\x1b" for such bytes, also for the control characters above 0x7f, which UTF-8 writes as 0xc2 and another
// byte.
inline std::string printable(std::string_view text, Newlines newlines = Newlines::shown) {
  std::string shown;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto byte = static_cast<unsigned char>(text[i]);
    const bool high = byte == 0xc2 && i + 1 < text.size() && static_cast<unsigned char>(text[i + 1]) < 0xa0;
    if (byte == '\n') {
      shown += newlines == Newlines::kept ? "\n" : "\\n";
    } else if (byte < 0x20 || byte == 0x7f || high) {
      char code[8];
      std::snprintf(code, sizeof code, "\\x%02x", high ? static_cast<unsigned char>(text[++i]) : byte);
      shown += code;
    } else {
      shown += text[i];
    }
  }
  return shown;
}

}  // namespace acus::protocol
