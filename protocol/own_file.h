// SPDX-License-Identifier: MIT
// Which files a program of Acus may replace: those that show by their first bytes to be its own.
#pragma once

#include <functional>
#include <string>
#include <string_view>

namespace acus::protocol {

// Whether a file that begins so was written by Acus. As many bytes are shown as kBeginning, or all.
using IsOwn = std::function<bool(std::string_view beginning)>;
inline constexpr std::size_t kBeginning = 4096;

// Of files that begin with this text.
IsOwn beginning_with(std::string text);

// Of JSON files, whose first field says who wrote them.
inline constexpr const char* kWrittenBy = "written_by";
inline constexpr const char* kWriter = "Acus";
IsOwn json_of_acus();

// Whether something would be lost if an own file stood here: an entry of this name that holds anything that is not its
// own, or cannot be read. Nothing is lost of pipes and devices, which keep nothing.
bool holds_another_file(const std::string& path, const IsOwn& is_own);

// What to do then; stands behind the name of the file.
inline constexpr const char* kAnotherFile =
    ": something else stands there, which would be lost; give another name, or remove it";

}  // namespace acus::protocol
