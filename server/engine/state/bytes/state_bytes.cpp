// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/state/bytes/state_bytes.h"

#include <cmath>
#include <cstring>
#include <memory>
#include <optional>
#include <stdexcept>
#include <type_traits>
#include <utility>

#include "server/engine/math/hasher.h"

namespace acus {

namespace {

constexpr bool kOff = false;

template <class T>
constexpr bool kIsNumber = std::is_arithmetic_v<T> || std::is_enum_v<T>;

// Calls archive.number(x) for every number that stands alone, archive.doubles(pointer, count) for those side by side, and
// archive.size(n, capacity) for every size.
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
    archive.number(number);
  }
  template <class T>
    requires requires(T& t) { std::remove_const_t<T>::fields(t, std::declval<Walk&>()); }
  void visit(T& value) {
    std::remove_const_t<T>::fields(value, *this);
  }

  void visit(auto& value)
    requires std::is_same_v<std::remove_cvref_t<decltype(value)>, Quaternion>
  {
    archive.doubles(value.coeffs().data(), 4);
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
  template <class T>
  static constexpr bool kIsOctets = std::is_same_v<T, RotationBatch> || std::is_same_v<T, StrainBatch>;
  void visit(auto& value) requires kIsOctets<std::remove_cvref_t<decltype(value)>> {
    static_assert(sizeof value % sizeof(Octet) == 0);
    using Number = std::conditional_t<std::is_const_v<std::remove_reference_t<decltype(value)>>, const double, double>;
    archive.doubles(reinterpret_cast<Number*>(&value), sizeof value / sizeof(double));
  }
  template <class T>
    requires requires(T& t) { t.derived().rowwise(); }
  void visit(T& matrix) {
    archive.size(static_cast<std::size_t>(matrix.size()), static_cast<std::size_t>(matrix.size()));
    archive.doubles(matrix.data(), static_cast<std::size_t>(matrix.size()));
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
  // What a scene has not is not written either.
  template <class T>
  void visit(std::optional<T>& value) {
    if (value) visit(*value);
  }
  template <class T>
  void visit(const std::optional<T>& value) {
    if (value) visit(*value);
  }
  template <class T>
  void visit(std::shared_ptr<const T>& shared) {
    auto own = std::make_shared<T>(*shared);
    visit(*own);
    shared = std::move(own);
  }
  template <class T>
  void visit(const std::shared_ptr<const T>& shared) {
    visit(*shared);
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

// What an archive has besides bytes(pointer, count) and size(n, capacity).
template <class Archive>
struct OfBytes {
  template <class T>
  void number(T& value) {
    static_cast<Archive*>(this)->bytes(&value, sizeof value);
  }
  template <class Double>
  void doubles(Double* first, std::size_t count) {
    static_cast<Archive*>(this)->bytes(first, count * sizeof(double));
  }
};

struct StateHasher : OfBytes<StateHasher> {
  Hasher hasher;

  void bytes(const void* data, std::size_t count) { hasher.bytes(data, count); }
  std::size_t size(std::size_t n, std::size_t) {
    bytes(&n, sizeof n);
    return n;
  }
};

struct Writer : OfBytes<Writer> {
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

struct Reader : OfBytes<Reader> {
  std::span<const std::byte> left;

  using OfBytes<Reader>::number;
  // Any byte but 0 and 1 would be no bool.
  void number(bool& value) {
    std::uint8_t byte = 0;
    bytes(&byte, 1);
    value = byte != 0;
  }
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

struct LargestNumber {
  double largest = 0;

  template <class T>
  void number(const T& value) {
    if constexpr (std::is_floating_point_v<T>) doubles(&value, 1);
  }
  void doubles(const double* first, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i)
      if (!(std::abs(first[i]) <= largest)) largest = std::isnan(first[i]) ? kInfinity : std::abs(first[i]);
  }
  std::size_t size(std::size_t n, std::size_t) { return n; }
};

// Names, kinds and sizes of what a type holds, in order; of lists, those of one item.
struct Layout {
  Hasher hasher;

  template <class T>
  void operator()(const char* name, T& value) {
    hasher.bytes(name, std::strlen(name) + 1);
    visit(value);
  }
  template <class T>
  void visit(T& value) {
    if constexpr (requires { T::fields(value, *this); }) {
      T::fields(value, *this);
    } else if constexpr (kIsNumber<T>) {
      tell(std::is_floating_point_v<T> ? 'f' : 'i', sizeof value);
    } else {
      tell('v', sizeof value);
    }
  }
  template <class T>
    requires requires(T& t) { t.derived().rowwise(); }
  void visit(T&) {
    tell('m', static_cast<std::size_t>(T::RowsAtCompileTime));
  }
  template <class T>
  void visit(std::vector<T>&) {
    T item{};
    tell('l', 0);
    visit(item);
  }
  template <class T>
  void visit(Bounded<T>&) {
    T item{};
    tell('b', 0);
    visit(item);
  }
  template <class T>
  void visit(std::optional<T>&) {
    T item{};
    tell('o', 0);
    visit(item);
  }
  template <class T>
  void visit(std::shared_ptr<const T>&) {
    T item{};
    visit(item);
  }

 private:
  void tell(char kind, std::size_t size) {
    hasher.bytes(&kind, 1);
    hasher.bytes(&size, sizeof size);
  }
};

}  // namespace

std::uint64_t hash(const State& state) {
  StateHasher of;
  Walk<StateHasher>{of}.visit(state);
  return of.hasher.digest();
}

std::uint64_t comparable_hash(const State& state) {
  StateHasher of;
  Walk<StateHasher> walk{of};
  State::fields(state, [&](const char*, const auto& value) {
    if (static_cast<const void*>(&value) == &state.economizing) {
      walk.visit(std::as_const(kOff));
    } else {
      walk.visit(value);
    }
  });
  return of.hasher.digest();
}

std::vector<std::byte> to_bytes(const State& state) {
  Writer writer;
  Walk<Writer>{writer}.visit(state);
  return writer.image;
}

void from_bytes(std::span<const std::byte> bytes, State& state) {
  State read = state;
  Reader reader{{}, bytes};
  Walk<Reader>{reader}.visit(read);
  if (!reader.left.empty()) throw std::runtime_error("the image of a state goes on after its end");
  state = std::move(read);
}

double largest_number(const State& state) {
  LargestNumber numbers;
  Walk<LargestNumber>{numbers}.visit(state);
  return numbers.largest;
}

std::uint64_t state_layout() {
  static const std::uint64_t layout = [] {
    Layout of;
    State state;
    of.visit(state);
    return of.hasher.digest();
  }();
  return layout;
}

bool identical(const State& a, const State& b) { return to_bytes(a) == to_bytes(b); }

}  // namespace acus
