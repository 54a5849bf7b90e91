// SPDX-License-Identifier: MIT
// msgpack's packer with numbers that come back to the last bit. Not installed: users need not have msgpack.
#pragma once

#include <bit>
#include <cstdint>
#include <msgpack.hpp>
#include <string>
#include <string_view>

namespace acus::protocol {

// What msgpack's packer writes into.
struct StringSink {
  std::string& bytes;
  void write(const char* data, std::size_t size) { bytes.append(data, size); }
};

class Packer : public msgpack::packer<StringSink> {
 public:
  explicit Packer(StringSink& sink) : msgpack::packer<StringSink>(sink), sink_(sink) {}

  void pack_text(std::string_view text) {
    pack_str(static_cast<std::uint32_t>(text.size()));
    pack_str_body(text.data(), static_cast<std::uint32_t>(text.size()));
  }

  // Always as float64: the base class would turn whole numbers into integers, and -0 into 0.
  void pack_number(double value) {
    std::uint64_t bits = std::bit_cast<std::uint64_t>(value);
    char bytes[9] = {'\xcb'};
    for (int i = 8; i > 0; --i, bits >>= 8) bytes[i] = static_cast<char>(bits & 0xff);
    sink_.write(bytes, sizeof bytes);
  }

 private:
  StringSink& sink_;
};

}  // namespace acus::protocol
