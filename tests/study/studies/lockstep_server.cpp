// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/study/studies/lockstep_server.h"

#include <signal.h>
#include <spawn.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <fstream>
#include <system_error>
#include <vector>

namespace acus {

LockstepServer::LockstepServer(const std::string& scene)
    : folder_(std::filesystem::temp_directory_path() / "acus-evidence-XXXXXX") {
  if (!mkdtemp(folder_.data())) throw std::system_error(errno, std::generic_category(), "cannot create " + folder_);
  const std::string file = folder_ + "/scene.yaml";
  std::ofstream(file, std::ios::binary) << scene;
  std::string program = std::filesystem::read_symlink("/proc/self/exe").parent_path() / "acus-server";
  std::vector<std::string> words{program,    file,     "--commands",  commands(),    "--states",
                                 states(), "--lockstep", "--log-level", "warn"};
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  const int error = posix_spawn(&process_, program.c_str(), nullptr, nullptr, arguments.data(), environ);
  if (error != 0) throw std::system_error(error, std::generic_category(), "cannot start " + program);
}

LockstepServer::~LockstepServer() {
  kill(process_, SIGKILL);
  waitpid(process_, nullptr, 0);
  std::error_code ignored;
  std::filesystem::remove_all(folder_, ignored);
}

}  // namespace acus
