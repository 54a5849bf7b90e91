// SPDX-License-Identifier: GPL-3.0-or-later
#include <doctest/doctest.h>

#include <filesystem>

#include "server/engine/scene/files/scene_folders.h"
#include "server/engine/scene/scene.h"
#include "tests/support/temporary_folder.h"

using namespace acus;

TEST_CASE("what lies below a folder is in it, whether it is there or not; what lies beside it is not") {
  const TemporaryFolder root;
  for (const char* folder : {"a/deep", "ab"}) std::filesystem::create_directories(root / folder);
  const SceneFolders folders({root / "a"});
  CHECK(folders.contain(root / "a/scene.yaml"));
  CHECK(folders.contain(root / "a/deep/scene.yaml"));
  CHECK(folders.contain(root / "ab/../a/scene.yaml"));
  CHECK_FALSE(folders.contain(root / "ab/scene.yaml"));
  CHECK_FALSE(folders.contain(root / "a/../scene.yaml"));
  CHECK_FALSE(folders.contain(root / "scene.yaml"));
  CHECK_FALSE(folders.contain("/"));
  CHECK_FALSE(folders.contain(""));
  CHECK_FALSE(SceneFolders().contain(root / "a/scene.yaml"));
}

TEST_CASE("links count as what they lead to") {
  const TemporaryFolder root;
  for (const char* folder : {"a", "b"}) std::filesystem::create_directories(root / folder);
  root.write("b/secret.yaml", "");
  std::filesystem::create_symlink(root / "b/secret.yaml", root / "a/link.yaml");
  std::filesystem::create_directory_symlink(root / "b", root / "a/folder");
  std::filesystem::create_symlink(root / "a/circle", root / "a/circle");
  const SceneFolders folders({root / "a"});
  CHECK_FALSE(folders.contain(root / "a/link.yaml"));
  CHECK_FALSE(folders.contain(root / "a/folder/secret.yaml"));
  CHECK_FALSE(folders.contain(root / "a/circle"));
  CHECK(SceneFolders({root / "a", root / "b"}).contain(root / "a/link.yaml"));
  CHECK_THROWS_WITH_AS(folders.check(root / "a/link.yaml", "scene"), doctest::Contains("--scenes"), SceneError);
}

TEST_CASE("a scene is found by its name in the first folder that has it, and nothing outside is looked at") {
  const TemporaryFolder root;
  for (const char* folder : {"a/deep", "b"}) std::filesystem::create_directories(root / folder);
  for (const char* file : {"a/liver.yaml", "b/liver.yaml", "b/bone.yaml", "a/deep/skin.yaml", "secret.yaml"})
    root.write(file, "");
  const SceneFolders folders({root / "a", root / "b"});
  CHECK(folders.find("liver") == root / "a/liver.yaml");
  CHECK(folders.find("liver.yaml") == root / "a/liver.yaml");
  CHECK(folders.find("bone") == root / "b/bone.yaml");
  CHECK(folders.find("deep/skin") == root / "a/deep/skin.yaml");
  CHECK(folders.find(root / "secret.yaml") == root / "secret.yaml");
  for (const char* name : {"fat", "../secret", "deep", ""}) CHECK(folders.find(name) == name);
}
