// SPDX-License-Identifier: GPL-3.0-or-later
// The folders that scenes and their meshes are read from when a client asks for them, with all that lies below them.
// Links are followed first: what counts is where a file is.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace acus {

class SceneFolders {
 public:
  SceneFolders() = default;  // none
  explicit SceneFolders(const std::vector<std::string>& folders);

  // The file that `scene` means: of that path, else the first NAME or NAME.yaml in the folders. Where nothing is found
  // it is `scene` itself.
  std::string find(const std::string& scene) const;

  bool contain(const std::string& file) const;
  // Throws SceneError, whether the file is there or not, if it is outside. `what` is what the file is, "scene".
  void check(const std::string& file, const std::string& what) const;
  // The same of what was opened as `file`, where `link`, "/proc/self/fd/N", says that it is.
  void check_opened(const std::string& link, const std::string& file, const std::string& what) const;

  const std::filesystem::path& first() const { return folders_.front(); }

 private:
  bool contain_place(const std::filesystem::path& place) const;  // canonical
  [[noreturn]] void refuse(const std::string& file, const std::string& what) const;

  std::vector<std::filesystem::path> folders_;  // canonical
};

}  // namespace acus
