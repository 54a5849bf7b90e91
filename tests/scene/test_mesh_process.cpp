// SPDX-License-Identifier: GPL-3.0-or-later
// Mesh files that are made to do harm, and programs that answer wrongly: nothing is run, nothing crashes or waits for
// ever, and the error names the file.
#include <doctest/doctest.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <random>

#include "server/engine/mesh_files/mesh_answer.h"
#include "server/engine/scene/files/mesh_file.h"
#include "server/engine/scene/files/mesh_process.h"
#include "tests/support/mesh_files.h"
#include "tests/support/temporary_folder.h"

namespace acus {
namespace {

using test::kMeshFiles;
using test::kMsh2;
using test::MeshFile;

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

template <class Action>
std::string error_of(Action action) {
  try {
    action();
  } catch (const MeshError& error) {
    return error.what();
  }
  return "no error";
}

// Numbers that stand in for a size or a node.
const std::vector<std::string> kBadNumbers{"-1",   "0",   "3", "99", "2147483647", "99999999999999999999",
                                           "1e30", "nan", ""};

// Replaces a number of the text, or some bytes, or cuts the file.
std::string mutate(std::string text, std::mt19937& random) {
  const auto below = [&random](std::size_t n) { return static_cast<std::size_t>(random() % n); };
  const std::size_t at = below(text.size());
  switch (below(4)) {
    case 0: {
      const std::size_t number = text.find_first_of("0123456789", at);
      if (number == std::string::npos) return text.substr(0, at);
      const std::size_t end = text.find_first_not_of("0123456789.", number);
      return text.replace(number, end - number, kBadNumbers[below(kBadNumbers.size())]);
    }
    case 1:
      for (std::size_t i = at; i < std::min(at + 4, text.size()); ++i) text[i] = static_cast<char>(random());
      return text;
    case 2:
      return text.erase(at, 1 + below(8));
    default:
      return text.substr(0, at);
  }
}

// A program in the place of acus-mesh; descriptor 3 takes the answer.
std::string write_program(const TemporaryFolder& folder, const std::string& script) {
  const std::string path = folder.write("program", "#!/bin/sh\n" + script + "\n");
  std::filesystem::permissions(path, std::filesystem::perms::owner_all);
  return path;
}

std::string program_error(const std::string& script, const MeshReadingLimits& limits = {}) {
  const TemporaryFolder folder;
  const std::string program = write_program(folder, script);
  const std::string mesh = folder.write(kMsh2.name, kMsh2.text);
  return error_of([&] { decode_mesh_answer(run_mesh_program(program, mesh, limits)); });
}

std::string read_error(const MeshFile& file, const MeshReadingLimits& limits = {}) {
  const TemporaryFolder folder;
  const std::string path = folder.write(file.name, file.text);
  return error_of([&] { decode_mesh_answer(run_mesh_program(mesh_program_path(), path, limits)); });
}

std::string decode_error(const std::vector<char>& bytes) {
  return error_of([&bytes] { decode_mesh_answer(bytes); });
}

RawMesh unit_tetrahedron() {
  return {"Gmsh 2.2", {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 1, 2, 3}, {{"", 2, "liver", {0}}}, {"a note"}};
}

}  // namespace

TEST_CASE("the program reads every format" * doctest::test_suite("gate")) {
  for (const MeshFile& file : kMeshFiles) {
    CAPTURE(file.name);
    const TemporaryFolder folder;
    const TetrahedralMesh mesh = read_mesh_file(folder.write(file.name, file.text), 0.5);
    CHECK(mesh.node_count() == 4);
    CHECK(rest_volume(mesh, 0) == doctest::Approx(0.125 / 6));
  }
}

TEST_CASE("of TetGen's two files either may be named, and the other is beside it") {
  const TemporaryFolder folder;
  const std::string nodes = folder.write(test::kTetgenNodes.name, test::kTetgenNodes.text);
  CHECK(contains(error_of([&] { read_mesh_file(nodes, 1); }), "the .ele file is not beside the other one"));
  const std::string elements = folder.write(test::kTetgenElements.name, test::kTetgenElements.text);
  for (const std::string& path : {nodes, elements}) CHECK(read_mesh_file(path, 1).tetrahedron_count() == 1);
}

TEST_CASE("damaged meshes are refused, and the program goes on" * doctest::test_suite("gate")) {
  constexpr int kMutants = 4;
  std::mt19937 random(1);
  const TemporaryFolder own;
  setenv("TMPDIR", own.path().c_str(), 1);
  for (const MeshFile& file : kMeshFiles) {
    for (int i = 0; i < kMutants; ++i) {
      const TemporaryFolder folder;
      const std::string path = folder.write(file.name, mutate(file.text, random));
      const std::string error = error_of([&path] { read_mesh_file(path, 1); });
      CAPTURE(error);
      CHECK((error == "no error" || error.starts_with(path + ": ")));
    }
  }
  unsetenv("TMPDIR");
  CHECK(std::filesystem::is_empty(own.path()));
  CHECK(waitpid(-1, nullptr, WNOHANG) == -1);
  CHECK(errno == ECHILD);
}

TEST_CASE("a mesh that crashes the program becomes an error") {
  CHECK(program_error("kill -SEGV $$")
            .starts_with("acus-mesh crashed while it read the file (signal 11, Segmentation fault"));
  CHECK(program_error("exit 3").starts_with("acus-mesh, which reads it, stopped with status 3"));
  CHECK(contains(program_error("kill -KILL $$"), "was killed, perhaps for want of memory"));
  CHECK(contains(program_error("kill -XCPU $$"), "more than 60 s of processor time"));
}

TEST_CASE("reading has limits") {
  MeshReadingLimits limits;
  SUBCASE("file") {
    limits.file_bytes = 10;
    CHECK(read_error(kMsh2, limits) ==
          "expected a file of at most 10 bytes, found " + std::to_string(kMsh2.text.size()));
  }
  SUBCASE("time") {
    limits.time = std::chrono::milliseconds(100);
    CHECK(contains(program_error("exec sleep 1000", limits), "took longer than 0 s and was stopped"));
    CHECK(contains(program_error("exec 3>&-; exec sleep 1000", limits), "took longer than 0 s and was stopped"));
  }
  SUBCASE("answer") {
    limits.answer_bytes = 1'000'000;
    CHECK(contains(program_error("exec cat /dev/zero >&3", limits), "does not end"));
  }
  // These go together with the program's arguments.
  SUBCASE("memory") {
    limits.memory_bytes = 123'000'000;
    limits.processor_seconds = 7;
    CHECK(program_error("test \"$2\" = 123000000 && test \"$3\" = 7 && exit 5", limits).find("status 5") !=
          std::string::npos);
  }
}

TEST_CASE("a mesh that asks for much memory does not get it") {
  MeshFile huge = kMsh2;
  huge.text.replace(huge.text.find("$Nodes\n4\n"), 9, "$Nodes\n2000000000\n");
  CHECK(read_error(huge) != "no error");
}

TEST_CASE("the reading program gets nothing that is not for it") {
  const int leaked = open("/dev/null", O_RDONLY);  // without O_CLOEXEC
  sigset_t blocked, before;
  sigemptyset(&blocked);
  sigaddset(&blocked, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &blocked, &before);
  setenv("ACUS_TEST_VARIABLE", "1", 1);
  const char* script =
      "test -n \"$ACUS_TEST_VARIABLE\" && exit 11\n"
      "test -n \"$HOME\" && exit 12\n"
      "test \"$1\" = b.msh || exit 13\n"
      "test \"$(head -n 1)\" = '$MeshFormat' || exit 14\n"
      "grep -q '^SigBlk:.*0000000000000000$' /proc/self/status || exit 15\n"
      "test -z \"$(head -c 1 <&4)\" || exit 17\n"
      "for f in 5 6 7 8 9 11 12 13 14 15; do test -e /proc/self/fd/$f && exit 16; done\n"
      "exit 42";
  CHECK(contains(program_error(script), "stopped with status 42"));
  unsetenv("ACUS_TEST_VARIABLE");
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  close(leaked);
}

TEST_CASE("without the reading program the error says what to do") {
  const TemporaryFolder folder;
  const std::string mesh = folder.write(kMsh2.name, kMsh2.text);
  const std::string missing = folder.path() + "/acus-mesh";
  const std::string error = error_of([&] { run_mesh_program(missing, mesh, {}); });
  CHECK(error ==
        "the program " + missing +
            ", which reads meshes, cannot be started (No such file or directory); build or install acus-mesh in "
            "the folder of this program");
}

TEST_CASE("a pipe in the place of a mesh file is not waited for") {
  const TemporaryFolder folder;
  const std::string path = folder.path() + "/a.msh";
  REQUIRE(mkfifo(path.c_str(), 0600) == 0);
  const std::string found = "expected a mesh file, found: no regular file, but a folder, a pipe, a socket or a device";
  CHECK(error_of([&path] { run_mesh_program(mesh_program_path(), path, {}); }) == found);
  CHECK(error_of([&path] { read_mesh_file(path, 1); }) == path + ": " + found);
}

TEST_CASE("an answer is what was encoded") {
  const RawMesh mesh = unit_tetrahedron();
  const RawMesh read = decode_mesh_answer(encode_mesh(mesh));
  CHECK(read.coordinates == mesh.coordinates);
  CHECK(read.tetrahedra == mesh.tetrahedra);
  CHECK(read.format == mesh.format);
  CHECK(read.groups == mesh.groups);
  CHECK(read.notes == mesh.notes);
  CHECK(decode_error(encode_mesh_error("no\x1b good")) == "no? good");
  CHECK(decode_error(encode_mesh_error("K\xc3\xb6rper \xc2\x9b \xff\xe2\x82")) == "K\xc3\xb6rper ?? ???");
  CHECK(decode_error(encode_mesh_error(std::string(5000, 'x'))) == std::string(1000, 'x'));
}

TEST_CASE("a truncated answer is refused, and so is one with more bytes") {
  for (std::vector<char> bytes : {encode_mesh(unit_tetrahedron()), encode_mesh_error("what is wrong")}) {
    for (std::size_t size = 0; size < bytes.size(); ++size) {
      CHECK(decode_error({bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size)})
                .starts_with("the answer of acus-mesh is wrong: "));
    }
    bytes.push_back(0);
    CHECK(contains(decode_error(bytes), "expected its end, found 1 more bytes"));
  }
}

