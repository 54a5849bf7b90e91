// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/scene/files/mesh_process.h"

#include <fcntl.h>
#include <poll.h>
#include <sched.h>
#include <spawn.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <initializer_list>
#include <optional>

#include "server/engine/models/geometry/tetrahedral_mesh.h"
#include "server/engine/scene/files/opened_file.h"

namespace acus {
namespace {

using Clock = std::chrono::steady_clock;

// Descriptors that acus-mesh finds open; 1 and 2 lead nowhere, and the companion's where there is none.
constexpr int kMeshDescriptor = 0;
constexpr int kAnswerDescriptor = 3;
constexpr int kCompanionDescriptor = 4;

constexpr std::chrono::milliseconds kWaitStep{1};  // between two looks whether the program has ended

// What acus-mesh needs of the environment.
constexpr std::array kKeptVariables{"LD_LIBRARY_PATH", "ASAN_OPTIONS", "LSAN_OPTIONS", "TSAN_OPTIONS", "UBSAN_OPTIONS"};

constexpr const char* kRemedy = "the file is damaged; write it anew with the program that made it";

[[noreturn]] void fail(const std::string& what, int error) {
  throw MeshError(what + " (" + std::strerror(error) + ")");
}

// Away from the numbers that the started program gives a meaning to.
Descriptor moved_up(const Descriptor& descriptor) {
  Descriptor higher(fcntl(descriptor.number(), F_DUPFD_CLOEXEC, kCompanionDescriptor + 1));
  if (higher.number() < 0) fail("a file descriptor cannot be had", errno);
  return higher;
}

// Whether the calling thread hands a real-time priority on to what it starts.
bool real_time() {
  const int policy = sched_getscheduler(0) & ~SCHED_RESET_ON_FORK;
  return policy == SCHED_FIFO || policy == SCHED_RR;
}

// Lists for posix_spawn: of a process with several threads, fork() would leave a copy that may hardly do anything.
class SpawnSettings {
 public:
  // `companion` is negative where there is none.
  SpawnSettings(int mesh, int companion, int answer) {
    posix_spawn_file_actions_init(&actions_);
    posix_spawn_file_actions_adddup2(&actions_, mesh, kMeshDescriptor);
    for (const int unused : {STDOUT_FILENO, STDERR_FILENO})
      posix_spawn_file_actions_addopen(&actions_, unused, "/dev/null", O_RDWR, 0);
    posix_spawn_file_actions_adddup2(&actions_, answer, kAnswerDescriptor);
    if (companion >= 0)
      posix_spawn_file_actions_adddup2(&actions_, companion, kCompanionDescriptor);
    else
      posix_spawn_file_actions_addopen(&actions_, kCompanionDescriptor, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addclosefrom_np(&actions_, kCompanionDescriptor + 1);

    posix_spawnattr_init(&attributes_);
    sigset_t none, all;
    sigemptyset(&none);
    sigfillset(&all);
    sched_param priority{};
    posix_spawnattr_setsigmask(&attributes_, &none);
    posix_spawnattr_setsigdefault(&attributes_, &all);
    posix_spawnattr_setschedpolicy(&attributes_, SCHED_OTHER);
    posix_spawnattr_setschedparam(&attributes_, &priority);
    const int scheduler = real_time() ? POSIX_SPAWN_SETSCHEDULER : 0;
    posix_spawnattr_setflags(&attributes_, static_cast<short>(POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF |
                                                              POSIX_SPAWN_SETSID | scheduler));
  }
  ~SpawnSettings() {
    posix_spawnattr_destroy(&attributes_);
    posix_spawn_file_actions_destroy(&actions_);
  }
  SpawnSettings(const SpawnSettings&) = delete;
  SpawnSettings& operator=(const SpawnSettings&) = delete;

  const posix_spawn_file_actions_t* actions() const { return &actions_; }
  const posix_spawnattr_t* attributes() const { return &attributes_; }

 private:
  posix_spawn_file_actions_t actions_;
  posix_spawnattr_t attributes_;
};

// Pointers as exec wants them; they live as long as the texts.
std::vector<char*> pointers(std::vector<std::string>& texts) {
  std::vector<char*> result;
  for (std::string& text : texts) result.push_back(text.data());
  result.push_back(nullptr);
  return result;
}

std::vector<std::string> environment() {
  std::vector<std::string> variables{"LC_ALL=C"};
  for (const char* name : kKeptVariables) {
    if (const char* value = std::getenv(name)) variables.push_back(std::string(name) + "=" + value);
  }
  return variables;
}

// A started program, which does not outlive the object.
class Child {
 public:
  Child(const std::string& program, std::vector<std::string> arguments, const SpawnSettings& settings) {
    arguments.insert(arguments.begin(), program);
    std::vector<std::string> variables = environment();
    const int error = posix_spawn(&pid_, program.c_str(), settings.actions(), settings.attributes(),
                                  pointers(arguments).data(), pointers(variables).data());
    if (error == 0) return;
    throw MeshError("the program " + program + ", which reads meshes, cannot be started (" + std::strerror(error) +
                    "); build or install acus-mesh in the folder of this program");
  }
  ~Child() {
    if (ended_) return;
    kill(pid_, SIGKILL);
    while (waitpid(pid_, nullptr, 0) < 0 && errno == EINTR) {
    }
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  // The status that waitpid() tells, or nothing while it runs.
  std::optional<int> status() {
    int value = 0;
    const pid_t found = waitpid(pid_, &value, WNOHANG);
    if (found == 0 || (found < 0 && errno == EINTR)) return std::nullopt;
    ended_ = true;
    return found < 0 ? 0 : value;  // where this process ignores SIGCHLD nobody knows, and the answer tells enough
  }

 private:
  pid_t pid_ = -1;
  bool ended_ = false;
};

class Deadline {
 public:
  explicit Deadline(std::chrono::milliseconds time) : time_(time), end_(Clock::now() + time) {}

