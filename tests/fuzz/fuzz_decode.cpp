// SPDX-License-Identifier: GPL-3.0-or-later
// Messages: what is accepted is the same after it was encoded and decoded again.
#include "protocol/codec.h"
#include "tests/fuzz/fuzz.h"

namespace {

using namespace acus::protocol;

template <class Message, class Decode>
void there_and_back(std::string_view bytes, Decode decode) {
  try {
    const Message message = decode(bytes);
    const std::string once = std::visit([](const auto& it) { return encode(it); }, message);
    const std::string twice = std::visit([](const auto& it) { return encode(it); }, decode(once));
    acus::fuzz::require(once == twice, "a message that was decoded is the same in the next round");
  } catch (const DecodeError&) {
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view bytes = acus::fuzz::text_of(data, size);
  there_and_back<Command>(bytes, [](std::string_view b) { return decode_command(b); });
  there_and_back<Reply>(bytes, [](std::string_view b) { return decode_reply(b); });
  there_and_back<State>(bytes, [](std::string_view b) { return decode_state(b); });
  return 0;
}
