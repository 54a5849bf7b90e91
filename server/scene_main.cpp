// SPDX-License-Identifier: GPL-3.0-or-later
// acus-scene: checks scene files and writes the reference of their fields.
#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "server/simulation/scene.h"
#include "server/simulation/scene_reference.h"

namespace {

constexpr const char* kUsage =
    "usage: acus-scene check SCENE   read a scene and its mesh and say what it holds, or what is wrong\n"
    "       acus-scene schema        print the JSON Schema of scene files\n"
    "       acus-scene tables        print the tables of all fields in Markdown\n";

int check(const std::string& path) {
  const acus::Scene scene = acus::read_scene(path);
  const acus::TetrahedralMesh mesh = acus::load_mesh(scene);
  acus::assign_regions(scene, mesh);
  const std::vector<bool> fixed = acus::find_fixed_nodes(scene, mesh);
  std::printf("%s: %d nodes (%d fixed), %d tetrahedra, %zu regions, %zu needles, %g Hz\n", scene.name.c_str(),
              mesh.node_count(), static_cast<int>(std::count(fixed.begin(), fixed.end(), true)),
              mesh.tetrahedron_count(), scene.tissue.regions.size(), scene.needles.size(), scene.rate);
  return 0;
}

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

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  try {
    if (arguments.size() == 2 && arguments[0] == "check") return check(arguments[1]);
    if (arguments.size() == 1 && arguments[0] == "schema") return print_schema();
    if (arguments.size() == 1 && arguments[0] == "tables") return print_tables();
  } catch (const acus::SceneError& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  std::fputs(kUsage, stderr);
  return 2;
}
