// SPDX-License-Identifier: GPL-3.0-or-later
// From YAML to Scene: structure and types. Ranges are validate()'s.
#include <unistd.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numeric>
#include <regex>
#include <sstream>

#include "server/engine/scene/field_error.h"
#include "server/engine/scene/files/opened_file.h"
#include "server/engine/scene/files/scene_folders.h"
#include "server/engine/scene/scene_fields.h"
#include "server/engine/scene/scene_json.h"

namespace acus {
namespace {

// A scene of 64 needles and 1,000 regions stays below; what is above is no scene.
constexpr std::size_t kMaxFileSize = 4 << 20;  // bytes

// Number of single-character edits from a to b.
std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0]++;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, row[j] + 1, diagonal + 1});
    }
  }
  return row[b.size()];
}

// The known name that was probably meant, or a list of all.
std::string suggest(const std::string& unknown, const std::vector<std::string>& known) {
  const auto distance = [&unknown](const std::string& name) { return edit_distance(unknown.substr(0, 100), name); };
  const auto closer = [&](const std::string& a, const std::string& b) { return distance(a) < distance(b); };
  const auto nearest = std::min_element(known.begin(), known.end(), closer);
  if (distance(*nearest) <= std::max<std::size_t>(2, nearest->size() / 3)) return "did you mean \"" + *nearest + "\"?";
  std::string all;
  for (const std::string& name : known) all += (all.empty() ? "" : ", ") + name;
  return "known here: " + all;
}

// Numbers as YAML 1.2 writes them. Quoted ones are texts.
std::optional<double> parse_number(const YAML::Node& node) {
  if (!node.IsScalar() || node.Tag() == "!") return std::nullopt;
  std::string text = node.Scalar();
  const bool negative = text.starts_with('-');
  if (negative || text.starts_with('+')) text.erase(0, 1);
  if (text == ".inf" || text == ".Inf" || text == ".INF") return negative ? -kInfinity : kInfinity;
  if (text.empty() || (text[0] != '.' && (text[0] < '0' || text[0] > '9'))) return std::nullopt;  // "inf", "nan", "--1"
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return negative ? -value : value;
}

// A plain scalar that YAML takes for something else than a text.
bool is_plain_value(const YAML::Node& node) {
  if (node.Tag() == "!") return false;
  const std::string& text = node.Scalar();
  return parse_number(node) || text == "true" || text == "false";
}

// Without the value.
std::string describe_kind(const YAML::Node& node) {
  switch (node.Type()) {
    case YAML::NodeType::Map:
      return "found a map";
    case YAML::NodeType::Sequence:
      return "found a list of " + std::to_string(node.size());
    case YAML::NodeType::Scalar:
      return "found a text";
    default:
      return "found nothing";
  }
}

std::string describe_found(const YAML::Node& node) {
  if (!node.IsScalar()) return describe_kind(node);
  if (parse_number(node)) return "found " + node.Scalar();
  std::string text = node.Scalar().substr(0, 100);
  static const std::regex decimal_comma("[-+]?[0-9]+,[0-9]+([eE][-+]?[0-9]+)?");
  const bool comma = std::regex_match(text, decimal_comma);
  std::string found = "found \"" + text + "\"";
  if (!comma) return found;
  text[text.find(',')] = '.';
  return found + "; a decimal point, not a comma: " + text;
}

std::string version_line() { return "\"" + std::string(kVersionField) + ": " + std::to_string(kSceneVersion) + "\""; }

class Reader {
 public:
  explicit Reader(Scene& scene) : scene_(scene) {}

  void read_scene(const YAML::Node& root) {
    mark("", root.Mark());
    check_version(root);
    read_fields(FieldsOf<Scene>::list, root, "", scene_);
  }

