// SPDX-License-Identifier: MIT
#include "protocol/codec.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <msgpack.hpp>
#include <type_traits>

#include "protocol/packer.h"
#include "protocol/unit_quaternion.h"

namespace acus::protocol {
namespace {

static_assert(std::endian::native == std::endian::little, "packed arrays are little-endian on the wire");

// More than any message needs, so that hostile nesting or counts are refused before they cost memory.
constexpr std::size_t kMaxElements = 65536;  // of one array or map
constexpr std::size_t kMaxDepth = 8;

template <class T>
constexpr bool kIsOptional = false;
template <class T>
constexpr bool kIsOptional<std::optional<T>> = true;

template <class T>
constexpr bool kIsVector = false;
template <class T>
constexpr bool kIsVector<std::vector<T>> = true;

template <class T>
concept Message = requires {
  T::kType;
};

std::string quoted(const char* name) { return "field '" + std::string(name) + "'"; }

// ---- Encoding ----

template <class T>
void pack_map_fields(Packer& packer, const T& fielded);

template <class T>
void pack_value(Packer& packer, const T& value) {
  if constexpr (std::is_enum_v<T>) {
    packer.pack_text(name_of(value));
  } else if constexpr (std::is_floating_point_v<T>) {
    packer.pack_number(value);
  } else if constexpr (std::is_arithmetic_v<T>) {
    packer.pack(value);
  } else if constexpr (std::is_same_v<T, std::string>) {
    packer.pack_text(value);
  } else if constexpr (std::is_same_v<T, Vector3>) {
    packer.pack_array(3);
    for (double x : value) packer.pack_number(x);
  } else if constexpr (std::is_same_v<T, Quaternion>) {
    packer.pack_array(4);
    for (double x : {value.w, value.x, value.y, value.z}) packer.pack_number(x);
  } else if constexpr (kIsVector<T>) {
    using Element = typename T::value_type;
    if constexpr (std::is_arithmetic_v<Element>) {
      const auto size = static_cast<std::uint32_t>(value.size() * sizeof(Element));
      packer.pack_bin(size);
      packer.pack_bin_body(reinterpret_cast<const char*>(value.data()), size);
    } else {
      packer.pack_array(static_cast<std::uint32_t>(value.size()));
      for (const Element& element : value) pack_value(packer, element);
    }
  } else {
    pack_map_fields(packer, value);
  }
}

struct PackField {
  Packer& packer;

  template <class T>
  void operator()(const char* name, const T& value) {
    if constexpr (kIsOptional<T>) {
      if (value) (*this)(name, *value);
    } else {
      packer.pack_text(name);
      pack_value(packer, value);
    }
  }
};

struct CountFields {
  std::uint32_t count = 0;

