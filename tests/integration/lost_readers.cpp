// SPDX-License-Identifier: GPL-3.0-or-later
// Programs go on when nobody reads what they print any more.
#include <doctest/doctest.h>
#include <signal.h>

#include <filesystem>

#include "tests/integration/printed.h"
#include "tests/support/places.h"

namespace acus::testing {

TEST_CASE("the server outlives the reader of its log") {
  ServerProcess none({"--check"});
  REQUIRE(none.process().wait(kPatience) == 0);
  Printed server(none.command_line({}));
  server.read_line();
  server.stop_reading();
  client::CommandLink commands(none.commands());
  commands.load(none.scene(), kPatience);  // which the server logs
  commands.load(none.scene(), kPatience);
  CHECK(commands.hello(kPatience).scene == "small");
  server.process().send_signal(SIGTERM);
  CHECK(server.process().wait(kPatience) == 0);
}

TEST_CASE("acus-replay writes its files to the end and returns 0 without a reader") {
  ServerProcess server({"--lockstep"});
  const std::string motion = server.folder().write("motion.csv",
                                                   "t,needle,x,y,z,qw,qx,qy,qz\n"
                                                   "0,needle,0,0,0.5,1,0,0,0\n"
                                                   "0.1,needle,0,0,0.5,1,0,0,0\n");
  const std::string out = server.folder() / "run.csv";
  Printed replay({program_path("acus-replay"), motion, "--commands", server.commands(), "--states", server.states(),
                  "--lockstep", "--out", out});
  replay.stop_reading();
  CHECK(replay.process().wait(kPatience) == 0);
  CHECK(std::filesystem::file_size(out) > 1000);
}

}  // namespace acus::testing
