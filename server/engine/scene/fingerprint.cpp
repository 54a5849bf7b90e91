// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/scene/fingerprint.h"

#include <string_view>

#include "server/engine/math/hasher.h"
#include "server/engine/scene/scene_fields.h"

namespace acus {

namespace {

class SceneHasher {
 public:
  void add_bytes(const void* data, std::size_t count) { hasher_.bytes(data, count); }
  void add(double number) { add_bytes(&number, sizeof number); }
  void add(std::string_view text) {
    add(static_cast<double>(text.size()));
    add_bytes(text.data(), text.size());
  }
  void add(const char* text) { add(std::string_view(text)); }
  void add(const Vector3& v) { add_bytes(v.data(), 3 * sizeof(double)); }
  void add(const Quaternion& q) { add_bytes(q.coeffs().data(), 4 * sizeof(double)); }
  void add(const std::array<int, 3>& numbers) {
    for (const int number : numbers) add(static_cast<double>(number));
  }
  template <class Number>
    requires std::is_arithmetic_v<Number> || std::is_enum_v<Number>
  void add(Number number) {
    add(static_cast<double>(number));
  }
  template <class T>
  void add(const std::optional<T>& value) {
    add(value.has_value());
    if (value) add(*value);
  }
  template <class T>
  void add(const std::vector<T>& list) {
    add(list.size());
    for (const T& item : list) add(item);
  }
  // Where a mesh file lies does not matter, its nodes and elements do.
  void add(const GmshMesh&) {}
  template <HasFields T>
  void add(const T& value) {
    add_fields(FieldsOf<T>::list, value);
  }

  std::uint64_t digest() const { return hasher_.digest(); }

 private:
  template <class Tuple, class Struct>
  void add_fields(const Tuple& fields, const Struct& value) {
    for_each_entry(fields, [&]<class Entry>(const Entry& entry) {
      if (changes_no_tick<Struct>(entry.name)) return;
      add(entry.name);
      if constexpr (is_choice<Entry>)
        add_fields(entry.alternatives, value);
      else
        add(value.*(entry.member));
    });
  }

  template <class Struct>
  static bool changes_no_tick(std::string_view name) {
    if constexpr (std::is_same_v<Struct, Scene>) return name == "name" || name == "publish" || name == "clients";
    if constexpr (std::is_same_v<Struct, Tissue>) return name == "window_thread";
    if constexpr (std::is_same_v<Struct, Region>) return name == "colour";
    return false;
  }

  Hasher hasher_;
};

}  // namespace

std::uint64_t fingerprint(const Scene& scene, const TetrahedralMesh& mesh, std::span<const int> regions) {
  SceneHasher hasher;
  hasher.add(scene);
  hasher.add_bytes(mesh.nodes.data(), static_cast<std::size_t>(mesh.nodes.size()) * sizeof(double));
  for (const auto& tetrahedron : mesh.tetrahedra) hasher.add_bytes(tetrahedron.data(), sizeof tetrahedron);
  for (const int region : regions) hasher.add(region);
  return hasher.digest();
}

}  // namespace acus