 private:
  template <class Tuple, class Struct>
  void read_fields(const Tuple& fields, const YAML::Node& map, const std::string& path, Struct& value) {
    check_map(map, path);
    check_keys(map, path, names_of(fields, path));
    for_each_entry(fields, [&]<class Entry>(const Entry& entry) {
      const YAML::Node node = find(map, entry.name);
      if (!node.IsDefined()) return;
      const std::string field = child_path(path, entry.name);
      if constexpr (is_choice<Entry>) {
        read_choice(entry, node, field, value);
      } else {
        read_value(node, field, value.*(entry.member), entry.range);
      }
    });
  }

  template <class Entry, class Struct>
  void read_choice(const Entry& entry, const YAML::Node& node, const std::string& path, Struct& value) {
    read_fields(entry.alternatives, node, path, value);
    if (node.size() == 1) return;
    std::string names;
    for_each_entry(entry.alternatives,
                   [&names](const auto& field) { names += (names.empty() ? "" : " or ") + std::string(field.name); });
    fail(path, "expected exactly one of " + names + ", found " + std::to_string(node.size()));
  }

  template <class Value>
  void read_value(const YAML::Node& node, const std::string& path, Value& value, const Range& range) {
    if constexpr (HasFields<Value>) {
      read_fields(FieldsOf<Value>::list, node, path, value);
    } else if constexpr (is_optional<Value>) {
      value.emplace();
      read_optional(node, path, *value, range);
    } else if constexpr (is_list<Value>) {
      read_entries(node, path, value, range);
    } else if constexpr (std::is_same_v<Value, bool>) {
      read_bool(node, path, value);
    } else if constexpr (std::is_arithmetic_v<Value>) {
      read_number(node, path, value, range);
    } else if constexpr (std::is_enum_v<Value>) {
      read_enum(node, path, value);
    } else {
      read_leaf(node, path, value, range);
    }
  }

  // An optional text is a label, which may be a number.
  template <class Value>
  void read_optional(const YAML::Node& node, const std::string& path, Value& value, const Range& range) {
    if constexpr (std::is_same_v<Value, std::string>) {
      if (!node.IsScalar()) fail(path, "expected a name or a number, " + describe_found(node));
      value = node.Scalar();
    } else {
      read_value(node, path, value, range);
    }
  }

  template <class Value>
  void read_entries(const YAML::Node& node, const std::string& path, std::vector<Value>& list, const Range& range) {
    if (!node.IsSequence()) fail(path, "expected a list, " + describe_found(node));
    if (static_cast<double>(node.size()) > range.max) {
      fail(path, "expected a list of at most " + format_number(range.max) + " entries, " + describe_found(node));
    }
    list.clear();
    for (std::size_t i = 0; i < node.size(); ++i) {
      mark(child_path(path, i), node[i].Mark());
      read_value(node[i], child_path(path, i), list.emplace_back(), range);
    }
  }

  template <class Number>
  void read_number(const YAML::Node& node, const std::string& path, Number& value, const Range& range) {
    constexpr bool whole = std::is_integral_v<Number>;
    const std::optional<double> number = parse_number(node);
    const bool fits =
        number && (!whole || (std::abs(*number) <= std::numeric_limits<int>::max() && *number == std::trunc(*number)));
    if (!fits) {
      const std::string bounds = describe(range);
      fail(path, std::string("expected a ") + (whole ? "whole " : "") + "number" + (bounds.empty() ? "" : " ") +
                     bounds + ", " + describe_found(node));
    }
    value = static_cast<Number>(*number);
  }

  void read_bool(const YAML::Node& node, const std::string& path, bool& value) {
    const std::string text = node.IsScalar() && node.Tag() != "!" ? node.Scalar() : "";
    if (text != "true" && text != "false") fail(path, "expected true or false, " + describe_found(node));
    value = text == "true";
  }

