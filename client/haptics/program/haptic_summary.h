// SPDX-License-Identifier: MIT
// What a session was like, for people and for programs.
#pragma once

#include <string>

#include "client/haptics/program/session.h"

namespace acus::haptics {

// A few lines.
std::string readable(const SessionResults& results, const std::string& device);
// JSON; units stand in the names.
std::string as_json(const SessionResults& results, const std::string& device);

}  // namespace acus::haptics
