// SPDX-License-Identifier: GPL-3.0-or-later
// XXH3 of bytes that come piece by piece.
#pragma once

#include <xxhash.h>

#include <cstddef>
#include <cstdint>
#include <memory>

namespace acus {

class Hasher {
 public:
  Hasher() { restart(); }

  void restart() { XXH3_64bits_reset(state_.get()); }
  void bytes(const void* data, std::size_t count) { XXH3_64bits_update(state_.get(), data, count); }
  std::uint64_t digest() const { return XXH3_64bits_digest(state_.get()); }

 private:
  struct Free {
    void operator()(XXH3_state_t* state) const { XXH3_freeState(state); }
  };
  std::unique_ptr<XXH3_state_t, Free> state_{XXH3_createState()};
};

}  // namespace acus
