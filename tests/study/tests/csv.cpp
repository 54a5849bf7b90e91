// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/study/studies/csv.h"

#include <doctest/doctest.h>

#include <cmath>
#include <stdexcept>

#include "tests/support/file_content.h"
#include "tests/support/temporary_folder.h"

namespace acus {
namespace {

TEST_CASE("a table holds what was written at every moment") {
  const TemporaryFolder folder;
  const std::string path = folder.path() + "/table.csv";
  CsvFile table(path, {"what", "number", "count", "pass"});
  table.row({"a, \"quoted\" word", 1.0 / 3, 7, true});
  table.row({"plain", std::nan(""), 0, false});
  CHECK(content_of(path) ==
        "what,number,count,pass\n"
        "\"a, \"\"quoted\"\" word\",0.333333,7,yes\n"
        "plain,,0,no\n");
}

TEST_CASE("a table that cannot be written is an error that names the file") {
  CHECK_THROWS_WITH_AS(CsvFile("/no/such/folder/table.csv", {"a"}),
                       "/no/such/folder/table.csv cannot be written; does its folder exist?", std::runtime_error);
}

}  // namespace
}  // namespace acus
