// SPDX-License-Identifier: GPL-3.0-or-later
// How two threads exchange values without either ever waiting for the other: a bounded queue that refuses when it is
// full, and a box that holds the newest value. One thread writes, one reads; no locks, no allocation after
// construction. Slots are written and read in place, so that buffers inside them are reused.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace acus {

inline constexpr std::size_t kCacheLine = 64;  // bytes; keeps the two threads' counters from sharing one

// First in, first out. The writer asks for a slot, fills it and commits it; the reader asks for one, uses it and
// releases it.
template <class T>
class SpscQueue {
 public:
  explicit SpscQueue(std::size_t capacity) : slots_(capacity) {}

  std::size_t capacity() const { return slots_.size(); }

  // Every slot, for sizing buffers before the threads start.
  std::vector<T>& slots() { return slots_; }

  // Writer: the next free slot, with whatever it held before; null if the queue is full.
  T* writable() {
    const std::uint64_t written = written_.load(std::memory_order_relaxed);
    if (written - released_.load(std::memory_order_acquire) == slots_.size()) return nullptr;
    return &slots_[written % slots_.size()];
  }
  void commit() { written_.store(written_.load(std::memory_order_relaxed) + 1, std::memory_order_release); }

  // Reader: the oldest committed slot; null if the queue is empty.
  T* readable() {
    const std::uint64_t released = released_.load(std::memory_order_relaxed);
    if (released == written_.load(std::memory_order_acquire)) return nullptr;
    return &slots_[released % slots_.size()];
  }
  void release() { released_.store(released_.load(std::memory_order_relaxed) + 1, std::memory_order_release); }

 private:
  std::vector<T> slots_;
  alignas(kCacheLine) std::atomic<std::uint64_t> written_{0};   // slots ever committed
  alignas(kCacheLine) std::atomic<std::uint64_t> released_{0};  // slots ever released
};

// Holds the newest value: three copies, of which the writer owns one, the reader owns one, and the third waits to be
// swapped in. A value that is overwritten before it is read is lost, which is the point.
template <class T>
class NewestValue {
 public:
  // Writer: replaces the value.
  void put(const T& value) {
    copies_[writing_] = value;
    writing_ = waiting_.exchange(writing_ | kFresh, std::memory_order_acq_rel) & kIndex;
  }

  // Reader: the value if one was put since the last call, else null. Valid until the next call.
  const T* take() {
    if (!(waiting_.load(std::memory_order_relaxed) & kFresh)) return nullptr;
    reading_ = waiting_.exchange(reading_, std::memory_order_acq_rel) & kIndex;
    return &copies_[reading_];
  }

 private:
  static constexpr unsigned kIndex = 3, kFresh = 4;

  std::array<T, 3> copies_{};
  alignas(kCacheLine) std::atomic<unsigned> waiting_{2};  // index of the waiting copy, and whether it is unread
  alignas(kCacheLine) unsigned writing_ = 0;
  alignas(kCacheLine) unsigned reading_ = 1;
};

}  // namespace acus