  template <class Enum>
  void read_enum(const YAML::Node& node, const std::string& path, Enum& value) {
    const auto& names = NamesOf<Enum>::names;
    std::string all;
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (node.IsScalar() && node.Scalar() == names[i]) {
        value = static_cast<Enum>(i);
        return;
      }
      all += (i == 0 ? "" : i + 1 < names.size() ? ", " : " or ") + std::string(names[i]);
    }
    fail(path, "expected " + all + ", " + describe_found(node));
  }

  void read_leaf(const YAML::Node& node, const std::string& path, std::string& text, const Range&) {
    if (!node.IsScalar()) fail(path, "expected a text, " + describe_found(node));
    if (is_plain_value(node)) fail(path, "expected a text, found " + node.Scalar() + "; put it in quotes");
    text = node.Scalar();
  }

  void read_leaf(const YAML::Node& node, const std::string& path, Vector3& vector, const Range& range) {
    check_length(node, path, 3, "[x, y, z]");
    for (std::size_t i = 0; i < 3; ++i) read_component(node[i], child_path(path, i), vector[i], range);
  }

  void read_leaf(const YAML::Node& node, const std::string& path, std::array<int, 3>& vector, const Range& range) {
    check_length(node, path, 3, "[x, y, z]");
    for (std::size_t i = 0; i < 3; ++i) read_component(node[i], child_path(path, i), vector[i], range);
  }

  void read_leaf(const YAML::Node& node, const std::string& path, Quaternion& rotation, const Range& range) {
    check_length(node, path, 4, "[w, x, y, z]");
    std::array<double, 4> wxyz{};
    for (std::size_t i = 0; i < 4; ++i) read_component(node[i], child_path(path, i), wxyz[i], range);
    rotation = Quaternion(wxyz[0], wxyz[1], wxyz[2], wxyz[3]);
    // What is far from unit stays as it is, for validate() to find.
    if (std::abs(rotation.norm() - 1) <= kUnitTolerance) rotation.normalize();
  }

  template <class Number>
  void read_component(const YAML::Node& node, const std::string& path, Number& value, const Range& range) {
    mark(path, node.Mark());
    read_number(node, path, value, range);
  }

  void check_map(const YAML::Node& node, const std::string& path) const {
    if (!node.IsMap()) fail(path, "expected fields \"name: value\", " + describe_found(node));
  }

  void check_length(const YAML::Node& node, const std::string& path, std::size_t length, const char* form) const {
    if (node.IsSequence() && node.size() == length) return;
    std::string remedy;
    if (node.IsSequence() && node.size() > length) remedy = "; numbers have a decimal point, not a comma";
    if (length == 4 && node.IsSequence() && node.size() == 3 &&
        std::any_of(node.begin(), node.end(), [](const YAML::Node& each) { return std::abs(parse_number(each).value_or(0)) > 1; }))
      remedy = "; angles are no quaternion: [0.7071, 0, 0.7071, 0] turns by 90 degrees about y, and points down";
    fail(path, "expected " + std::to_string(length) + " numbers " + form + ", " + describe_found(node) + remedy);
  }

  // Between braces a decimal comma ends the field, and its digits are the name of the next one, which has no value.
  static std::string decimal_comma(const YAML::Node& before, const YAML::Node& key, const YAML::Node& value) {
    if (!value.IsNull() || !key.IsScalar() || !parse_number(key) || !before.IsScalar() || !parse_number(before)) return "";
    return "; a decimal point, not a comma: " + before.Scalar() + "." + key.Scalar();
  }

  // Of what has no version this says nothing but the kind: it may be any file (see has_version_line).
  void check_version(const YAML::Node& root) {
    if (!root.IsMap()) fail("", "expected fields \"name: value\" with " + version_line() + ", " + describe_kind(root));
    const YAML::Node version = find(root, kVersionField);
    if (!version.IsDefined()) fail("", "expected " + version_line() + ", found no " + kVersionField);
    mark(kVersionField, version.Mark());
    const std::optional<double> number = parse_number(version);
    if (number == kSceneVersion) return;
    const std::string found = number ? describe_found(version) : describe_kind(version);
    fail(kVersionField, "expected " + version_line() + ", " + found + "; this program reads no other version");
  }

  // Every key must be known and stand once. Remembers where each value is.
  void check_keys(const YAML::Node& map, const std::string& path, const std::vector<std::string>& known) {
    std::vector<std::string> seen;
    YAML::Node before;
    for (const auto& pair : map) {
      const YAML::Node& key = pair.first;
      const YAML::Node& value = pair.second;
      const std::string name = key.IsScalar() ? key.Scalar() : "";
      const std::string field = child_path(path, name);
      const bool repeated = std::find(seen.begin(), seen.end(), name) != seen.end();
      const bool unknown = std::find(known.begin(), known.end(), name) == known.end();
      mark(field, repeated || unknown || value.IsNull() ? key.Mark() : value.Mark());
      if (const std::string remedy = decimal_comma(before, key, value); unknown && !remedy.empty())
        fail(field, "expected a field, found " + name + remedy);
      if (unknown) fail(field, "unknown field; " + suggest(name, known));
      if (repeated) fail(field, "the field stands here a second time; keep one");
      seen.push_back(name);
      before.reset(value);
    }
  }

  template <class Tuple>
  static std::vector<std::string> names_of(const Tuple& fields, const std::string& path) {
    std::vector<std::string> names;
    if (path.empty()) names.push_back(kVersionField);
    for_each_entry(fields, [&names](const auto& field) { names.push_back(field.name); });
    return names;
  }

  static YAML::Node find(const YAML::Node& map, const std::string& name) {
    for (const auto& pair : map) {
      if (pair.first.IsScalar() && pair.first.Scalar() == name) return pair.second;
    }
    return YAML::Node(YAML::NodeType::Undefined);
  }

  void mark(const std::string& path, const YAML::Mark& at) {
    if (!at.is_null()) scene_.places[path] = {at.line + 1, at.column + 1};
  }

  [[noreturn]] void fail(const std::string& path, const std::string& what) const {
    throw scene_error(scene_, path, what);
  }

  Scene& scene_;
};

