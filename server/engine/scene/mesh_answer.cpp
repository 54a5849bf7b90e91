// SPDX-License-Identifier: GPL-3.0-or-later
// Layout, in the machine's byte order, all counts as 64-bit numbers: kMagic, kind, and then
//   kMesh:  nodes n, tetrahedra t, names m; 3n doubles; 4t and t 32-bit integers; m times group, length, bytes
//   kError: length, bytes
#include "server/engine/scene/mesh_answer.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "server/engine/models/tetrahedral_mesh.h"

namespace acus {
namespace {

constexpr std::uint64_t kMagic = 0x3148'5345'4d41'4341;  // "ACAMESH1"; another layout has another number
constexpr std::uint64_t kMesh = 1;
constexpr std::uint64_t kError = 2;

class Writer {
 public:
  void put(std::uint64_t number) { append(&number, sizeof(number)); }

  void put(const std::string& text) {
    put(text.size());
    append(text.data(), text.size());
  }

  template <class Number>
  void put_all(const std::vector<Number>& numbers) {
    append(numbers.data(), numbers.size() * sizeof(Number));
  }

  std::vector<char> take() { return std::move(bytes_); }

 private:
  void append(const void* data, std::size_t size) {
    if (size == 0) return;
    const std::size_t end = bytes_.size();
    bytes_.resize(end + size);
    std::memcpy(bytes_.data() + end, data, size);
  }

  std::vector<char> bytes_;
};

[[noreturn]] void refuse(const std::string& what) {
  throw MeshError("the answer of acus-mesh is wrong: " + what +
                  "; the file is damaged, or acus-mesh is of another version than this program");
}

class Cursor {
 public:
  explicit Cursor(std::span<const char> bytes) : rest_(bytes) {}

  std::uint64_t number() {
    std::uint64_t value = 0;
    std::memcpy(&value, take(sizeof(value)).data(), sizeof(value));
    return value;
  }

  std::uint64_t count(const char* what, std::uint64_t most) {
    const std::uint64_t value = number();
    if (value > most) {
      refuse("expected at most " + std::to_string(most) + " " + what + ", found " + std::to_string(value));
    }
    return value;
  }

  std::string text(std::uint64_t most) {
    const std::span<const char> found = take(count("bytes of text", most));
    return {found.begin(), found.end()};
  }

  // `count` is bounded, so its product with the size is, too.
  template <class Number>
  std::vector<Number> numbers(std::uint64_t count) {
    const std::span<const char> found = take(count * sizeof(Number));
    std::vector<Number> values(count);
    if (count > 0) std::memcpy(values.data(), found.data(), found.size());
    return values;
  }

  void expect_end() const {
    if (!rest_.empty()) refuse("expected its end, found " + std::to_string(rest_.size()) + " more bytes");
  }

 private:
  std::span<const char> take(std::uint64_t size) {
    if (size > rest_.size()) {
      refuse("expected " + std::to_string(size) + " more bytes, found " + std::to_string(rest_.size()));
    }
    const std::span<const char> taken = rest_.first(size);
    rest_ = rest_.subspan(size);
    return taken;
  }

