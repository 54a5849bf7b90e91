// SPDX-License-Identifier: GPL-3.0-or-later
// The schema and the reference tables say what the reader does: as files they are what the field lists write, and what
// the schema says is tried out on the reader, field by field.
#include <doctest/doctest.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include "server/engine/scene/scene_fields.h"
#include "server/engine/scene/scene_json.h"
#include "server/engine/scene/scene_reference.h"
#include "tests/support/file_content.h"
#include "tests/support/places.h"
#include "tests/support/temporary_folder.h"

namespace acus {
namespace {

std::string read_text(const std::string& path) {
  const std::string text = content_of(source_path(path));
  REQUIRE(!text.empty());
  return text;
}

// A field of the schema: the path to it as in messages, and how to write a scene that gives it one value.
struct SchemaField {
  std::string path;
  YAML::Node schema;
  std::function<std::string(const std::string&)> scene;
};

// What must stand beside a field so that its whole range is allowed.
std::string companion_of(const std::string& parent, const std::string& name) {
  if (name == "metres_per_unit") return "file: a.msh, ";
  if (name == "curvature") return "length: 0.001, beams: 1000, ";
  if (name == "curved_length") return "length: 10, ";
  if (name == "constraint_spacing") return "length: 1e-4, ";
  if (name == "inner_diameter") return "outer_diameter: 1, ";
  if (name == "friction_static") return "friction_dynamic: 0, ";
  if (name == "window_thread") return "window: 16, ";
  if (parent == "tissue.pressures[0]" && name == "pressure") return "box: {}, ";
  if (name == "point_side") return "tip: bevel, ";
  if (name == "point_offset") return "tip: bevel, point_side: [0, 1, 0], ";
  if (name == "interfaces") return "regions: [{name: a}, {name: b}], ";
  if (parent != "tissue.interfaces[0]") return "";
  if (name == "between") return "and: a, ";
  return name == "and" ? "between: a, " : "between: a, and: b, ";
}

using Visit = std::function<void(const SchemaField&)>;

void walk(const SchemaField& field, const Visit& visit);

void walk_properties(const SchemaField& field, const Visit& visit) {
  for (const auto& property : field.schema["properties"]) {
    const auto name = property.first.as<std::string>();
    if (name == "acus_scene") continue;
    const auto scene = [outer = field.scene, parent = field.path, name](const std::string& value) {
      return outer(
          std::string("{").append(companion_of(parent, name)).append(name).append(": ").append(value).append("}"));
    };
    walk({field.path.empty() ? name : field.path + "." + name, property.second, scene}, visit);
  }
}

void walk(const SchemaField& field, const Visit& visit) {
  visit(field);
  if (field.schema["properties"]) walk_properties(field, visit);
  const YAML::Node items = field.schema["items"];
  if (items && items["type"].as<std::string>() == "object") {
    walk({field.path + "[0]", items,
          [outer = field.scene](const std::string& value) { return outer("[" + value + "]"); }},
         visit);
  }
}

class SchemaOnReader {
 public:
  SchemaOnReader() { folder_.write("a.msh", "$MeshFormat"); }

  void for_each_field(const Visit& visit) const {
    const auto scene = [](const std::string& value) {
      return "{acus_scene: 1" + (value == "{}" ? "" : ", " + value.substr(1, value.size() - 2)) + "}";
    };
    const auto of_tissue = [&](const SchemaField& field) {  // needles share its fields, but do not relax
      if (!field.path.starts_with("needles[0].material.relaxation")) visit(field);
    };
    walk_properties({"", YAML::Load(scene_schema()), scene}, of_tissue);
  }

  std::string error_of(const std::string& text) const {
    try {
      parse_scene(text, "s", folder_.path());
    } catch (const SceneError& error) {
      return error.what();
    }
    return "";
  }

  // Whether a value is refused with a message about its field.
  bool refuses(const SchemaField& field, const std::string& value) const {
    return error_of(field.scene(value)).find(": " + field.path) != std::string::npos;
  }