// Takes in a document without keeping it.
class Ignore : public YAML::EventHandler {
 public:
  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark&, YAML::anchor_t) override {}
  void OnAlias(const YAML::Mark&, YAML::anchor_t) override {}
  void OnScalar(const YAML::Mark&, const std::string&, YAML::anchor_t, const std::string&) override {}
  void OnSequenceStart(const YAML::Mark&, const std::string&, YAML::anchor_t, YAML::EmitterStyle::value) override {}
  void OnSequenceEnd() override {}
  void OnMapStart(const YAML::Mark&, const std::string&, YAML::anchor_t, YAML::EmitterStyle::value) override {}
  void OnMapEnd() override {}
};

// Looks no further than the second document: at a stray comma yaml-cpp would find documents without end.
void check_one_document(const std::string& text, const std::string& name) {
  std::istringstream stream(text);
  YAML::Parser parser(stream);
  Ignore ignore;
  if (!parser.HandleNextDocument(ignore)) throw SceneError(name + ":1:1: expected one YAML document, found none");
  if (parser.HandleNextDocument(ignore)) throw SceneError(name + ":1:1: expected one YAML document, found more");
}

// Whether a line gives the version, as YAML or JSON writes it. A text without one is no scene, and whoever named its
// file, perhaps over the network, learns nothing of what stands in it.
bool has_version_line(const std::string& text) {
  const std::regex version("[ {\"']*" + std::string(kVersionField) + "[\"']? *: *" + std::to_string(kSceneVersion));
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (std::regex_search(line.substr(0, 100), version, std::regex_constants::match_continuous)) return true;
  }
  return false;
}

