// SPDX-License-Identifier: GPL-3.0-or-later
// What clients may ask for, and under which conditions: a row for each type of protocol::Command.
#pragma once

#include <array>
#include <string_view>

#include "protocol/messages.h"

namespace acus {

struct RequestRule {
  enum class Mode { any, real_time, lockstep };

  std::string_view type;
  bool changes_world;  // for all clients: only one that holds a needle may, or any where nobody holds one
  bool costly;         // takes one of the threads more than some microseconds: so many a second of one client
  Mode mode;           // of the server
  bool stream;         // is answered by rejections alone
};

inline constexpr std::array<RequestRule, 16> kRequestRules{{
    // type        changes_world  costly  mode                          stream
    {"hello",      false,         false,  RequestRule::Mode::any,       false},
    {"describe",   false,         true,   RequestRule::Mode::any,       false},
    {"acquire",    false,         false,  RequestRule::Mode::any,       false},
    {"release",    false,         false,  RequestRule::Mode::any,       false},
    {"hash",       false,         true,   RequestRule::Mode::any,       false},
    {"snapshot",   false,         true,   RequestRule::Mode::any,       false},
    {"pause",      true,          true,   RequestRule::Mode::real_time, false},
    {"resume",     true,          true,   RequestRule::Mode::real_time, false},
    {"reset",      true,          true,   RequestRule::Mode::any,       false},
    {"load",       true,          true,   RequestRule::Mode::any,       false},
    {"restore",    true,          true,   RequestRule::Mode::any,       false},
    {"record",     true,          true,   RequestRule::Mode::any,       false},
    {"step",       true,          false,  RequestRule::Mode::lockstep,  false},
    {"shutdown",   true,          false,  RequestRule::Mode::any,       false},
    {"pose",       false,         false,  RequestRule::Mode::any,       true},
    {"spin",       false,         false,  RequestRule::Mode::any,       true},
}};

// Does not compile for a type without a row.
template <class Message>
consteval const RequestRule& rule_of() {
  for (const RequestRule& rule : kRequestRules)
    if (rule.type == Message::kType) return rule;
  throw "no row of kRequestRules";
}

}  // namespace acus
