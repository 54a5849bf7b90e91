// SPDX-License-Identifier: MIT
#include "client/view/child_program.h"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <system_error>
#include <utility>

namespace acus::view {

namespace {

constexpr int kMostTries = 150;
constexpr useconds_t kPauseMicroseconds = 20'000;

}  // namespace

std::string new_folder() {
  std::string folder = (std::filesystem::temp_directory_path() / "acus-view-XXXXXX").string();
  if (mkdtemp(folder.data()) == nullptr)
    throw std::system_error(errno, std::system_category(), "a folder in " + folder);
  return folder;
}

ChildProgram::ChildProgram(boost::asio::io_context& context, const std::string& name,
                           std::vector<std::string> arguments, Ended ended)
    : signals_(context, SIGCHLD), ended_(std::move(ended)) {
  const auto program = std::filesystem::read_symlink("/proc/self/exe").parent_path() / name;
  arguments.insert(arguments.begin(), program.string());
  watch();
  start(std::move(arguments));
}

void ChildProgram::start(std::vector<std::string> command) {
  std::vector<char*> arguments;
  for (std::string& argument : command) arguments.push_back(argument.data());
  arguments.push_back(nullptr);
  const pid_t parent = getpid();
  process_ = fork();
  if (process_ < 0) throw std::system_error(errno, std::system_category(), "starting " + command.front());
  if (process_ > 0) return;
  setpgid(0, 0);  // Ctrl-C in the terminal is for the owner, which ends this one
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (getppid() != parent) _exit(kNoProgram);
  if (const int nowhere = open("/dev/null", O_WRONLY); nowhere >= 0) dup2(nowhere, STDOUT_FILENO);
  execv(arguments[0], arguments.data());
  _exit(kNoProgram);
}

ChildProgram::~ChildProgram() {
  // Asked again and again: right after the fork the first would be the parent's handler's. One that hangs is killed.
  for (int tries = 0; !has_ended(); ++tries) {
    kill(process_, tries < kMostTries ? SIGTERM : SIGKILL);
    usleep(kPauseMicroseconds);
  }
}

void ChildProgram::ask_to_end() {
  if (!has_ended()) kill(process_, SIGTERM);
}

void ChildProgram::watch() {
  signals_.async_wait([this](const boost::system::error_code& error, int) {
    if (error) return;
    if (!has_ended()) return watch();
    const Ended tell = std::move(ended_);
    tell(status_);
  });
}

bool ChildProgram::has_ended() {
  int status = 0;
  if (status_ < 0 && waitpid(process_, &status, WNOHANG) == process_)
    status_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return status_ >= 0;
}

}  // namespace acus::view
