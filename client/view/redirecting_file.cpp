// SPDX-License-Identifier: MIT
#include "client/view/redirecting_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <system_error>

#include "client/view/child_program.h"

namespace acus::view {

RedirectingFile::RedirectingFile(const std::string& url) : folder_(new_folder()) {
  const std::string page =
      "<!DOCTYPE html><meta charset=\"utf-8\"><title>acus-view</title><meta http-equiv=\"refresh\" "
      "content=\"0; url=" +
      url + "\"><a href=\"" + url + "\">acus-view</a>\n";
  const int file = open(path().c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, S_IRUSR | S_IWUSR);
  const bool written = file >= 0 && write(file, page.data(), page.size()) == static_cast<ssize_t>(page.size());
  const int why = errno;
  if (file >= 0) close(file);
  if (written) return;
  std::error_code ignored;
  std::filesystem::remove_all(folder_, ignored);
  throw std::system_error(why, std::system_category(), path());
}

RedirectingFile::~RedirectingFile() {
  std::error_code ignored;
  std::filesystem::remove_all(folder_, ignored);
}

}  // namespace acus::view