  std::chrono::milliseconds left() const {
    const auto rest = std::chrono::ceil<std::chrono::milliseconds>(end_ - Clock::now());
    if (rest.count() > 0) return rest;
    const double seconds = std::chrono::duration<double>(time_).count();
    throw MeshError("reading it took longer than " + std::to_string(std::lround(seconds)) + " s and was stopped; " +
                    kRemedy + ", or make the mesh coarser");
  }

 private:
  std::chrono::milliseconds time_;
  Clock::time_point end_;
};

// All that comes through the pipe until its other end is closed.
std::vector<char> read_all(int pipe, std::uint64_t limit, const Deadline& deadline) {
  constexpr std::size_t kPart = std::size_t{1} << 16;
  std::vector<char> bytes;
  for (;;) {
    pollfd ready{pipe, POLLIN, 0};
    if (poll(&ready, 1, static_cast<int>(deadline.left().count())) <= 0) continue;
    const std::size_t size = bytes.size();
    bytes.resize(size + kPart);
    const ssize_t count = read(pipe, bytes.data() + size, kPart);
    if (count < 0 && errno != EINTR) fail("the answer of acus-mesh cannot be read", errno);
    bytes.resize(size + static_cast<std::size_t>(std::max<ssize_t>(count, 0)));
    if (count == 0) return bytes;
    if (bytes.size() > limit) throw MeshError("the answer of acus-mesh does not end");
  }
}

int wait_for_end(Child& child, const Deadline& deadline) {
  for (;;) {
    if (const std::optional<int> status = child.status()) return *status;
    poll(nullptr, 0, static_cast<int>(std::min(deadline.left(), kWaitStep).count()));
  }
}

void check_status(int status, const MeshReadingLimits& limits) {
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return;
  if (WIFEXITED(status)) {
    throw MeshError("acus-mesh, which reads it, stopped with status " + std::to_string(WEXITSTATUS(status)) + "; " +
                    kRemedy);
  }
  const int number = WTERMSIG(status);
  if (number == SIGXCPU) {
    throw MeshError("reading it took more than " + std::to_string(limits.processor_seconds) +
                    " s of processor time and was stopped; " + kRemedy + ", or make the mesh coarser");
  }
  if (number == SIGKILL) {
    throw MeshError("acus-mesh, which reads it, was killed, perhaps for want of memory; " + std::string(kRemedy) +
                    ", or make the mesh coarser");
  }
  throw MeshError("acus-mesh crashed while it read the file (signal " + std::to_string(number) + ", " +
                  sigdescr_np(number) + "); " + kRemedy);
}

std::string& chosen_program() {
  static std::string path;
  return path;
}

Descriptor open_mesh(const std::string& path, std::uint64_t limit, const SceneFolders* allowed) {
  const OpenedFile opened = open_file(path, "mesh", allowed);
  if (opened.file.number() < 0) throw MeshError("expected a mesh file, found: " + opened.problem);
  struct stat found {};
  if (fstat(opened.file.number(), &found) != 0) fail("the file's size cannot be told", errno);
  if (static_cast<std::uint64_t>(found.st_size) <= limit) return moved_up(opened.file);
  throw MeshError("expected a file of at most " + std::to_string(limit) + " bytes, found " +
                  std::to_string(found.st_size));
}

// TetGen's .node beside an .ele, and the other way round; not open where there is none.
Descriptor open_companion(const std::filesystem::path& mesh, std::uint64_t limit, const SceneFolders* allowed) {
  constexpr std::array<std::array<const char*, 2>, 4> kPairs{
      {{".ele", ".node"}, {".node", ".ele"}, {".ELE", ".NODE"}, {".NODE", ".ELE"}}};
  for (const auto& [ending, other] : kPairs) {
    if (mesh.extension() != ending) continue;
    const std::string companion = std::filesystem::path(mesh).replace_extension(other).string();
    if (std::filesystem::exists(companion)) return open_mesh(companion, limit, allowed);
  }
  return Descriptor();
}

}  // namespace

void use_mesh_program(const std::string& path) { chosen_program() = path; }

std::string mesh_program_path() {
  if (!chosen_program().empty()) return chosen_program();
  std::error_code error;
  const std::filesystem::path self = std::filesystem::read_symlink("/proc/self/exe", error);
  if (error) throw MeshError("acus-mesh, which reads meshes, is not found: /proc/self/exe: " + error.message());
  return (self.parent_path() / "acus-mesh").string();
}

std::vector<char> run_mesh_program(const std::string& program, const std::string& mesh_path,
                                   const MeshReadingLimits& limits, const SceneFolders* allowed) {
  const Descriptor mesh = open_mesh(mesh_path, limits.file_bytes, allowed);
  const Descriptor companion = open_companion(mesh_path, limits.file_bytes, allowed);
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) fail("no pipe can be made to read it", errno);
  const Descriptor answer(ends[0]);
  Descriptor written = moved_up(Descriptor(ends[1]));

  const Deadline deadline(limits.time);
  Child child(program,
              {std::filesystem::path(mesh_path).filename().string(), std::to_string(limits.memory_bytes),
               std::to_string(limits.processor_seconds)},
              SpawnSettings(mesh.number(), companion.number(), written.number()));
  written.close();
  std::vector<char> bytes = read_all(answer.number(), limits.answer_bytes, deadline);
  check_status(wait_for_end(child, deadline), limits);
  return bytes;
}

}  // namespace acus
