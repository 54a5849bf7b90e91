// SPDX-License-Identifier: MIT
// A link that delivers late: each item after a delay and a random extra time (jitter), in the order in which they were
// sent, but for a random share that is lost; the same for the same seed. Room is fixed; an item that does not fit is
// lost.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

namespace acus::haptics {

struct LinkDelay {
  double delay = 0;        // s, >= 0
  double jitter = 0;       // s, >= 0: up to so much more
  std::uint64_t seed = 1;  // > 0
  double loss = 0;         // 0 to 1, share of items that never come
};

// Of a network that is told by the delays of both ways together, the same each way.
inline LinkDelay way_there(LinkDelay both) {
  both.delay /= 2;
  both.jitter /= 2;
  return both;
}
inline LinkDelay way_back(const LinkDelay& both) {
  LinkDelay way = way_there(both);
  ++way.seed;
  return way;
}

// Marsaglia's xorshift: 0 to 1.
inline double next_random(std::uint64_t& state) {
  state ^= state << 13;
  state ^= state >> 7;
  state ^= state << 17;
  return static_cast<double>(state >> 11) / 9007199254740992.0;  // 2^53
}

template <class Item, int capacity = 512>
class DelayLine {
 public:
  explicit DelayLine(const LinkDelay& link) : link_(link), random_(link.seed) {}

  void send(double now, const Item& item) {
    if (count_ == capacity || (link_.loss > 0 && next_random(random_) < link_.loss)) return;
    double due = now + link_.delay + link_.jitter * next_random(random_);
    if (due < last_due_) due = last_due_;
    last_due_ = due;
    entries_[index(count_++)] = {due, item};
  }

  // The oldest item that is due.
  std::optional<Item> receive(double now) {
    if (count_ == 0 || entries_[index(0)].due > now + 1e-9) return std::nullopt;
    const Item item = entries_[index(0)].item;
    first_ = (first_ + 1) % capacity;
    --count_;
    return item;
  }

 private:
  struct Entry {
    double due = 0;
    Item item{};
  };
  std::size_t index(int i) const { return static_cast<std::size_t>((first_ + i) % capacity); }

  LinkDelay link_;
  std::uint64_t random_;
  double last_due_ = 0;
  std::array<Entry, capacity> entries_{};
  int first_ = 0, count_ = 0;
};

}  // namespace acus::haptics
