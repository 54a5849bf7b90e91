// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/simulation/state_bytes.h"

#include <xxhash.h>

#include <cstring>
#include <memory>
#include <stdexcept>
#include <type_traits>

namespace acus {

namespace {

template <class T>
constexpr bool kIsNumber = std::is_arithmetic_v<T> || std::is_enum_v<T>;

// Calls archive.bytes(pointer, count) for every piece of a value, and archive.size(n, capacity) for every size.
template <class Archive>
struct Walk {
  Archive& archive;

  template <class T>
  void operator()(const char*, T& value) {
    visit(value);
  }

  template <class T>
    requires kIsNumber<std::remove_const_t<T>>
  void visit(T& number) {
    archive.bytes(&number, sizeof number);
  }
  template <class T>
    requires requires(T& t) { std::remove_const_t<T>::fields(t, std::declval<Walk&>()); }
  void visit(T& value) {
    std::remove_const_t<T>::fields(value, *this);
  }

  void visit(auto& value)
    requires std::is_same_v<std::remove_cvref_t<decltype(value)>, Quaternion>
  {
    archive.bytes(value.coeffs().data(), 4 * sizeof(double));
  }
  void visit(auto& value)
    requires std::is_same_v<std::remove_cvref_t<decltype(value)>, Pose>
  {
    visit(value.position);
    visit(value.orientation);
  }
  void visit(auto& value)
    requires std::is_same_v<std::remove_cvref_t<decltype(value)>, MaterialPoint>
  {
    visit(value.tetrahedron);
    visit(value.weights);
  }
  void visit(auto& value)
    requires std::is_same_v<std::remove_cvref_t<decltype(value)>, ElementRotations::Batch>
  {
    static_assert(sizeof(ElementRotations::Batch) == 4 * kLanes * sizeof(double));
    archive.bytes(&value, sizeof value);
  }
  template <class T>
    requires requires(T& t) { t.derived().rowwise(); }
  void visit(T& matrix) {
    archive.size(static_cast<std::size_t>(matrix.size()), static_cast<std::size_t>(matrix.size()));
    archive.bytes(matrix.data(), static_cast<std::size_t>(matrix.size()) * sizeof(double));
  }
  template <class T>
  void visit(std::vector<T>& list) {
    archive.size(list.size(), list.size());
    for (T& item : list) visit(item);
  }
  template <class T>
  void visit(const std::vector<T>& list) {
    archive.size(list.size(), list.size());
    for (const T& item : list) visit(item);
  }
  template <class T>
  void visit(Bounded<T>& list) {
    list.resize(archive.size(list.size(), list.capacity()));
    for (T& item : list) visit(item);
  }
  template <class T>
  void visit(const Bounded<T>& list) {
    archive.size(list.size(), list.size());
    for (const T& item : list) visit(item);
  }
};

struct Hasher {
  struct Free {
    void operator()(XXH3_state_t* state) const { XXH3_freeState(state); }
  };
  std::unique_ptr<XXH3_state_t, Free> state{XXH3_createState()};

  Hasher() { XXH3_64bits_reset(state.get()); }
  void bytes(const void* data, std::size_t count) { XXH3_64bits_update(state.get(), data, count); }
  std::size_t size(std::size_t n, std::size_t) {
    bytes(&n, sizeof n);
    return n;
  }
};

struct Writer {
  std::vector<std::byte> image;

  void bytes(const void* data, std::size_t count) {
    const auto* first = static_cast<const std::byte*>(data);
    image.insert(image.end(), first, first + count);
  }
  std::size_t size(std::size_t n, std::size_t) {
    bytes(&n, sizeof n);
    return n;
  }
};

struct Reader {
  std::span<const std::byte> left;

  void bytes(void* data, std::size_t count) {
    if (count > left.size()) throw std::runtime_error("the image of a state ends too early");
    if (count > 0) std::memcpy(data, left.data(), count);
    left = left.subspan(count);
  }
  // What is there must have the size of the state, or room in its capacity.
  std::size_t size(std::size_t expected, std::size_t capacity) {
    std::size_t n = 0;
    bytes(&n, sizeof n);
    if (n > capacity || (n != expected && capacity == expected))
      throw std::runtime_error("the image is that of a state of another scene");
    return n;
  }
};

}  // namespace

std::uint64_t hash(const State& state) {
  Hasher hasher;
  Walk<Hasher>{hasher}.visit(state);
  return XXH3_64bits_digest(hasher.state.get());
}

std::vector<std::byte> to_bytes(const State& state) {
  Writer writer;
  Walk<Writer>{writer}.visit(state);
  return writer.image;
}

void from_bytes(std::span<const std::byte> bytes, State& state) {
  State read = state;
  Reader reader{bytes};
  Walk<Reader>{reader}.visit(read);
  if (!reader.left.empty()) throw std::runtime_error("the image of a state goes on after its end");
  state = std::move(read);
}

bool identical(const State& a, const State& b) { return to_bytes(a) == to_bytes(b); }

}  // namespace acus
