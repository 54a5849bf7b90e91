// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/runtime/exchange.h"

#include <doctest/doctest.h>

#include <memory>
#include <thread>

namespace acus {
namespace {

// Two halves that must always agree: a torn copy would not.
struct Pair {
  std::uint64_t number = 0, square = 0;
};
Pair pair_of(std::uint64_t number) { return {number, number * number}; }

}  // namespace

TEST_CASE("a queue gives back what it got, in order, and refuses when it is full") {
  SpscQueue<int> queue(3);
  CHECK(queue.readable() == nullptr);
  for (int i = 0; i < 3; ++i) {
    REQUIRE(queue.writable());
    *queue.writable() = i;
    queue.commit();
  }
  CHECK(queue.writable() == nullptr);
  for (int i = 0; i < 3; ++i) {
    REQUIRE(queue.readable());
    CHECK(*queue.readable() == i);
    queue.release();
    CHECK(queue.writable() != nullptr);
  }
  CHECK(queue.readable() == nullptr);
}

TEST_CASE("a slot that is not committed is not seen") {
  SpscQueue<int> queue(2);
  *queue.writable() = 1;
  CHECK(queue.readable() == nullptr);
  queue.commit();
  CHECK(*queue.readable() == 1);
}

TEST_CASE("a queue moves values that cannot be copied") {
  SpscQueue<std::unique_ptr<int>> queue(2);
  *queue.writable() = std::make_unique<int>(5);
  queue.commit();
  const std::unique_ptr<int> out = std::move(*queue.readable());
  queue.release();
  CHECK(*out == 5);
}

TEST_CASE("between two threads a queue loses, tears and reorders nothing") {
  constexpr std::uint64_t kCount = 200000;
  SpscQueue<Pair> queue(64);
  std::thread writer([&] {
    for (std::uint64_t i = 0; i < kCount;) {
      if (Pair* slot = queue.writable()) {
        *slot = pair_of(i++);
        queue.commit();
      } else {
        std::this_thread::yield();
      }
    }
  });
  std::uint64_t wrong = 0;
  for (std::uint64_t i = 0; i < kCount;) {
    if (const Pair* slot = queue.readable()) {
      wrong += slot->number != i || slot->square != i * i;
      queue.release();
      ++i;
    } else {
      std::this_thread::yield();
    }
  }
  writer.join();
  CHECK(wrong == 0);
}

TEST_CASE("the newest value is taken once, and older ones are forgotten") {
  NewestValue<int> box;
  CHECK(box.take() == nullptr);
  box.put(1);
  box.put(2);
  const int* value = box.take();
  REQUIRE(value);
  CHECK(*value == 2);
  CHECK(box.take() == nullptr);
  box.put(3);
  CHECK(*value == 2);  // what was taken stays until the next take
  CHECK(*box.take() == 3);
}

TEST_CASE("between two threads the newest value is never torn, never goes back, and the last one arrives") {
  constexpr std::uint64_t kCount = 200000;
  NewestValue<Pair> box;
  std::thread writer([&] {
    for (std::uint64_t i = 1; i <= kCount; ++i) box.put(pair_of(i));
  });
  std::uint64_t last = 0, wrong = 0;
  while (last < kCount) {
    if (const Pair* value = box.take()) {
      wrong += value->square != value->number * value->number || value->number <= last;
      last = value->number;
    } else {
      std::this_thread::yield();
    }
  }
  writer.join();
  CHECK(wrong == 0);
}

}  // namespace acus
