// SPDX-License-Identifier: GPL-3.0-or-later
// A process that is confined reads what is open and computes, and nothing else that it asks for happens.
#include <doctest/doctest.h>
#include <fcntl.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/prctl.h>
#include <sys/ptrace.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <sstream>

#include "server/engine/mesh_files/mesh_confinement.h"
#include "server/engine/scene/files/mesh_process.h"
#include "tests/support/file_content.h"
#include "tests/support/places.h"
#include "tests/support/temporary_folder.h"

namespace acus {
namespace {

// The number of the first call of a confined process that does what it should not, or fails; 0: all is as it should be.
int first_wrong_call(const char* writable) {
  const int own = open("/proc/self/status", O_RDONLY);
  confine();
  int number = 0, wrong = 0;
  const auto expect = [&](bool right) {
    ++number;
    if (!right && wrong == 0) wrong = number;
  };
  const auto refused = [&](long result) { expect(result == -1 && errno == EPERM); };
  char letter = 0;
  expect(own >= 0 && read(own, &letter, 1) == 1);
  refused(open("/proc/self/status", O_RDONLY));
  refused(open(writable, O_WRONLY));
  refused(open(writable, O_RDWR | O_CREAT, 0600));
  refused(unlink(writable));
  refused(chmod(writable, 0777));
  refused(mkdir("/tmp/acus-confined", 0700));
  refused(socket(AF_INET, SOCK_STREAM, 0));
  refused(fork());
  refused(execl("/bin/true", "true", nullptr));
  refused(kill(getppid(), 0));
  refused(syscall(SYS_tgkill, getppid(), getppid(), 0));
  refused(ptrace(PTRACE_TRACEME, 0, nullptr, nullptr));
  refused(ioctl(own, TIOCSTI, "x"));
  refused(fcntl(own, F_SETOWN, getppid()));
  refused(prctl(PR_SET_DUMPABLE, 0));
  refused(setuid(0));
  refused(syscall(SYS_io_uring_setup, 1, nullptr));
  refused(syscall(SYS_pidfd_open, getppid(), 0));
  refused(syscall(SYS_memfd_create, "x", 0));
  return wrong;
}

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

}  // namespace

TEST_CASE("a confined process can read what it has open, compute, and nothing else") {
  const TemporaryFolder folder;
  const std::string file = folder.write("file", "kept");
  for (const std::string& path : {folder.path(), file}) std::filesystem::permissions(path, std::filesystem::perms::all);
  const pid_t child = fork();
  REQUIRE(child >= 0);
  if (child == 0) _exit(first_wrong_call(file.c_str()));
  int ended = -1;
  REQUIRE(waitpid(child, &ended, 0) == child);
  REQUIRE(WIFEXITED(ended));
  CHECK(WEXITSTATUS(ended) == 0);
  CHECK(std::filesystem::file_size(file) == 4);
}

// While it waits for somebody to read its answer.
TEST_CASE("the reading program is confined, and is not root where there are other users") {
  const std::string program = mesh_program_path();
  const int input = open(source_path("scenes/meshes/prostate.msh").c_str(), O_RDONLY | O_CLOEXEC);
  REQUIRE(input >= 0);
  std::array<int, 2> answer{};
  REQUIRE(pipe2(answer.data(), O_CLOEXEC) == 0);
  REQUIRE(fcntl(answer[1], F_SETPIPE_SZ, 4096) == 4096);
  const pid_t child = fork();
  REQUIRE(child >= 0);
  if (child == 0) {
    dup2(input, 0);
    dup2(answer[1], 3);
    dup2(open("/dev/null", O_RDONLY), 4);
    execl(program.c_str(), program.c_str(), "mesh.msh", "8000000000", "60", nullptr);
    _exit(9);
  }
  close(answer[1]);
  close(input);
  pollfd written{answer[0], POLLIN, 0};
  REQUIRE(poll(&written, 1, 60'000) == 1);
  const std::string status = content_of("/proc/" + std::to_string(child) + "/status");
  CHECK(contains(status, "NoNewPrivs:\t1"));
  CHECK(contains(status, "Seccomp:\t2"));
  CHECK(contains(status, "CapEff:\t0000000000000000"));
  std::istringstream users(content_of("/proc/self/uid_map"));
  long inside = 0, outside = 0, count = 0;
  users >> inside >> outside >> count;
  if (geteuid() == 0 && count > 65534) CHECK(contains(status, "Uid:\t65534\t65534\t65534\t65534"));
  std::array<char, 4096> part{};
  ssize_t bytes = 0;
  for (ssize_t read_now = 0; (read_now = read(answer[0], part.data(), part.size())) > 0;) bytes += read_now;
  close(answer[0]);
  int ended = -1;
  CHECK(waitpid(child, &ended, 0) == child);
  CHECK(ended == 0);
  CHECK(bytes > 50'000);
}

}  // namespace acus