  template <class T>
  void operator()(const char*, const T& value) {
    if constexpr (kIsOptional<T>) {
      count += value.has_value() ? 1 : 0;
    } else {
      ++count;
    }
  }
};

template <class T>
void pack_map_fields(Packer& packer, const T& fielded) {
  CountFields counter;
  T::fields(fielded, counter);
  packer.pack_map(counter.count + (Message<T> ? 2 : 0));
  PackField pack{packer};
  if constexpr (Message<T>) {
    static_assert(kOldestVersion == kVersion, "with more versions each client has its own, which its hello finds");
    pack("v", kVersion);
    pack("type", std::string(T::kType));
  }
  T::fields(fielded, pack);
}

// ---- Decoding ----

// The value under `key`, or null. A key that appears twice counts where it appears first.
const msgpack::object* find(const msgpack::object& map, std::string_view key) {
  for (std::uint32_t i = 0; i < map.via.map.size; ++i) {
    const msgpack::object_kv& entry = map.via.map.ptr[i];
    if (entry.key.type != msgpack::type::STR) continue;
    if (std::string_view(entry.key.via.str.ptr, entry.key.via.str.size) == key) return &entry.val;
  }
  return nullptr;
}

[[noreturn]] void wrong_type(const char* name, const std::string& expected) {
  throw DecodeError(ErrorCode::wrong_field_type, quoted(name) + " must be " + expected);
}

void check_finite(const char* name, double value) {
  if (!std::isfinite(value)) throw DecodeError(ErrorCode::not_finite, quoted(name) + " must be finite");
}

void unpack(const char* name, const msgpack::object& object, bool& value) {
  if (object.type != msgpack::type::BOOLEAN) wrong_type(name, "true or false");
  value = object.via.boolean;
}

template <class T>
requires(std::is_unsigned_v<T> && !std::is_same_v<T, bool>) void unpack(const char* name, const msgpack::object& object,
                                                                        T& value) {
  if (object.type == msgpack::type::NEGATIVE_INTEGER) {
    throw DecodeError(ErrorCode::bad_value, quoted(name) + " must not be negative");
  }
  if (object.type != msgpack::type::POSITIVE_INTEGER) wrong_type(name, "an integer");
  if (object.via.u64 > std::numeric_limits<T>::max()) {
    throw DecodeError(ErrorCode::bad_value,
                      quoted(name) + " must be at most " + std::to_string(std::numeric_limits<T>::max()));
  }
  value = static_cast<T>(object.via.u64);
}

// Clients may write a whole number as an integer, and any number in single precision.
void unpack(const char* name, const msgpack::object& object, double& value) {
  switch (object.type) {
    case msgpack::type::FLOAT32:
    case msgpack::type::FLOAT64:
      value = object.via.f64;
      break;
    case msgpack::type::POSITIVE_INTEGER:
      value = static_cast<double>(object.via.u64);
      break;
    case msgpack::type::NEGATIVE_INTEGER:
      value = static_cast<double>(object.via.i64);
      break;
    default:
      wrong_type(name, "a number");
  }
  check_finite(name, value);
}

void unpack(const char* name, const msgpack::object& object, std::string& value) {
  if (object.type != msgpack::type::STR) wrong_type(name, "a string");
  value.assign(object.via.str.ptr, object.via.str.size);
}

template <class Enum>
requires std::is_enum_v<Enum>
void unpack(const char* name, const msgpack::object& object, Enum& value) {
  std::string text;
  unpack(name, object, text);
  const auto& names = names_of(Enum{});
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (text == names[i]) {
      value = static_cast<Enum>(i);
      return;
    }
  }
  throw DecodeError(ErrorCode::bad_value, quoted(name) + " has a value that this version does not know");
}

template <std::size_t N>
std::array<double, N> unpack_numbers(const char* name, const msgpack::object& object) {
  if (object.type != msgpack::type::ARRAY || object.via.array.size != N) {
    wrong_type(name, "an array of " + std::to_string(N) + " numbers");
  }
  std::array<double, N> numbers;
  for (std::size_t i = 0; i < N; ++i) unpack(name, object.via.array.ptr[i], numbers[i]);
  return numbers;
}

void unpack(const char* name, const msgpack::object& object, Vector3& value) {
  value = unpack_numbers<3>(name, object);
}

void unpack(const char* name, const msgpack::object& object, Quaternion& value) {
  const auto [w, x, y, z] = unpack_numbers<4>(name, object);
  const double length = quaternion_length(w, x, y, z);
  if (!is_unit_length(length)) {
    throw DecodeError(
        ErrorCode::not_unit_quaternion,
        quoted(name) + " must be a unit quaternion [w, x, y, z], its length is " + std::to_string(length));
  }
  value = {w / length, x / length, y / length, z / length};
}

template <class T>
void unpack_map_fields(const msgpack::object& map, T& fielded);

template <class T>
requires requires(T& fielded) {
  T::fields(fielded, [](const char*, auto&) {});
}
void unpack(const char* name, const msgpack::object& object, T& value) {
  if (object.type != msgpack::type::MAP) wrong_type(name, "a map");
  unpack_map_fields(object, value);
}

template <class Element>
void unpack(const char* name, const msgpack::object& object, std::vector<Element>& value) {
  if constexpr (std::is_arithmetic_v<Element>) {
    if (object.type != msgpack::type::BIN || object.via.bin.size % sizeof(Element) != 0) {
      wrong_type(name, "binary data in elements of " + std::to_string(sizeof(Element)) + " bytes");
    }
    value.resize(object.via.bin.size / sizeof(Element));
    if (!value.empty()) std::memcpy(value.data(), object.via.bin.ptr, object.via.bin.size);
    if constexpr (std::is_floating_point_v<Element>) {
      for (Element element : value) check_finite(name, element);
    }
  } else {
    if (object.type != msgpack::type::ARRAY) wrong_type(name, "an array");
    value.resize(object.via.array.size);
    for (std::size_t i = 0; i < value.size(); ++i) unpack(name, object.via.array.ptr[i], value[i]);
  }
}

struct UnpackField {
  const msgpack::object& map;

