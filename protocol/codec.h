// SPDX-License-Identifier: MIT
// Messages to bytes and back: one msgpack map with string keys, which opens with `v` and `type`. Safe on any input:
// size, nesting and element counts are bounded before memory is taken, and what does not follow the contract throws
// DecodeError. Keys that a message does not know are ignored, so that later versions may add fields.
#pragma once

#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>

#include "protocol/messages.h"

namespace acus::protocol {

// A message that does not follow the contract. what() is a sentence that names the field and what was expected.
class DecodeError : public std::runtime_error {
 public:
  DecodeError(ErrorCode code, const std::string& sentence) : std::runtime_error(sentence), code_(code) {}

  ErrorCode code() const { return code_; }

  // What could still be read of the rejected message, to tell its sender which one it was.
  std::optional<std::string> type;
  std::optional<std::uint64_t> seq;

 private:
  ErrorCode code_;
};

// Replaces `bytes` by the encoded message; its capacity is reused.
template <class Message>
void encode(const Message& message, std::string& bytes);

template <class Message>
std::string encode(const Message& message) {
  std::string bytes;
  encode(message, bytes);
  return bytes;
}

// Throw DecodeError. Unit quaternions come back normalised.
Command decode_command(std::string_view bytes, std::size_t max_bytes = kMaxCommandBytes);
Reply decode_reply(std::string_view bytes, std::size_t max_bytes = kMaxStateBytes);
State decode_state(std::string_view bytes, std::size_t max_bytes = kMaxStateBytes);

// One line "type {field: value, ...}" for logs; packed arrays are shown by their length.
template <class Message>
std::string to_text(const Message& message);

}  // namespace acus::protocol
