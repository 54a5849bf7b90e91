// SPDX-License-Identifier: GPL-3.0-or-later
// What programs print: its loss ends those whose result it is with status 4, and names of others move no cursor.
#include <doctest/doctest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <fstream>
#include <iterator>
#include <string>

#include "tests/integration/server_process.h"
#include "tests/support/places.h"

namespace acus::testing {

namespace {

const std::string kNamed = small_scene("\"a\\e[2Jb\\x9b2Jc\"");

int status_of(const std::string& command) { return WEXITSTATUS(std::system(("exec timeout 60 " + command).c_str())); }

std::string content_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

bool moves_no_cursor(const std::string& text) {
  return text.find('\x1b') == std::string::npos && text.find("\xc2\x9b") == std::string::npos;
}

}  // namespace

TEST_CASE("standard output that is full or closed ends what prints its result with status 4") {
  const TemporaryFolder folder;
  const std::string scene = folder.write("small.yaml", small_scene("small"));
  for (const std::string option : {"--schema", "--tables", "--help", "--version", "--json", "--check"}) {
    const bool of_scene = option == "--json" || option == "--check";
    const std::string command = program_path("acus-server") + (of_scene ? " " + scene : "") + " " + option;
    CAPTURE(command);
    CHECK(status_of(command + " > /dev/full 2> /dev/null") == 4);
    CHECK(status_of(command + " >&- 2> /dev/null") == 4);
    CHECK(status_of(command + " > /dev/null 2> /dev/null") == 0);
  }
}

TEST_CASE("escapes in the name of a scene are shown by --check and acus-replay, not sent") {
  ServerProcess server({"--lockstep"}, kNamed);
  const std::string motion =
      server.folder().write("motion.csv", "t,needle,x,y,z,qw,qx,qy,qz\n0,needle,0,0,0.5,1,0,0,0\n");
  const std::string out = server.folder() / "out";
  REQUIRE(status_of(program_path("acus-replay") + " " + motion + " --lockstep --commands " + server.commands() +
                    " --states " + server.states() + " > " + out + " 2>&1") == 0);
  CHECK(content_of(out).find("scene       a\\x1b[2Jb\\x9b2Jc\n") != std::string::npos);
  CHECK(moves_no_cursor(content_of(out)));
  REQUIRE(status_of(program_path("acus-server") + " " + server.scene() + " --check > " + out + " 2>&1") == 0);
  CHECK(content_of(out).find("a\\x1b[2Jb\\x9b2Jc: ") != std::string::npos);
  CHECK(moves_no_cursor(content_of(out)));
}

}  // namespace acus::testing