  template <class T>
  void operator()(const char* name, T& value) {
    const msgpack::object* object = find(map, name);
    if constexpr (kIsOptional<T>) {
      typename T::value_type present{};
      if (object) unpack(name, *object, present);
      value = object ? T(std::move(present)) : std::nullopt;
    } else {
      if (!object) throw DecodeError(ErrorCode::missing_field, quoted(name) + " is missing");
      unpack(name, *object, value);
    }
  }
};

template <class T>
void unpack_map_fields(const msgpack::object& map, T& fielded) {
  T::fields(fielded, UnpackField{map});
}

// Strings and binary data stay in the message's bytes until they are copied into a field.
bool leave_in_place(msgpack::type::object_type, std::size_t, void*) { return true; }

msgpack::object parse(std::string_view bytes, msgpack::zone& zone) {
  const msgpack::unpack_limit limits(kMaxElements, kMaxElements, 0xffffffff, 0xffffffff, 0, kMaxDepth);
  std::size_t used = 0;
  bool referenced = false;
  msgpack::object object;
  try {
    object = msgpack::unpack(zone, bytes.data(), bytes.size(), used, referenced, leave_in_place, nullptr, limits);
  } catch (const msgpack::insufficient_bytes&) {
    throw DecodeError(ErrorCode::truncated, "the message ends in the middle of a value");
  } catch (const msgpack::size_overflow&) {
    throw DecodeError(ErrorCode::too_complex,
                      "the message is nested too deep, or has too many elements or a msgpack extension");
  } catch (const msgpack::unpack_error&) {
    throw DecodeError(ErrorCode::invalid_msgpack, "the message is not valid msgpack");
  }
  if (used != bytes.size()) throw DecodeError(ErrorCode::trailing_bytes, "the message goes on after its map");
  return object;
}

// Text that begins a map or list of JSON, each of whose characters msgpack takes for a number.
bool is_json(std::string_view bytes) {
  if (bytes.starts_with("\xef\xbb\xbf")) bytes.remove_prefix(3);
  const auto first = bytes.find_first_not_of(" \t\r\n");
  if (first == std::string_view::npos || (bytes[first] != '{' && bytes[first] != '[')) return false;
  const auto second = bytes.find_first_not_of(" \t\r\n", first + 1);
  return second != std::string_view::npos && std::string_view("\"'}]{[").find(bytes[second]) != std::string_view::npos;
}

msgpack::object parse_payload(std::string_view bytes, msgpack::zone& zone) {
  try {
    return parse(bytes, zone);
  } catch (const DecodeError& error) {
    if (!is_json(bytes)) throw;
    throw DecodeError(
        error.code(),
        "the message is JSON; send it as msgpack (in Python msgpack.packb, in JavaScript encode of @msgpack/msgpack)");
  }
}

std::string versions(std::uint64_t oldest, std::uint64_t newest) {
  return (oldest < newest ? std::to_string(oldest) + " to " : "") + std::to_string(newest);
}

// Of a message, by its type. A hello opens a conversation: one of the versions from its `oldest_version` to its `v`
// must be spoken here.
void check_version(const msgpack::object& map, std::string_view type) {
  const msgpack::object* version = find(map, "v");
  if (!version) throw DecodeError(ErrorCode::missing_field, "field 'v', the protocol version, is missing");
  std::uint64_t number = 0;
  unpack("v", *version, number);
  std::uint64_t oldest = number;
  if (const msgpack::object* told = type == Hello::kType ? find(map, "oldest_version") : nullptr)
    unpack("oldest_version", *told, oldest);
  oldest = std::min(oldest, number);
  if (number >= kOldestVersion && oldest <= kVersion) return;
  throw DecodeError(ErrorCode::wrong_version, "protocol version " + versions(oldest, number) +
                                                  " is not spoken here, but " + versions(kOldestVersion, kVersion) +
                                                  "; use a client and a server of the same version of Acus");
}

std::string read_type(const msgpack::object& map) {
  const msgpack::object* object = find(map, "type");
  if (!object) throw DecodeError(ErrorCode::missing_field, "field 'type' is missing");
  std::string type;
  unpack("type", *object, type);
  return type;
}

// Unpacks the alternative of the variant whose type it is; false if none is.
template <class Variant, std::size_t I = 0>
bool unpack_as(const std::string& type, const msgpack::object& map, Variant& message) {
  if constexpr (I == std::variant_size_v<Variant>) {
    return false;
  } else {
    using Alternative = std::variant_alternative_t<I, Variant>;
    if (type != Alternative::kType) return unpack_as<Variant, I + 1>(type, map, message);
    Alternative alternative;
    unpack_map_fields(map, alternative);
    message = std::move(alternative);
    return true;
  }
}

void note_what_is_readable(const msgpack::object& map, DecodeError& error) {
  const msgpack::object* type = find(map, "type");
  if (type && type->type == msgpack::type::STR) error.type.emplace(type->via.str.ptr, type->via.str.size);
  const msgpack::object* seq = find(map, "seq");
  if (seq && seq->type == msgpack::type::POSITIVE_INTEGER) error.seq = seq->via.u64;
}

// Whether the message is a map of few values with this type, found without memory for more of it.
bool is_small_map_of(const char* type, std::string_view bytes) {
  struct Skim : msgpack::null_visitor {
    int values = 0;
    int depth = 0;
    bool at_type = false, found = false;
    std::string_view type;

    bool start_map(std::uint32_t count) { return ++depth == 1 && count <= 16; }
    bool start_array(std::uint32_t) { return false; }
    bool visit_str(const char* text, std::uint32_t size) {
      const std::string_view value(text, size);
      found = found || (at_type && value == type);
      at_type = !at_type && value == "type";
      return ++values <= 32;
    }
  } skim;
  skim.type = type;
  std::size_t used = 0;
  return msgpack::parse(bytes.data(), bytes.size(), used, skim) && used == bytes.size() && skim.found;
}

template <class Variant>
Variant decode(std::string_view bytes, std::size_t max_bytes) {
  if (bytes.size() > max_bytes) {
    throw DecodeError(ErrorCode::oversized, "the message has " + std::to_string(bytes.size()) + " bytes, " +
                                                std::to_string(max_bytes) + " are allowed");
  }
  msgpack::zone zone;
  const msgpack::object map = parse_payload(bytes, zone);
  if (map.type != msgpack::type::MAP) throw DecodeError(ErrorCode::not_a_map, "the message must be a map");
  try {
    const std::string type = read_type(map);
    check_version(map, type);
    Variant message;
    if (!unpack_as(type, map, message)) {
      throw DecodeError(ErrorCode::unknown_type, "field 'type' names no message that is understood here");
    }
    return message;
  } catch (DecodeError& error) {
    note_what_is_readable(map, error);
    throw;
  }
}

void check_range(const Step& step) {
  if (step.ticks < 1 || step.ticks > kMaxStepTicks) {
    throw DecodeError(ErrorCode::bad_value, "field 'ticks' must be 1 to " + std::to_string(kMaxStepTicks));
  }
}

std::string shown(double value) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.6g", value);
  return buffer;
}

