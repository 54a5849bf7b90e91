// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/scene/scene_reference.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "server/engine/scene/scene_fields.h"

namespace acus {
namespace {

using Json = nlohmann::ordered_json;

template <class T>
constexpr bool is_vector = std::is_same_v<T, Vector3> || std::is_same_v<T, std::array<int, 3>>;

// Whole numbers without a decimal point.
Json json_number(double value) {
  constexpr double kExact = 1e15;
  if (value == std::round(value) && std::abs(value) < kExact) return static_cast<std::int64_t>(value);
  return value;
}

Json json_value(double value) { return json_number(value); }
Json json_value(const std::string& text) { return text; }
Json json_value(const Vector3& v) { return {json_number(v.x()), json_number(v.y()), json_number(v.z())}; }
Json json_value(const std::array<int, 3>& v) { return v; }
Json json_value(const Quaternion& q) {
  return {json_number(q.w()), json_number(q.x()), json_number(q.y()), json_number(q.z())};
}

// A leaf's value as JSON.
template <class Value>
Json leaf_json(const Value& value) {
  if constexpr (std::is_enum_v<Value>) {
    return acus::name_of(value);
  } else if constexpr (std::is_same_v<Value, bool>) {
    return value;
  } else if constexpr (std::is_arithmetic_v<Value>) {
    return json_value(static_cast<double>(value));
  } else {
    return json_value(value);
  }
}

// A leaf's value as a table shows it: in YAML.
template <class Value>
std::string value_text(const Value& value) {
  if constexpr (std::is_same_v<Value, bool>) {
    return value ? "true" : "false";
  } else if constexpr (std::is_arithmetic_v<Value>) {
    return format_number(static_cast<double>(value));
  } else if constexpr (std::is_enum_v<Value>) {
    return acus::name_of(value);
  } else if constexpr (std::is_same_v<Value, std::string>) {
    return value;
  } else {
    std::string text;
    for (const Json& component : json_value(value))
      text += (text.empty() ? "[" : ", ") + format_number(component.get<double>());
    return text + "]";
  }
}

template <class Value>
bool is_finite(const Value& value) {
  if constexpr (std::is_same_v<Value, Vector3>) {
    return value.allFinite();
  } else if constexpr (std::is_floating_point_v<Value>) {
    return std::isfinite(value);
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
  return unit.empty() ? meaning : std::string(meaning) + " (" + unit + ")";
}

// JSON has no infinity to name beside a bound, so a side on which infinity is allowed has no bound in the schema.
Json number_schema(const Range& range, bool whole) {
  Json schema{{"type", whole ? "integer" : "number"}};
  const bool below = range.infinity_allowed && range.min < 0;
  if (std::isfinite(range.min) && !below) schema["minimum"] = json_number(range.min);
  if (std::isfinite(range.max) && !range.infinity_allowed) schema["maximum"] = json_number(range.max);
  return schema;
}

Json array_schema(const Json& items, std::size_t length) {
  return {{"type", "array"}, {"items", items}, {"minItems", length}, {"maxItems", length}};
}

Json text_schema(const Range& range) {
  return {{"type", "string"}, {"minLength", json_number(range.min)}, {"maxLength", json_number(range.max)}};
}

template <class Value>
Json leaf_schema(const Range& range) {
  if constexpr (std::is_same_v<Value, std::string>) {
    return text_schema(range);
  } else if constexpr (std::is_same_v<Value, bool>) {
    return {{"type", "boolean"}};
  } else if constexpr (std::is_arithmetic_v<Value>) {
    return number_schema(range, std::is_integral_v<Value>);
  } else if constexpr (std::is_same_v<Value, Quaternion>) {
    return array_schema(number_schema(range, false), 4);
  } else if constexpr (is_vector<Value>) {
    return array_schema(number_schema(range, std::is_same_v<Value, std::array<int, 3>>), 3);
  } else {
    return {{"enum", NamesOf<Value>::names}};
  }
}

template <class Value>
Json value_schema(const Value& value, const Range& range);

// Schema of a map with these fields after the given properties.
template <class Tuple, class Struct>
Json fields_schema(const Tuple& fields, const Struct& defaults, Json properties = Json::object(),
                   Json required = Json::array()) {
  for_each_entry(fields, [&]<class Entry>(const Entry& entry) {
    Json schema;
    if constexpr (is_choice<Entry>) {
      schema = fields_schema(entry.alternatives, defaults);
      schema["minProperties"] = 1;
      schema["maxProperties"] = 1;
      schema["description"] = entry.meaning;
    } else {
      const auto& value = defaults.*(entry.member);
      schema = value_schema(value, entry.range);
      schema["description"] = description(entry.meaning, entry.unit);
      if (is_required(value, entry.range)) required.push_back(entry.name);
    }
    properties[entry.name] = std::move(schema);
  });
  Json schema{{"type", "object"}, {"additionalProperties", false}, {"properties", std::move(properties)}};
  if (!required.empty()) schema["required"] = std::move(required);
  return schema;
}

template <class Value>
Json list_schema_of(const std::vector<Value>&, const Range& range) {
  return {{"type", "array"},
          {"items", value_schema(Value{}, range)},
          {"minItems", json_number(range.min)},
          {"maxItems", json_number(range.max)}};
}

// Schema of a field without its description; `value` is its default.
template <class Value>
Json value_schema(const Value& value, const Range& range) {
  if constexpr (HasFields<Value>) {
    return fields_schema(FieldsOf<Value>::list, value);
  } else if constexpr (is_list<Value>) {
    return list_schema_of(value, range);
  } else if constexpr (std::is_same_v<Value, std::optional<std::string>>) {
    return {{"type", {"string", "integer"}}};
  } else if constexpr (is_optional<Value>) {
    using Inner = typename Value::value_type;
    if constexpr (HasFields<Inner>) {
      return value_schema(Inner{}, range);
    } else {
      return leaf_schema<Inner>(range);
    }
  } else {
    Json schema = leaf_schema<Value>(range);
    if (is_finite(value) && !is_required(value, range)) schema["default"] = leaf_json(value);
    return schema;
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
  if constexpr (std::is_same_v<Value, bool>) {
    return "true, false";
  } else if constexpr (is_bounded_number<Value>) {
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
  const Json version{{"const", kSceneVersion}, {"description", "version of the scene format"}};
  Json root{{"$schema", "http://json-schema.org/draft-07/schema#"}, {"title", "Acus scene"}};
  Json properties = Json::object(), required = Json::array();
  properties[kVersionField] = version;
  required.push_back(kVersionField);
  root.update(fields_schema(FieldsOf<Scene>::list, Scene{}, std::move(properties), std::move(required)));
  return root.dump(2) + "\n";
}

std::vector<FieldTable> scene_tables() {
  return {table<Scene>(),
          table<Tissue>(),
          table<BoxMesh>(),
          table<GmshMesh>(),
          table<Region>(),
          table<Material>(),
          table<Interaction>(),
          table<Volume>(),
          table<Pressure>(),
          table<Box>(),
          table<Sphere>(),
          table<HalfSpace>(),
          table<Cylinder>(),
          table<Pose>(),
          table<Interface>(),
          table<Needle>(),
          table<BaseHold>(),
          table<Guide>(),
          table<NeedleContactSettings>(),
          table<Newton>(),
          table<LawSettings>(),
          table<Overrun>(),
          table<Publishing>(),
          table<Clients>()};
}

}  // namespace acus
