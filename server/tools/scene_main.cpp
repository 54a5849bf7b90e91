// SPDX-License-Identifier: GPL-3.0-or-later
// acus-scene: writes the reference of a scene file's fields, and scenes as other programs read them.
#include <cstdio>
#include <string>
#include <vector>

#include "server/engine/scene/scene_json.h"
#include "server/engine/scene/scene_reference.h"

namespace {

constexpr const char* kUsage =
    "usage: acus-scene schema   print the JSON Schema of scene files\n"
    "       acus-scene tables   print the tables of all fields in Markdown\n"
    "       acus-scene json SCENE   check a scene file, but for its mesh, and print what it says as JSON\n"
    "       acus-scene --version\n"
    "\nTo check all of a scene: acus-server SCENE --check\n"
    "Exit status: 0 done, 1 the scene cannot be used, 2 bad command line.\n";

int print_schema() {
  std::fputs(acus::scene_schema().c_str(), stdout);
  return 0;
}

int print_tables() {
  for (const acus::FieldTable& table : acus::scene_tables()) {
    std::printf("### %s\n\n%s\n", table.title.c_str(), table.markdown.c_str());
  }
  return 0;
}

int print_json(const std::string& file) {
  try {
    std::puts(acus::scene_as_json(acus::read_scene(file)).c_str());
    return 0;
  } catch (const acus::SceneError& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  if (arguments.size() == 1 && arguments[0] == "schema") return print_schema();
  if (arguments.size() == 1 && arguments[0] == "tables") return print_tables();
  if (arguments.size() == 2 && arguments[0] == "json") return print_json(arguments[1]);
  if (arguments.size() == 1 && arguments[0] == "--version") return std::puts(ACUS_VERSION) < 0;
  const bool asked = arguments.size() == 1 && (arguments[0] == "--help" || arguments[0] == "-h");
  std::fputs(kUsage, asked ? stdout : stderr);
  return asked ? 0 : 2;
}