void check_within(const char* name, double value, double most, const char* unit) {
  if (std::abs(value) <= most) return;
  char found[32];
  *std::to_chars(found, found + sizeof found - 1, value).ptr = '\0';  // all digits: 100.00000000000001 is not 100
  throw DecodeError(ErrorCode::bad_value, quoted(name) + " must be in [" + shown(-most) + ", " + shown(most) + "] " +
                                              unit + ", found " + found);
}

// States say 0 for "no command yet", so no command may use it.
void check_seq(std::uint64_t seq) {
  if (seq < 1) throw DecodeError(ErrorCode::bad_value, "field 'seq' must be at least 1");
}

void check_range(const Pose& pose) {
  check_seq(pose.seq);
  for (const double x : pose.position) check_within("position", x, kMaxPosition, "m");
  if (pose.spin) check_within("spin", *pose.spin, kMaxSpin, "rad");
}

void check_range(const Spin& spin) {
  check_seq(spin.seq);
  check_within("spin", spin.spin, kMaxSpin, "rad");
}

template <class Other>
void check_range(const Other&) {}

// ---- Printing ----

template <class T>
void print_fields(std::string& text, const T& fielded);

void print(std::string& text, double value) { text += shown(value); }

template <class Range>
void print_list(std::string& text, const Range& range) {
  const char* separator = "[";
  for (double x : range) {
    text += separator;
    print(text, x);
    separator = ", ";
  }
  text += "]";
}