 private:
  TemporaryFolder folder_;
};

// The number as a scalar, or in place of each component of a list.
std::string as_value(const SchemaField& field, const std::string& number) {
  if (!field.schema["items"]) return number;
  // A tip cuts forwards, and a box has no more cells in all than along an edge.
  const auto keeps_one = [&](int i) {
    return field.path.ends_with("cutting_direction") ? i == 0 : field.path.ends_with("cells") && i > 0;
  };
  std::string list;
  for (int i = 0; i < field.schema["minItems"].as<int>(); ++i)
    list += (i == 0 ? "[" : ", ") + (keeps_one(i) ? "1" : number);
  return list + "]";
}

// The schema that bounds the field's numbers, if it has some.
YAML::Node number_schema(const SchemaField& field) {
  const YAML::Node schema = field.schema["items"] ? field.schema["items"] : field.schema;
  const bool is_number =
      schema["type"] && schema["type"].IsScalar() &&
      (schema["type"].as<std::string>() == "number" || schema["type"].as<std::string>() == "integer");
  return is_number ? schema : YAML::Node(YAML::NodeType::Map);
}

// The texts between "```yaml" and "```".
std::vector<std::string> readme_examples() {
  const std::string readme = read_text("scenes/README.md");
  const std::string opening = "```yaml\n";
  std::vector<std::string> examples;
  for (std::size_t at = readme.find(opening); at != std::string::npos; at = readme.find(opening, at + 1)) {
    const std::size_t start = at + opening.size();
    examples.push_back(readme.substr(start, readme.find("```", start) - start));
  }
  return examples;
}

std::string plus(const YAML::Node& number, double offset) { return format_number(number.as<double>() + offset); }

// Calls visit(path, range) for every number, or vector of numbers, of a struct and the structs in it.
template <class Value, class VisitRange>
void for_each_number(const std::string& path, const Range& range, const VisitRange& visit);

template <class Tuple, class Struct, class VisitRange>
void for_each_number_of(const Tuple& fields, const std::string& path, const VisitRange& visit) {
  for_each_entry(fields, [&]<class Entry>(const Entry& entry) {
    if constexpr (is_choice<Entry>) {
      for_each_number_of<decltype(entry.alternatives), Struct>(entry.alternatives, path + "." + entry.name, visit);
    } else {
      using Value = std::remove_cvref_t<decltype(std::declval<Struct>().*(entry.member))>;
      for_each_number<Value>(path + "." + entry.name, entry.range, visit);
    }
  });
}

template <class Value, class VisitRange>
void for_each_number(const std::string& path, const Range& range, const VisitRange& visit) {
  if constexpr (HasFields<Value>) {
    for_each_number_of<decltype(FieldsOf<Value>::list), Value>(FieldsOf<Value>::list, path, visit);
  } else if constexpr (is_list<Value> || is_optional<Value>) {
    for_each_number<typename Value::value_type>(path, range, visit);
  } else if constexpr ((std::is_arithmetic_v<Value> && !std::is_same_v<Value, bool>) ||
                       std::is_same_v<Value, Vector3> || std::is_same_v<Value, std::array<int, 3>>) {
    visit(path, range);
  }
}

}  // namespace

TEST_CASE("every number has a finite range, beside which only a few may be infinite") {
  int numbers = 0;
  std::vector<std::string> infinite;
  for_each_number<Scene>("", any(), [&](const std::string& path, const Range& range) {
    CAPTURE(path);
    CHECK(std::isfinite(range.min));
    CHECK(std::isfinite(range.max));
    CHECK(range.min < range.max);
    CHECK(range.contains(range.min));
    CHECK(range.contains(range.max));
    CHECK_FALSE(range.contains(std::nextafter(range.max, 2 * range.max)));
    CHECK_FALSE(range.contains(std::numeric_limits<double>::quiet_NaN()));
    CHECK(range.contains(kInfinity) == range.infinity_allowed);
    CHECK(range.contains(-kInfinity) == (range.infinity_allowed && range.min < 0));
    const std::string name = path.substr(path.rfind('.') + 1);
    if (range.infinity_allowed && std::find(infinite.begin(), infinite.end(), name) == infinite.end())
      infinite.push_back(name);
    ++numbers;
  });
  CHECK(numbers > 60);
  std::sort(infinite.begin(), infinite.end());
  CHECK(infinite == std::vector<std::string>{"foundation_stiffness", "max", "min", "puncture_force", "stale_after",
                                             "tear_strength"});
}

TEST_CASE("scenes/scene.schema.json is up to date (acus-server --schema > scenes/scene.schema.json)") {
  CHECK(read_text("scenes/scene.schema.json") == scene_schema());
}

TEST_CASE("docs/scene-fields.md holds every table (acus-server --tables)") {
  const std::string page = read_text("docs/scene-fields.md");
  for (const FieldTable& table : scene_tables()) {
    CAPTURE(table.markdown);
    CHECK(page.find("### " + table.title + "\n\n" + table.markdown) != std::string::npos);
  }
}

TEST_CASE("a scene as JSON holds the fields of its text, infinities and quoted numbers among them") {
  const Scene scene = parse_scene(
      "acus_scene: 1\nname: '12'\nrate: 10e2\nlaws: {solver: direct}\n"
      "tissue: {fixed: [{box: {max: [.inf, -.inf, -0.05]}}], regions: [{name: \"a \\\"b\\\"\"}]}\n",
      "test");
  CHECK(scene_as_json(scene) ==
        "{\"acus_scene\": 1, \"name\": \"12\", \"rate\": 1000, \"laws\": {\"solver\": \"direct\"}, \"tissue\": {\"fixed\": "
        "[{\"box\": {\"max\": [1e999, -1e999, -0.05]}}], \"regions\": [{\"name\": \"a \\\"b\\\"\"}]}}");
}

TEST_CASE("the complete examples of scenes/README.md are scenes") {
  int count = 0;
  for (const std::string& example : readme_examples()) {
    if (!example.starts_with("acus_scene")) continue;
    CAPTURE(example);
    const Scene scene = parse_scene(example, "README.md", "");
    const TetrahedralMesh mesh = load_mesh(scene);
    CHECK_NOTHROW(assign_regions(scene, mesh));
    CHECK_NOTHROW(find_fixed_nodes(scene, mesh));
    ++count;
  }
  CHECK(count == 18);
}

TEST_CASE("every field stands in an example of scenes/README.md") {
  std::string examples;
  for (const std::string& example : readme_examples()) examples += example;
  SchemaOnReader().for_each_field([&](const SchemaField& field) {
    if (field.path.ends_with(']')) return;  // an entry of a list
    CAPTURE(field.path);
    CHECK(examples.find(field.path.substr(field.path.rfind('.') + 1) + ":") != std::string::npos);
  });
}

TEST_CASE("the reader takes every default of the schema") {
  const SchemaOnReader reader;
  int count = 0;
  reader.for_each_field([&](const SchemaField& field) {
    if (!field.schema["default"]) return;
    YAML::Emitter value;
    value << YAML::Flow << field.schema["default"];
    CAPTURE(field.path);
    CHECK(reader.error_of(field.scene(value.c_str())) == "");
    ++count;
  });
  CHECK(count > 40);
}

TEST_CASE("the reader refuses what is outside the schema's ranges and takes what is just inside") {
  const SchemaOnReader reader;
  reader.for_each_field([&](const SchemaField& field) {
    const YAML::Node numbers = number_schema(field);
    const auto refuses = [&](const std::string& number) { return reader.refuses(field, as_value(field, number)); };
    CAPTURE(field.path);
    if (numbers["minimum"]) {
      CHECK(refuses(plus(numbers["minimum"], -0.5)));
      CHECK(refuses(plus(numbers["minimum"], -1)));
      CHECK_FALSE(refuses(plus(numbers["minimum"], 0)));
    }
    if (numbers["maximum"]) {
      CHECK(refuses(plus(numbers["maximum"], 1)));
      CHECK_FALSE(refuses(plus(numbers["maximum"], 0)));
    }
  });
}

TEST_CASE("the reader refuses a wrong type and an unknown name in every field of the schema") {
  const SchemaOnReader reader;
  reader.for_each_field([&](const SchemaField& field) {
    CAPTURE(field.path);
    CHECK(reader.refuses(field, "[[]]"));
    if (field.schema["properties"]) {
      CHECK(reader.refuses(field, "word"));
      CHECK(reader.error_of(field.scene("{zzz: 1}")).find(field.path + ".zzz: unknown field") != std::string::npos);
    } else {
      CHECK(reader.refuses(field, "{}"));
    }
  });
}

}  // namespace acus
