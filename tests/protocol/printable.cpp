// SPDX-License-Identifier: GPL-3.0-or-later
#include "protocol/printable.h"

#include <doctest/doctest.h>

namespace acus::protocol {

TEST_CASE("control characters are shown, text stays") {
  CHECK(printable("liver, \xc3\xbc and \xc2\xb5") == "liver, \xc3\xbc and \xc2\xb5");
  CHECK(printable("\x1b[2J\r\t\x7f") == "\\x1b[2J\\x0d\\x09\\x7f");
  CHECK(printable("\xc2\x9b"
                  "2J") == "\\x9b2J");
  CHECK(printable(std::string_view("\0", 1)) == "\\x00");
  CHECK(printable("\xc2") == "\xc2");
  CHECK(printable("a\nb") == "a\\nb");
  CHECK(printable("a\nb", Newlines::kept) == "a\nb");
}

}  // namespace acus::protocol
