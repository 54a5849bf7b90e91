// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/scene/files/opened_file.h"

#include <doctest/doctest.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <thread>

#include "server/engine/scene/files/mesh_file.h"
#include "server/engine/scene/files/scene_folders.h"
#include "server/engine/scene/scene.h"
#include "tests/support/temporary_folder.h"

using namespace acus;

namespace {

const std::string kIrregular = "no regular file, but a folder, a pipe, a socket or a device";

std::string content(const OpenedFile& opened) {
  std::string text(100, '\0');
  const ssize_t size = read(opened.file.number(), text.data(), text.size());
  text.resize(size > 0 ? static_cast<std::size_t>(size) : 0);
  return text;
}

// Turns a link to the one file, then to the other, as fast as it can, until it goes away.
class TurningLink {
 public:
  TurningLink(const std::string& link, const std::string& one, const std::string& other)
      : turner_([=](const std::stop_token& stop) {
          while (!stop.stop_requested()) {
            for (const std::string& target : {one, other}) {
              std::filesystem::create_symlink(target, link + ".new");
              std::filesystem::rename(link + ".new", link);
            }
          }
        }) {
    while (!std::filesystem::is_symlink(link)) std::this_thread::yield();
  }

 private:
  std::jthread turner_;
};

}  // namespace

TEST_CASE("a regular file is opened for reading; the problem with any other is told") {
  const TemporaryFolder folder;
  CHECK(content(open_file(folder.write("a", "text"), "scene", nullptr)) == "text");
  CHECK(open_file(folder / "none", "scene", nullptr).problem == "No such file or directory");
  CHECK(open_file(folder.path(), "scene", nullptr).problem == kIrregular);
  CHECK(open_file("/dev/zero", "scene", nullptr).problem == kIrregular);
  REQUIRE(mkfifo((folder / "pipe").c_str(), 0600) == 0);
  CHECK(open_file(folder / "pipe", "scene", nullptr).problem == kIrregular);
}

TEST_CASE("what was opened is judged, not what stands at its path since") {
  const TemporaryFolder root;
  for (const char* name : {"a", "b"}) std::filesystem::create_directories(root / name);
  const std::string inside = root.write("a/scene.yaml", "inside"), outside = root.write("b/scene.yaml", "outside");
  const SceneFolders folders({root / "a"});
  CHECK(content(open_file(inside, "scene", &folders)) == "inside");
  CHECK_THROWS_WITH_AS(open_file(outside, "scene", &folders), doctest::Contains("--scenes"), SceneError);

  const Descriptor opened(open(outside.c_str(), O_RDONLY | O_CLOEXEC));
  const std::string itself = "/proc/self/fd/" + std::to_string(opened.number());
  CHECK_THROWS_WITH_AS(folders.check_opened(itself, inside, "scene"), doctest::Contains(inside.c_str()), SceneError);
  CHECK_THROWS_WITH_AS(folders.check_opened("/proc/self/fd/none", inside, "scene"),
                       doctest::Contains("where it is cannot be told"), SceneError);
  std::filesystem::rename(outside, root / "a/moved.yaml");
  CHECK_NOTHROW(folders.check_opened(itself, inside, "scene"));
}

TEST_CASE("a link that turns between a file inside and one outside never gives the one outside") {
  const TemporaryFolder root;
  for (const char* name : {"a", "b"}) std::filesystem::create_directories(root / name);
  const std::string inside = root.write("a/in", "inside"), outside = root.write("b/out", "outside");
  const std::string link = root / "a/link";
  const SceneFolders folders({root / "a"});
  const TurningLink turning(link, inside, outside);
  int opened = 0, refused = 0;
  for (int i = 0; i < 5000; ++i) {
    try {
      const std::string read = content(open_file(link, "scene", &folders));
      REQUIRE(read == "inside");
      ++opened;
    } catch (const SceneError&) {
      ++refused;
    }
  }
  MESSAGE("opened " << opened << " times, refused " << refused << " times");
}

TEST_CASE("scenes and meshes are read from the folders only") {
  const TemporaryFolder root;
  for (const char* name : {"a", "b"}) std::filesystem::create_directories(root / name);
  const SceneFolders folders({root / "a"});
  const std::string scene = root.write("b/scene.yaml", "acus_scene: 1\n"), mesh = root.write("b/mesh.msh", "");
  std::filesystem::create_symlink(scene, root / "a/scene.yaml");
  std::filesystem::create_symlink(mesh, root / "a/mesh.msh");
  CHECK_THROWS_WITH_AS(read_scene(root / "a/scene.yaml", &folders), doctest::Contains("--scenes"), SceneError);
  CHECK_THROWS_WITH_AS(read_mesh_file(root / "a/mesh.msh", 1, &folders), doctest::Contains("--scenes"), SceneError);
  Scene with_mesh;
  with_mesh.tissue.gmsh = GmshMesh{root / "a/mesh.msh", 1};
  CHECK_THROWS_WITH_AS(read_mesh(with_mesh, &folders), doctest::Contains("--scenes"), SceneError);
}
