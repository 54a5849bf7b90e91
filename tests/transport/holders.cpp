// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/transport/holders.h"

#include <doctest/doctest.h>

using namespace acus;

TEST_CASE("one client at a time holds a body, the same one again and again") {
  Holders holders(2, false);
  CHECK(holders.free_for("a", 0));
  holders.acquire("a", 0);
  CHECK(holders.free_for("a", 0));
  CHECK_FALSE(holders.free_for("b", 0));
  CHECK(holders.free_for("b", 1));
  holders.acquire("b", 1);
  CHECK(holders.holds("a", 0));
  CHECK_FALSE(holders.holds("b", 0));
  CHECK(holders.held_by("b") == std::vector<int>{1});
  holders.release("b", 0);  // not its own
  CHECK(holders.holds("a", 0));
  holders.release_all("a");
  CHECK(holders.free_for("b", 0));
}

TEST_CASE("a shared body has any number of holders") {
  Holders holders(1, true);
  holders.acquire("a", 0);
  CHECK(holders.free_for("b", 0));
  holders.acquire("b", 0);
  holders.release("a", 0);
  CHECK(holders.held(0));
  CHECK_FALSE(holders.holds("a", 0));
}

TEST_CASE("who holds nothing leaves the world alone while others hold something") {
  Holders holders(2, false);
  CHECK(holders.may_change_world("watcher"));
  holders.acquire("a", 0);
  CHECK_FALSE(holders.may_change_world("watcher"));
  CHECK(holders.may_change_world("a"));
  holders.acquire("b", 1);
  CHECK(holders.may_change_world("b"));
  holders.release_all("a");
  holders.release_all("b");
  CHECK(holders.may_change_world("watcher"));
}
