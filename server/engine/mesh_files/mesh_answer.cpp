// SPDX-License-Identifier: GPL-3.0-or-later
// Layout, in the machine's byte order, all counts as 64-bit numbers: kMagic, kind, and then
//   kMesh:  format; nodes n, tetrahedra t, groups g, notes m; 3n doubles; 4t 32-bit integers; g times array, name, 1
//   and
//           the number or 0 twice, count and members as 32-bit integers; m notes
//   kError: a text
// A text is its length and its bytes.
#include "server/engine/mesh_files/mesh_answer.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <string_view>

#include "server/engine/models/geometry/tetrahedral_mesh.h"

namespace acus {
namespace {

constexpr std::uint64_t kMagic = 0x3248'5345'4d41'4341;  // "ACAMESH2"; another layout has another number
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

std::string shortened(const std::string& text) { return text.substr(0, kMaxAnswerText); }

bool all_within(const std::vector<std::int32_t>& values, std::int32_t most) {
  return std::all_of(values.begin(), values.end(), [most](std::int32_t value) { return value >= 0 && value <= most; });
}

// Bytes of the character in UTF-8 that begins here; 0 where there is none, or a control character.
std::size_t character_size(std::string_view text) {
  const auto at = [&text](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char first = at(0);
  if (first < 0x80) return first < ' ' || first == 0x7f ? 0 : 1;
  const std::size_t size = first >= 0xf0 ? 4 : first >= 0xe0 ? 3 : 2;
  if (first < 0xc2 || first > 0xf4 || size > text.size()) return 0;
  for (std::size_t i = 1; i < size; ++i)
    if ((at(i) & 0xc0) != 0x80) return 0;
  const bool overlong = (first == 0xe0 && at(1) < 0xa0) || (first == 0xf0 && at(1) < 0x90);
  const bool surrogate = first == 0xed && at(1) > 0x9f, beyond = first == 0xf4 && at(1) > 0x8f;
  const bool control = first == 0xc2 && at(1) < 0xa0;
  return overlong || surrogate || beyond || control ? 0 : size;
}

// Terminals and clients show these texts, which may repeat bytes of a damaged file.
std::string printable(const std::string& text) {
  std::string shown;
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t size = character_size(std::string_view(text).substr(i));
    shown += size == 0 ? "?" : text.substr(i, size);
    i += std::max<std::size_t>(size, 1);
  }
  return shown;
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
}

MeshGroup read_group(Cursor& cursor, std::uint64_t tetrahedra) {
  MeshGroup group;
  group.array = printable(cursor.text(kMaxAnswerText));
  group.name = printable(cursor.text(kMaxAnswerText));
  const bool numbered = cursor.count("as the mark of a number", 1) == 1;
  const auto number = static_cast<std::int64_t>(cursor.number());
  if (numbered) group.number = number;
  group.members = cursor.numbers<std::int32_t>(cursor.count("members of a group", tetrahedra));
  if (group.members.empty()) refuse("a group is empty");
  if (!all_within(group.members, static_cast<std::int32_t>(tetrahedra) - 1) ||
      std::adjacent_find(group.members.begin(), group.members.end(), std::greater_equal<>()) != group.members.end())
    refuse("the members of a group are no ascending numbers of tetrahedra");
  return group;
}

RawMesh read_mesh(Cursor& cursor) {
  RawMesh mesh;
  mesh.format = printable(cursor.text(kMaxAnswerText));
  const std::uint64_t nodes = cursor.count("nodes", kMaxMeshNodes);
  const std::uint64_t tetrahedra = cursor.count("tetrahedra", kMaxMeshTetrahedra);
  const std::uint64_t groups = cursor.count("groups", kMaxGroups);
  const std::uint64_t notes = cursor.count("notes", kMaxNotes);
  if (nodes == 0 || tetrahedra == 0) refuse("it holds no tetrahedra");
  mesh.coordinates = cursor.numbers<double>(3 * nodes);
  mesh.tetrahedra = cursor.numbers<std::int32_t>(4 * tetrahedra);
  check_numbers(mesh);
  for (std::uint64_t i = 0; i < groups; ++i) mesh.groups.push_back(read_group(cursor, tetrahedra));
  for (std::uint64_t i = 0; i < notes; ++i) mesh.notes.push_back(printable(cursor.text(kMaxAnswerText)));
  cursor.expect_end();
  return mesh;
}

}  // namespace

std::vector<char> encode_mesh(const RawMesh& mesh) {
  check_limit("nodes", kMaxMeshNodes, mesh.coordinates.size() / 3);
  check_limit("tetrahedra", kMaxMeshTetrahedra, mesh.tetrahedra.size() / 4);
  check_limit("groups", kMaxGroups, mesh.groups.size());
  std::uint64_t members = 0;
  for (const MeshGroup& group : mesh.groups) members += group.members.size();
  check_limit("members of groups", kMaxGroupMembers, members);
  const std::size_t notes = std::min<std::size_t>(mesh.notes.size(), kMaxNotes);
  Writer writer;
  writer.put(kMagic);
  writer.put(kMesh);
  writer.put(shortened(mesh.format));
  writer.put(mesh.coordinates.size() / 3);
  writer.put(mesh.tetrahedra.size() / 4);
  writer.put(mesh.groups.size());
  writer.put(notes);
  writer.put_all(mesh.coordinates);
  writer.put_all(mesh.tetrahedra);
  for (const MeshGroup& group : mesh.groups) {
    for (const std::string& text : {group.array, group.name}) writer.put(shortened(text));
    writer.put(std::uint64_t{group.number.has_value()});
    writer.put(static_cast<std::uint64_t>(group.number.value_or(0)));
    writer.put(group.members.size());
    writer.put_all(group.members);
  }
  for (std::size_t i = 0; i < notes; ++i) writer.put(shortened(mesh.notes[i]));
  return writer.take();
}

std::vector<char> encode_mesh_error(const std::string& what) {
  Writer writer;
  writer.put(kMagic);
  writer.put(kError);
  writer.put(shortened(what));
  return writer.take();
}

RawMesh decode_mesh_answer(std::span<const char> bytes) {
  Cursor cursor(bytes);
  if (bytes.empty()) refuse("it is empty");
  if (cursor.number() != kMagic) refuse("it does not begin as one");
  const std::uint64_t kind = cursor.number();
  if (kind == kMesh) return read_mesh(cursor);
  if (kind != kError) refuse("it is neither a mesh nor an error");
  const std::string what = cursor.text(kMaxAnswerText);
  cursor.expect_end();
  throw MeshError(printable(what));
}

}  // namespace acus
