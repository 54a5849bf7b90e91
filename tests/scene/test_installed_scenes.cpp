// SPDX-License-Identifier: GPL-3.0-or-later
#include <doctest/doctest.h>

#include "server/engine/scene/files/installed_scenes.h"
#include "tests/support/temporary_folder.h"

using namespace acus;

TEST_CASE("a name is that of a file, or of a scene in the first folder that has it") {
  const TemporaryFolder root;
  for (const char* folder : {"own", "installed/benchmark"}) std::filesystem::create_directories(root / folder);
  const std::string own = root.write("own/both.yaml", ""), installed = root.write("installed/one.yaml", "");
  const std::string below = root.write("installed/benchmark/cube.yaml", "");
  root.write("installed/both.yaml", "");
  const std::vector<std::filesystem::path> folders{root / "absent", root / "own", root / "installed"};
  CHECK(find_scene("both", folders) == own);
  CHECK(find_scene("one", folders) == installed);
  CHECK(find_scene("benchmark/cube", folders) == below);
  CHECK(find_scene(own, folders) == own);
}

TEST_CASE("what is nowhere, and what is a folder, stays what it is") {
  const TemporaryFolder root;
  root.write("scene.yaml", "");
  const std::vector<std::filesystem::path> folders{root.path()};
  for (const std::string& name : {std::string("absent"), std::string("/etc"), std::string(), root / "scene"})
    CHECK(find_scene(name, folders) == name);
}

TEST_CASE("the administrator's scenes come before those of the installation") {
  const auto folders = installed_scene_folders();
  REQUIRE(folders.size() == 2);
  CHECK(folders[0] == "/etc/acus");
  CHECK(folders[1].is_absolute());
  CHECK(folders[1].filename() == "scenes");
}
