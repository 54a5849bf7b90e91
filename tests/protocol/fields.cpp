// SPDX-License-Identifier: GPL-3.0-or-later
// A member that its fields() leaves out would be neither sent nor read.
#include <doctest/doctest.h>

#include <optional>
#include <variant>

#include "protocol/messages.h"
#include "tests/support/covers.h"

namespace acus::test {

namespace {

struct Whole {
  int a = 0;
  double b = 0;

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("a", self.a);
    visit("b", self.b);
  }
};

struct Holed {
  int a = 0;
  double b = 0, c = 0;

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("a", self.a);
    visit("c", self.c);
  }
};

struct Short {
  int a = 0;
  double b = 0;

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("a", self.a);
  }
};

template <class... Messages>
void check_all(const std::variant<Messages...>*) {
  const auto check = []<class Message>(const Message*) {
    CAPTURE(Message::kType);
    CHECK(gap_in_fields<Message>() == "");
  };
  (check(static_cast<const Messages*>(nullptr)), ...);
}

}  // namespace

TEST_CASE("a gap is found") {
  CHECK(gap_in_fields<Whole>() == "");
  CHECK(gap_in_fields<Holed>() == "a");
  CHECK(gap_in_fields<Short>() == "a");
}

TEST_CASE("every message names all its members, and so do the parts of messages") {
  check_all(static_cast<const protocol::Command*>(nullptr));
  check_all(static_cast<const protocol::Reply*>(nullptr));
  check_all(static_cast<const protocol::State*>(nullptr));
  CHECK(gap_in_fields<protocol::NeedleInfo>() == "");
  CHECK(gap_in_fields<protocol::TissueInfo>() == "");
  CHECK(gap_in_fields<protocol::TopicInfo>() == "");
}

}  // namespace acus::test
