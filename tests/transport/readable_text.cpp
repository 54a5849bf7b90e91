// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/transport/readable_text.h"

#include <doctest/doctest.h>

namespace acus::test {

TEST_CASE("what a client sent is told back as UTF-8, and not at any length") {
  CHECK(readable("needle 'für'\n", 100) == "needle 'für'\n");
  CHECK(readable("\xff\xfe\xfd", 100) == "\uFFFD\uFFFD\uFFFD");
  CHECK(readable("a\xc3", 100) == "a\uFFFD");
  CHECK(readable(std::string(500000, 'x'), 10) == "xxxxxxxxxx...");
  CHECK(readable("ü", 1) == "\uFFFD...");
  CHECK(readable("", 10).empty());
}

}  // namespace acus::test
