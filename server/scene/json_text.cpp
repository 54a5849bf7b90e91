// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/scene/json_text.h"

namespace acus {
namespace {

std::string enclosed(char open, const std::vector<std::string>& values, char close) {
  std::string text(1, open);
  for (const std::string& value : values) {
    if (text.size() > 1) text += ", ";
    text += value;
  }
  return text += close;
}

}  // namespace

std::string json_string(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += c;
  }
  return quoted + '"';
}

std::string json_array(const std::vector<std::string>& values) { return enclosed('[', values, ']'); }

std::string json_object(const JsonMembers& members) {
  std::vector<std::string> texts;
  for (const auto& [name, value] : members) texts.push_back(json_string(name) + ": " + value);
  return enclosed('{', texts, '}');
}

std::string indent_json(const std::string& json) {
  std::string text;
  std::size_t depth = 0;
  int arrays = 0;  // open ones inside the innermost object
  bool quoted = false;
  const auto new_line = [&] { text.append(1, '\n').append(2 * depth, ' '); };
  for (std::size_t i = 0; i < json.size(); ++i) {
    const char c = json[i];
    if (c == '"' && (i == 0 || json[i - 1] != '\\')) quoted = !quoted;
    if (!quoted && c == '[') ++arrays;
    if (!quoted && c == ']') --arrays;
    if (!quoted && c == '}' && json[i - 1] != '{') {
      --depth;
      new_line();
    }
    text += c;
    if (!quoted && c == '{' && json[i + 1] != '}') {
      ++depth;
      new_line();
    }
    if (!quoted && c == ',' && arrays == 0) {
      new_line();
      ++i;  // the space after the comma
    }
  }
  return text + "\n";
}

}  // namespace acus