TEST_CASE("an answer that lies is refused") {
  const auto refused = [](const auto& change) {
    RawMesh mesh = unit_tetrahedron();
    change(mesh);
    return decode_error(encode_mesh(mesh));
  };
  CHECK(contains(refused([](RawMesh& mesh) { mesh.tetrahedra[2] = 4; }), "names a node that is not there"));
  CHECK(contains(refused([](RawMesh& mesh) { mesh.tetrahedra[2] = -1; }), "names a node that is not there"));
  for (const std::vector<int>& members : {std::vector{-1}, {1}, {0, 0}})
    CHECK(contains(refused([&](RawMesh& mesh) { mesh.groups[0].members = members; }), "of a group"));
  CHECK(contains(refused([](RawMesh& mesh) { mesh.groups[0].members.clear(); }), "a group is empty"));
  CHECK(contains(refused([](RawMesh& mesh) { mesh.tetrahedra.pop_back(); }), "answer of acus-mesh is wrong"));
  CHECK(contains(refused([](RawMesh& mesh) { mesh = {}; }), "it holds no tetrahedra"));
  for (const double bad : {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()}) {
    CHECK(refused([bad](RawMesh& mesh) { mesh.coordinates[5] = bad; }) == "node 1 has a coordinate that is not finite");
  }
  // Every eight bytes of counts and sizes in it, as large as can be.
  const std::vector<char> good = encode_mesh(unit_tetrahedron());
  const std::size_t counts = 3 * 8 + std::strlen("Gmsh 2.2");
  for (std::size_t at :
       {std::size_t{0}, std::size_t{8}, std::size_t{16}, counts, counts + 8, counts + 16, counts + 24}) {
    std::vector<char> bytes = good;
    std::memset(bytes.data() + at, 0xff, 8);
    CHECK(decode_error(bytes).starts_with("the answer of acus-mesh is wrong: "));
  }
}

TEST_CASE("an answer with any byte changed is refused or a mesh in range") {
  const std::vector<char> good = encode_mesh(unit_tetrahedron());
  for (std::size_t i = 0; i < good.size(); ++i) {
    for (const int value : {0, 1, 0x7f, 0x80, 0xff}) {
      std::vector<char> bytes = good;
      bytes[i] = static_cast<char>(value);
      try {
        const RawMesh mesh = decode_mesh_answer(bytes);
        CHECK(mesh.coordinates.size() == 12);
        for (const MeshGroup& group : mesh.groups) CHECK(group.members == std::vector<int>{0});
      } catch (const MeshError&) {
      }
    }
  }
}

}  // namespace acus
