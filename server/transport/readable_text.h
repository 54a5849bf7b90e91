// SPDX-License-Identifier: GPL-3.0-or-later
// What a client sent, as it may be told back: the contract has UTF-8 only, and nobody reads a megabyte.
#pragma once

#include <string>
#include <string_view>

namespace acus {

// Bytes that are no UTF-8 become U+FFFD. What is longer than `most` bytes is cut and ends with "...".
std::string readable(std::string_view text, std::size_t most);

}  // namespace acus