// What a problem that yaml-cpp tells of is, in words of who writes a scene; `line` counts from 0.
std::string yaml_problem(const std::string& text, const YAML::Exception& error) {
  std::istringstream lines(text);
  std::string line;
  for (int i = 0; i <= error.mark.line; ++i) std::getline(lines, line);
  if (line.substr(0, line.find_first_not_of(" \t")).find('\t') != std::string::npos)
    return "expected spaces before the field, found a tab, which YAML does not take; replace it by spaces";
  if (error.msg.starts_with("end of ") && error.msg.ends_with("not found"))
    return "expected YAML, found: " + error.msg + "; a list or map has no ] or }, or the file is cut off";
  return "expected YAML, found: " + error.msg;
}

YAML::Node parse_yaml(const std::string& text, const std::string& name) {
  try {
    check_one_document(text, name);
    return YAML::Load(text);
  } catch (const YAML::Exception& error) {
    if (!has_version_line(text)) throw SceneError(name + ": expected " + version_line() + ", found no such line");
    throw SceneError(name + ":" + std::to_string(error.mark.line + 1) + ":" + std::to_string(error.mark.column + 1) +
                     ": " + yaml_problem(text, error));
  }
}

std::string read_text(const std::string& path, const SceneFolders* allowed) {
  const OpenedFile opened = open_file(path, "scene", allowed);
  const int file = opened.file.number();
  if (file < 0) throw SceneError(path + ": expected a scene file, found: " + opened.problem);
  std::string text(kMaxFileSize + 1, '\0');
  std::size_t size = 0;
  ssize_t count = 0;
  while (size < text.size() && (count = read(file, &text[size], text.size() - size)) > 0)
    size += static_cast<std::size_t>(count);
  const int error = errno;
  if (count < 0) throw SceneError(path + ": the scene file cannot be read: " + std::strerror(error));
  if (size > kMaxFileSize) {
    throw SceneError(path + ": expected a scene of at most " + std::to_string(kMaxFileSize) + " bytes, found more");
  }
  text.resize(size);
  return text;
}

void find_mesh(Scene& scene, const std::string& folder, const SceneFolders* allowed) {
  GmshMesh& mesh = *scene.tissue.gmsh;
  mesh.file = (std::filesystem::path(folder) / mesh.file).string();
  if (scene.tissue.left_out()) return;
  const std::string problem = open_file(mesh.file, "mesh", allowed).problem;
  if (problem.empty()) return;
  throw scene_error(scene, "tissue.mesh.gmsh.file", "expected a mesh file at \"" + mesh.file + "\", found: " + problem);
}

std::string as_json(const std::string& text) {
  return nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

std::string as_json(double value) {
  if (!std::isfinite(value)) return value < 0 ? "-1e999" : "1e999";
  return format_number(value);
}

std::string as_json(const YAML::Node& node) {
  if (node.IsMap() || node.IsSequence()) {
    std::string inside;
    for (const auto& each : node) {
      if (!inside.empty()) inside += ", ";
      inside += node.IsMap() ? as_json(each.first.Scalar()) + ": " + as_json(each.second) : as_json(each);
    }
    return node.IsMap() ? "{" + inside + "}" : "[" + inside + "]";
  }
  if (const auto number = parse_number(node)) return as_json(*number);
  if (!node.IsScalar()) return "null";
  return is_plain_value(node) ? node.Scalar() : as_json(node.Scalar());
}

}  // namespace

std::string scene_as_json(const Scene& scene) { return as_json(parse_yaml(scene.text, scene.file)); }

Scene parse_scene(const std::string& text, const std::string& name) {
  const YAML::Node root = parse_yaml(text, name);
  Scene scene;
  scene.file = name;
  scene.text = text;
  Reader(scene).read_scene(root);
  validate(scene);
  return scene;
}

Scene parse_scene(const std::string& text, const std::string& name, const std::string& folder,
                  const SceneFolders* allowed) {
  Scene scene = parse_scene(text, name);
  if (scene.tissue.gmsh) find_mesh(scene, folder, allowed);
  return scene;
}

Scene read_scene(const std::string& path, const SceneFolders* allowed) {
  return parse_scene(read_text(path, allowed), path, std::filesystem::path(path).parent_path().string(), allowed);
}

}  // namespace acus