  std::span<const char> rest_;
};

void check_limit(const char* what, std::uint64_t most, std::uint64_t found) {
  if (found <= most) return;
  throw MeshError("expected a mesh of at most " + std::to_string(most) + " " + what + ", found " +
                  std::to_string(found));
}

bool all_within(const std::vector<std::int32_t>& values, std::int32_t most) {
  return std::all_of(values.begin(), values.end(), [most](std::int32_t value) { return value >= 0 && value <= most; });
}

// Terminals and clients show these texts, which may repeat bytes of a damaged file.
void make_printable(std::string& text) {
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
}

void check_numbers(const RawMesh& mesh) {
  const auto finite = [](double value) { return std::isfinite(value); };
  const auto bad = std::find_if_not(mesh.coordinates.begin(), mesh.coordinates.end(), finite);
  if (bad != mesh.coordinates.end()) {
    throw MeshError("node " + std::to_string((bad - mesh.coordinates.begin()) / 3) +
                    " has a coordinate that is not finite");
  }
  if (!all_within(mesh.tetrahedra, static_cast<std::int32_t>(mesh.coordinates.size() / 3) - 1)) {
    refuse("a tetrahedron names a node that is not there");
  }
  if (!all_within(mesh.groups, kMaxPhysicalGroup)) refuse("a physical group is out of range");
}

void read_names(Cursor& cursor, std::uint64_t count, RawMesh& mesh) {
  const auto largest = static_cast<std::uint64_t>(*std::max_element(mesh.groups.begin(), mesh.groups.end()));
  mesh.group_names.resize(largest + 1);
  for (std::uint64_t i = 0; i < count; ++i) {
    const std::uint64_t group = cursor.count("as the number of a named group", largest);
    mesh.group_names[group] = cursor.text(kMaxGroupName);
  }
}

RawMesh read_mesh(Cursor& cursor) {
  const std::uint64_t nodes = cursor.count("nodes", kMaxMeshNodes);
  const std::uint64_t tetrahedra = cursor.count("tetrahedra", kMaxMeshTetrahedra);
  const std::uint64_t names = cursor.count("names", kMaxGroupNames);
  if (nodes == 0 || tetrahedra == 0) refuse("it holds no tetrahedra");
  RawMesh mesh;
  mesh.coordinates = cursor.numbers<double>(3 * nodes);
  mesh.tetrahedra = cursor.numbers<std::int32_t>(4 * tetrahedra);
  mesh.groups = cursor.numbers<std::int32_t>(tetrahedra);
  check_numbers(mesh);
  read_names(cursor, names, mesh);
  cursor.expect_end();
  return mesh;
}

}  // namespace

std::vector<char> encode_mesh(const RawMesh& mesh) {
  check_limit("nodes", kMaxMeshNodes, mesh.coordinates.size() / 3);
  check_limit("tetrahedra", kMaxMeshTetrahedra, mesh.groups.size());
  const auto named = [](const std::string& name) { return !name.empty(); };
  const auto names = std::count_if(mesh.group_names.begin(), mesh.group_names.end(), named);
  check_limit("named groups", kMaxGroupNames, static_cast<std::uint64_t>(names));
  Writer writer;
  writer.put(kMagic);
  writer.put(kMesh);
  writer.put(mesh.coordinates.size() / 3);
  writer.put(mesh.groups.size());
  writer.put(static_cast<std::uint64_t>(names));
  writer.put_all(mesh.coordinates);
  writer.put_all(mesh.tetrahedra);
  writer.put_all(mesh.groups);
  for (std::size_t group = 0; group < mesh.group_names.size(); ++group) {
    if (!named(mesh.group_names[group])) continue;
    check_limit("bytes in a group's name", kMaxGroupName, mesh.group_names[group].size());
    writer.put(group);
    writer.put(mesh.group_names[group]);
  }
  return writer.take();
}

std::vector<char> encode_mesh_error(const std::string& what) {
  Writer writer;
  writer.put(kMagic);
  writer.put(kError);
  writer.put(what.substr(0, kMaxAnswerText));
  return writer.take();
}

RawMesh decode_mesh_answer(std::span<const char> bytes) {
  Cursor cursor(bytes);
  if (bytes.empty()) refuse("it is empty");
  if (cursor.number() != kMagic) refuse("it does not begin as one");
  const std::uint64_t kind = cursor.number();
  if (kind == kMesh) return read_mesh(cursor);
  if (kind != kError) refuse("it is neither a mesh nor an error");
  std::string what = cursor.text(kMaxAnswerText);
  cursor.expect_end();
  make_printable(what);
  throw MeshError(what);
}

}  // namespace acus
