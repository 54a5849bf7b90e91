// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/own_file.h"

#include <doctest/doctest.h>
#include <sys/stat.h>

#include <filesystem>

#include "tests/support/temporary_folder.h"

namespace acus::protocol {

TEST_CASE("an own file may be replaced, an empty one, and what is not there") {
  const TemporaryFolder folder;
  const IsOwn is_own = beginning_with("t,x\n");
  CHECK_FALSE(holds_another_file(folder.write("own", "t,x\n1,2\n"), is_own));
  CHECK_FALSE(holds_another_file(folder.write("empty", ""), is_own));
  CHECK_FALSE(holds_another_file(folder / "absent", is_own));
  CHECK_FALSE(holds_another_file(folder / "absent/absent", is_own));
  std::filesystem::create_symlink(folder / "absent", folder / "dangling");
  CHECK_FALSE(holds_another_file(folder / "dangling", is_own));
}

TEST_CASE("another's file may not be replaced, by whatever name") {
  const TemporaryFolder folder;
  const IsOwn is_own = beginning_with("t,x\n");
  for (const char* text : {"t", "t,x", "t,xy\n1,2\n", " t,x\n", "{}"}) {
    CAPTURE(text);
    CHECK(holds_another_file(folder.write("other", text), is_own));
  }
  std::filesystem::create_symlink("other", folder / "link");
  CHECK(holds_another_file(folder / "link", is_own));
  CHECK(holds_another_file(folder.path(), is_own));
}

TEST_CASE("pipes and devices keep nothing that could be lost; nobody waits for a pipe") {
  const TemporaryFolder folder;
  REQUIRE(mkfifo((folder / "pipe").c_str(), 0600) == 0);
  CHECK_FALSE(holds_another_file(folder / "pipe", beginning_with("t,x\n")));
  CHECK_FALSE(holds_another_file("/dev/null", beginning_with("t,x\n")));
}

TEST_CASE("JSON of Acus tells so in its first field") {
  CHECK(json_of_acus()("{\n  \"written_by\": \"Acus\",\n"));
  CHECK_FALSE(json_of_acus()("{\n  \"scene\": \"Acus\",\n"));
}

}  // namespace acus::protocol
