// SPDX-License-Identifier: MIT
#include "client/view/page_files.h"

#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>

namespace acus::view {

namespace {

struct Name {
  const char* file;
  const char* type;
};
constexpr Name kNames[] = {{"index.html", "text/html; charset=utf-8"},
                           {"view.css", "text/css; charset=utf-8"},
                           {"view.js", "text/javascript; charset=utf-8"},
                           {"NOTICE", "text/plain; charset=utf-8"}};

}  // namespace

std::map<std::string, PageFile> read_page(const std::string& folder) {
  std::map<std::string, PageFile> files;
  for (const Name& name : kNames) {
    const std::string path = folder + "/" + name.file;
    std::ifstream stream(path, std::ios::binary);
    PageFile file{name.type, {std::istreambuf_iterator<char>(stream), {}}};
    if (!stream) throw std::runtime_error(path + ": expected a file of the page; --page names its folder");
    files["/" + std::string(name.file)] = std::move(file);
  }
  files["/"] = files["/index.html"];
  return files;
}

std::string page_folder() {
  const auto programs = std::filesystem::read_symlink("/proc/self/exe").parent_path();
  for (const char* folder : {"../share/acus/view", "../view"}) {
    const auto path = (programs / folder).lexically_normal();
    if (std::filesystem::exists(path / "index.html")) return path.string();
  }
  return (programs / "../share/acus/view").lexically_normal().string();
}

}  // namespace acus::view
