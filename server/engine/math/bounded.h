// SPDX-License-Identifier: GPL-3.0-or-later
// A list with a capacity that is fixed when it is made: adding to it never allocates, and a copy has the same capacity.
// A copy to a list that has it costs no more than the items.
#pragma once

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <vector>

namespace acus {

template <class T>
class Bounded {
 public:
  Bounded() = default;
  explicit Bounded(std::size_t capacity) : items_(capacity) {}
  Bounded(const Bounded& other) { *this = other; }
  Bounded(Bounded&&) noexcept = default;
  Bounded& operator=(Bounded&&) noexcept = default;
  Bounded& operator=(const Bounded& other) {
    if (this == &other) return *this;
    items_.resize(other.capacity());
    std::copy(other.begin(), other.end(), items_.begin());
    size_ = other.size_;
    return *this;
  }
  ~Bounded() = default;

  std::size_t capacity() const { return items_.size(); }
  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  bool full() const { return size_ == items_.size(); }

  void push_back(const T& item) {
    assert(!full());
    items_[size_++] = item;
  }
  void pop_back() {
    assert(!empty());
    --size_;
  }
  void clear() { size_ = 0; }
  // What is new has any of the values that were there before.
  void resize(std::size_t size) {
    assert(size <= items_.size());
    size_ = size;
  }

  T& operator[](std::size_t i) {
    assert(i < size_);
    return items_[i];
  }
  const T& operator[](std::size_t i) const {
    assert(i < size_);
    return items_[i];
  }
  T& front() { return (*this)[0]; }
  const T& front() const { return (*this)[0]; }
  T& back() { return (*this)[size_ - 1]; }
  const T& back() const { return (*this)[size_ - 1]; }
  T* begin() { return items_.data(); }
  T* end() { return items_.data() + size_; }
  const T* begin() const { return items_.data(); }
  const T* end() const { return items_.data() + size_; }

 private:
  std::vector<T> items_;
  std::size_t size_ = 0;
};

}  // namespace acus
