// SPDX-License-Identifier: MIT
#include "client/view/started_server.h"

#include <spawn.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <stdexcept>
#include <system_error>

namespace acus::view {

namespace {

constexpr int kMostTries = 150;
constexpr useconds_t kPauseMicroseconds = 20'000;

}  // namespace

StartedServer::StartedServer(const std::string& scene, const std::vector<std::string>& options) {
  folder_ = (std::filesystem::temp_directory_path() / "acus-view-XXXXXX").string();
  if (mkdtemp(folder_.data()) == nullptr)
    throw std::system_error(errno, std::system_category(), "a folder for the server's sockets");
  const auto program = std::filesystem::read_symlink("/proc/self/exe").parent_path() / "acus-server";
  std::vector<std::string> command{program.string(), scene,          "--commands", address().commands, "--states",
                                   address().states, "--recordings", folder_};
  command.insert(command.end(), options.begin(), options.end());
  std::vector<char*> arguments;
  for (std::string& argument : command) arguments.push_back(argument.data());
  arguments.push_back(nullptr);
  const pid_t parent = getpid();
  process_ = fork();
  if (process_ < 0) throw std::system_error(errno, std::system_category(), "starting acus-server");
  if (process_ == 0) {
    setpgid(0, 0);  // Ctrl-C in the terminal is for the gateway, which ends the server
    prctl(PR_SET_PDEATHSIG, SIGTERM);
    if (getppid() != parent) _exit(kNoProgram);
    execv(arguments[0], arguments.data());
    _exit(kNoProgram);
  }
}

StartedServer::~StartedServer() {
  // Asked again and again: right after the fork the first would be the parent's handler's. One that hangs is killed.
  for (int tries = 0; ended() < 0; ++tries) {
    kill(process_, tries < kMostTries ? SIGTERM : SIGKILL);
    usleep(kPauseMicroseconds);
  }
  std::error_code ignored;
  std::filesystem::remove_all(folder_, ignored);
}

ServerAddress StartedServer::address() const {
  return {"ipc://" + folder_ + "/commands", "ipc://" + folder_ + "/states", std::nullopt};
}

int StartedServer::ended() {
  int status = 0;
  if (status_ < 0 && waitpid(process_, &status, WNOHANG) == process_)
    status_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return status_;
}

}  // namespace acus::view
