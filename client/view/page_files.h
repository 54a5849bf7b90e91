// SPDX-License-Identifier: MIT
// The files of the page, read once: a gateway serves these and nothing else.
#pragma once

#include <map>
#include <string>

namespace acus::view {

struct PageFile {
  std::string type;  // Content-Type
  std::string bytes;
};

// By path as browsers ask for it; `/` is index.html. Throws std::runtime_error if a file cannot be read.
std::map<std::string, PageFile> read_page(const std::string& folder);

// Where they are beside the running program: installed (share/acus/view), or in the build.
std::string page_folder();

}  // namespace acus::view