template <class T>
void print_value(std::string& text, const T& value) {
  if constexpr (std::is_enum_v<T>) {
    text += name_of(value);
  } else if constexpr (std::is_same_v<T, bool>) {
    text += value ? "true" : "false";
  } else if constexpr (std::is_integral_v<T>) {
    text += std::to_string(value);
  } else if constexpr (std::is_floating_point_v<T>) {
    print(text, value);
  } else if constexpr (std::is_same_v<T, std::string>) {
    text += '"' + value + '"';
  } else if constexpr (std::is_same_v<T, Vector3>) {
    print_list(text, value);
  } else if constexpr (std::is_same_v<T, Quaternion>) {
    print_list(text, std::initializer_list<double>{value.w, value.x, value.y, value.z});
  } else if constexpr (kIsVector<T>) {
    if constexpr (std::is_arithmetic_v<typename T::value_type>) {
      text += "<" + std::to_string(value.size()) + " numbers>";
    } else {
      text += "[";
      for (std::size_t i = 0; i < value.size(); ++i) {
        if (i > 0) text += ", ";
        print_value(text, value[i]);
      }
      text += "]";
    }
  } else {
    print_fields(text, value);
  }
}

struct PrintField {
  std::string& text;
  bool first = true;

  template <class T>
  void operator()(const char* name, const T& value) {
    if constexpr (kIsOptional<T>) {
      if (value) (*this)(name, *value);
    } else {
      if (!first) text += ", ";
      first = false;
      text += name;
      text += ": ";
      print_value(text, value);
    }
  }
};

template <class T>
void print_fields(std::string& text, const T& fielded) {
  text += "{";
  T::fields(fielded, PrintField{text});
  text += "}";
}

}  // namespace

template <class Message>
void encode(const Message& message, std::string& bytes) {
  bytes.clear();
  StringSink sink{bytes};
  Packer packer(sink);
  pack_map_fields(packer, message);
}

template <class Message>
std::string to_text(const Message& message) {
  std::string text = std::string(Message::kType) + " ";
  print_fields(text, message);
  return text;
}

Command decode_command(std::string_view bytes, std::size_t max_bytes) {
  const bool restore =
      bytes.size() > max_bytes && bytes.size() <= kMaxRestoreBytes && is_small_map_of("restore", bytes);
  Command command = decode<Command>(bytes, restore ? kMaxRestoreBytes : max_bytes);
  std::visit(
      [](const auto& message) {
        try {
          check_range(message);
        } catch (DecodeError& error) {
          error.type = message.kType;
          error.seq = message.seq;
          throw;
        }
      },
      command);
  return command;
}

Reply decode_reply(std::string_view bytes, std::size_t max_bytes) { return decode<Reply>(bytes, max_bytes); }
State decode_state(std::string_view bytes, std::size_t max_bytes) { return decode<State>(bytes, max_bytes); }

// Instantiates both templates of the header for every alternative of a variant.
template <class Variant>
struct Instances;
template <class... Messages>
struct Instances<std::variant<Messages...>> {
  static constexpr auto kEncoders = std::make_tuple(static_cast<void (*)(const Messages&, std::string&)>(&encode)...);
  static constexpr auto kPrinters = std::make_tuple(&to_text<Messages>...);
};
template struct Instances<Command>;
template struct Instances<Reply>;
template struct Instances<State>;

}  // namespace acus::protocol
