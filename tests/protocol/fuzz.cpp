// SPDX-License-Identifier: GPL-3.0-or-later
// Whatever the bytes, the decoder either returns a message or throws DecodeError.
#include <doctest/doctest.h>

#include "tests/protocol/random_message.h"

namespace acus::protocol::testing {
namespace {

template <class Variant>
void decode_anything(const std::string& bytes) {
  try {
    decode<Variant>(bytes);
  } catch (const DecodeError&) {
  }
}

void flip_bits(Random& random, std::string& bytes) {
  for (std::size_t flips = 1 + random() % 8; flips > 0; --flips) {
    bytes[random() % bytes.size()] ^= static_cast<char>(1u << (random() % 8));
  }
}

void splice(Random& random, std::string& bytes) {
  const std::size_t from = random() % bytes.size();
  const std::string piece = bytes.substr(from, random() % 32);
  bytes.insert(random() % bytes.size(), piece);
}

template <class Variant>
void maul_messages() {
  Random random(2);
  for (int repetition = 0; repetition < 2000; ++repetition) {
    for_each_message<Variant>(random, [&](const auto& message) {
      const std::string good = encode(message);
      decode_anything<Variant>(good.substr(0, random() % good.size()));
      std::string flipped = good;
      flip_bits(random, flipped);
      decode_anything<Variant>(flipped);
      std::string spliced = good;
      splice(random, spliced);
      decode_anything<Variant>(spliced);
    });
  }
}

}  // namespace

TEST_CASE("mauled commands never crash the decoder") { maul_messages<Command>(); }
TEST_CASE("mauled replies never crash the decoder") { maul_messages<Reply>(); }
TEST_CASE("mauled states never crash the decoder") { maul_messages<State>(); }

TEST_CASE("random bytes never crash the decoder") {
  Random random(3);
  for (int repetition = 0; repetition < 20000; ++repetition) {
    std::string bytes(random() % 200, '\0');
    for (char& c : bytes) c = static_cast<char>(random());
    if (!bytes.empty() && random() % 2 == 0) bytes[0] = static_cast<char>(0x80 + random() % 16);
    decode_anything<Command>(bytes);
  }
}

}  // namespace acus::protocol::testing
