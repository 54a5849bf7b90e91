// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/scene/scene_reference.h"

#include <algorithm>
#include <cmath>

#include "server/scene/json_text.h"
#include "server/scene/scene_fields.h"

namespace acus {
namespace {

template <class T>
constexpr bool is_vector = std::is_same_v<T, Vector3> || std::is_same_v<T, std::array<int, 3>>;

std::vector<std::string> components(const Vector3& v) {
  return {format_number(v.x()), format_number(v.y()), format_number(v.z())};
}

std::vector<std::string> components(const std::array<int, 3>& v) {
  return {std::to_string(v[0]), std::to_string(v[1]), std::to_string(v[2])};
}

std::vector<std::string> components(const Quaternion& q) {
  return {format_number(q.w()), format_number(q.x()), format_number(q.y()), format_number(q.z())};
}

// A leaf's value as JSON, which is also YAML but for infinities.
template <class Value>
std::string value_text(const Value& value) {
  if constexpr (std::is_arithmetic_v<Value>) {
    return format_number(static_cast<double>(value));
  } else if constexpr (std::is_enum_v<Value>) {
    return acus::name_of(value);
  } else if constexpr (std::is_same_v<Value, std::string>) {
    return value;
  } else {
    return json_array(components(value));
  }
}

template <class Value>
bool is_finite(const Value& value) {
  if constexpr (std::is_same_v<Value, Vector3>) {
    return value.allFinite();
  } else {
    return true;
  }
}

// A field that has no usable default must be given.
template <class Value>
bool is_required(const Value& value, const Range& range) {
  if constexpr (std::is_same_v<Value, std::string>) {
    return !range.contains(static_cast<double>(value.size()));
  } else {
    return false;
  }
}

std::string description(const char* meaning, const std::string& unit) {
  return json_string(unit.empty() ? meaning : std::string(meaning) + " (" + unit + ")");
}

// JSON has no infinity to name beside a bound, so a side on which infinity is allowed has no bound in the schema.
JsonMembers number_schema(const Range& range, bool whole) {
  JsonMembers members{{"type", json_string(whole ? "integer" : "number")}};
  const bool below = range.infinity_allowed && range.min < 0;
  if (std::isfinite(range.min) && !below) members.emplace_back("minimum", format_number(range.min));
  if (std::isfinite(range.max) && !range.infinity_allowed) members.emplace_back("maximum", format_number(range.max));
  return members;
}

JsonMembers array_schema(const JsonMembers& items, std::size_t length) {
  return {{"type", json_string("array")},
          {"items", json_object(items)},
          {"minItems", std::to_string(length)},
          {"maxItems", std::to_string(length)}};
}

JsonMembers text_schema(const Range& range) {
  return {{"type", json_string("string")},
          {"minLength", format_number(range.min)},
          {"maxLength", format_number(range.max)}};
}

template <class Value>
JsonMembers leaf_schema(const Range& range) {
  if constexpr (std::is_same_v<Value, std::string>) {
    return text_schema(range);
  } else if constexpr (std::is_arithmetic_v<Value>) {
    return number_schema(range, std::is_integral_v<Value>);
  } else if constexpr (std::is_same_v<Value, Quaternion>) {
    return array_schema(number_schema(range, false), 4);
  } else if constexpr (is_vector<Value>) {
    return array_schema(number_schema(range, std::is_same_v<Value, std::array<int, 3>>), 3);
  } else {
    std::vector<std::string> names;
    for (const char* name : NamesOf<Value>::names) names.push_back(json_string(name));
    return {{"enum", json_array(names)}};
  }
}

JsonMembers object_schema(const JsonMembers& properties, const std::vector<std::string>& required) {
  JsonMembers members{
      {"type", json_string("object")}, {"additionalProperties", "false"}, {"properties", json_object(properties)}};
  if (!required.empty()) members.emplace_back("required", json_array(required));
  return members;
}

template <class Value>
JsonMembers value_schema(const Value& value, const Range& range);

// Schema of a map with these fields after the given properties.
template <class Tuple, class Struct>
JsonMembers fields_schema(const Tuple& fields, const Struct& defaults, JsonMembers properties = {},
                          std::vector<std::string> required = {}) {
  for_each_entry(fields, [&]<class Entry>(const Entry& entry) {
    JsonMembers members;
    if constexpr (is_choice<Entry>) {
      members = fields_schema(entry.alternatives, defaults);
      members.emplace_back("minProperties", "1");
      members.emplace_back("maxProperties", "1");
      members.emplace_back("description", json_string(entry.meaning));
    } else {
      const auto& value = defaults.*(entry.member);
      members = value_schema(value, entry.range);
      members.emplace_back("description", description(entry.meaning, entry.unit));
      if (is_required(value, entry.range)) required.push_back(json_string(entry.name));
    }
    properties.emplace_back(entry.name, json_object(members));
  });
  return object_schema(properties, required);
}

template <class Value>
JsonMembers list_schema(const Range& range) {
  return {{"type", json_string("array")},
          {"items", json_object(value_schema(Value{}, range))},
          {"minItems", format_number(range.min)},
          {"maxItems", format_number(range.max)}};
}

template <class Value>
JsonMembers list_schema_of(const std::vector<Value>&, const Range& range) {
  return list_schema<Value>(range);
}

// Schema of a field without its description; `value` is its default.
template <class Value>
JsonMembers value_schema(const Value& value, const Range& range) {
  if constexpr (HasFields<Value>) {
    return fields_schema(FieldsOf<Value>::list, value);
  } else if constexpr (is_list<Value>) {
    return list_schema_of(value, range);
  } else if constexpr (std::is_same_v<Value, std::optional<std::string>>) {
    return {{"type", json_array({json_string("string"), json_string("integer")})}};
  } else if constexpr (is_optional<Value>) {
    using Inner = typename Value::value_type;
    if constexpr (HasFields<Inner>) {
      return value_schema(Inner{}, range);
    } else {
      return leaf_schema<Inner>(range);
    }
  } else {
    JsonMembers members = leaf_schema<Value>(range);
    const std::string text = value_text(value);
    const bool is_text = std::is_enum_v<Value> || std::is_same_v<Value, std::string>;
    if (is_finite(value) && !is_required(value, range))
      members.emplace_back("default", is_text ? json_string(text) : text);
    return members;
  }
}

std::string link(const std::string& title) {
  std::string anchor = title;
  std::erase(anchor, '.');
  return "[" + title + "](#" + anchor + ")";
}

// The fields of a nested map whose defaults differ from the ones in its own table.
template <class Struct>
std::string differing_defaults(const Struct& value) {
  const Struct usual{};
  std::string text;
  for_each_entry(FieldsOf<Struct>::list, [&]<class Entry>(const Entry& entry) {
    if constexpr (!is_choice<Entry>) {
      using Value = std::remove_cvref_t<decltype(value.*(entry.member))>;
      if constexpr (std::is_arithmetic_v<Value>) {
        if (value.*(entry.member) == usual.*(entry.member)) return;
        text += "; " + std::string(entry.name) + " " + value_text(value.*(entry.member));
      }
    }
  });
  return text;
}

template <class Value>
std::string default_cell(const Value& value, const Range& range) {
  if constexpr (HasFields<Value>) {
    return "see " + link(FieldsOf<Value>::title) + differing_defaults(value);
  } else if constexpr (is_list<Value>) {
    return value.empty() ? "none" : "one with all defaults";
  } else if constexpr (is_optional<Value>) {
    if constexpr (HasFields<typename Value::value_type>) {
      return "none; see " + link(FieldsOf<typename Value::value_type>::title);
    } else {
      return "none";
    }
  } else {
    return is_required(value, range) ? "required" : "`" + value_text(value) + "`";
  }
}

template <class Value>
constexpr bool is_bounded_number = std::is_arithmetic_v<Value> || is_vector<Value>;
template <class Value>
constexpr bool is_bounded_number<std::optional<Value>> = is_bounded_number<Value>;

template <class Value>
std::string range_cell(const Range& range) {
  if constexpr (is_bounded_number<Value>) {
    return describe(range);
  } else if constexpr (std::is_same_v<Value, Quaternion>) {
    return "length 1 within " + format_number(kUnitTolerance);
  } else if constexpr (std::is_enum_v<Value>) {
    std::string names;
    for (const char* name : NamesOf<Value>::names) names += (names.empty() ? "" : ", ") + std::string(name);
    return names;
  } else if constexpr (is_list<Value>) {
    return format_number(range.min) + " to " + format_number(range.max) + " entries";
  } else if constexpr (std::is_same_v<Value, std::string> || std::is_same_v<Value, std::optional<std::string>>) {
    return format_number(range.min) + " to " + format_number(range.max) + " characters";
  } else {
    return "";
  }
}

template <class Tuple, class Struct>
std::string rows(const Tuple& fields, const std::string& prefix, const Struct& defaults) {
  std::string text;
  for_each_entry(fields, [&]<class Entry>(const Entry& entry) {
    if constexpr (is_choice<Entry>) {
      text += rows(entry.alternatives, prefix + entry.name + ".", defaults);
    } else {
      const auto& value = defaults.*(entry.member);
      using Value = std::remove_cvref_t<decltype(value)>;
      text += "| `" + prefix + entry.name + "` | " + entry.unit + " | " + default_cell(value, entry.range) + " | " +
              range_cell<Value>(entry.range) + " | " + entry.meaning + " |\n";
    }
  });
  return text;
}

template <class Struct>
FieldTable table() {
  return {FieldsOf<Struct>::title, "| field | unit | default | range | meaning |\n|---|---|---|---|---|\n" +
                                       rows(FieldsOf<Struct>::list, "", Struct{})};
}

}  // namespace

std::string scene_schema() {
  const std::string version = json_object(
      {{"const", std::to_string(kSceneVersion)}, {"description", json_string("version of the scene format")}});
  JsonMembers root{{"$schema", json_string("http://json-schema.org/draft-07/schema#")},
                   {"title", json_string("Acus scene")}};
  const JsonMembers body =
      fields_schema(FieldsOf<Scene>::list, Scene{}, {{kVersionField, version}}, {json_string(kVersionField)});
  root.insert(root.end(), body.begin(), body.end());
  return indent_json(json_object(root));
}

std::vector<FieldTable> scene_tables() {
  return {table<Scene>(),     table<Tissue>(),      table<BoxMesh>(),   table<GmshMesh>(),  table<Region>(),
          table<Material>(),  table<Interaction>(), table<Volume>(),    table<Box>(),       table<Sphere>(),
          table<HalfSpace>(), table<Cylinder>(),    table<Pose>(),      table<Interface>(), table<Needle>(),
          table<Guide>(),     table<Newton>(),      table<LawSolver>(), table<Overrun>(),   table<Publishing>()};
}

}  // namespace acus
