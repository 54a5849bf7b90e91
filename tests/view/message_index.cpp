// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/view/message_index.h"

#include <doctest/doctest.h>

#include <fstream>
#include <string>
#include <vector>

#include "protocol/codec.h"
#include "tests/support/temporary_folder.h"

using namespace acus;
using namespace acus::view;

namespace {

std::string force(const std::string& needle, double newtons) {
  protocol::Force state;
  state.needle = needle;
  state.base_force = {newtons, 0, 0};
  return protocol::encode(state);
}

std::string shape(const std::string& needle) {
  protocol::NeedleShape state;
  state.needle = needle;
  return protocol::encode(state);
}

std::string event() {
  protocol::Event state;
  state.kind = protocol::EventKind::puncture;
  return protocol::encode(state);
}

// As acus-export writes a run: two frames, the second with an event.
std::vector<std::string> messages() {
  return {protocol::encode(protocol::HelloReply{}),
          protocol::encode(protocol::DescribeReply{}),
          force("a", 1),
          force("b", 2),
          shape("a"),
          shape("b"),
          protocol::encode(protocol::TissueShape{}),
          event(),
          force("a", 3),
          force("a", 4),
          force("b", 5),
          shape("a"),
          shape("b"),
          protocol::encode(protocol::TissueShape{})};
}

std::string frame(MessageIndex& index, std::size_t number) {
  std::string told;
  index.visit(number, [&](const Frame& each) {
    told +=
        each.topic + each.needle + (each.topic == "force" ? std::to_string(static_cast<int>(each.force)) : "") + " ";
  });
  return told;
}

}  // namespace

TEST_CASE("messages are told by frames, in the order in which they stand") {
  const TemporaryFolder folder;
  std::string all;
  for (const std::string& message : messages()) all += message;
  MessageIndex index(folder.write("run", all));
  CHECK(index.read_on());
  CHECK_FALSE(index.read_on());
  CHECK(index.hello() == messages()[0]);
  CHECK(index.describe() == messages()[1]);
  CHECK(index.frames() == 1);  // the other may still grow
  index.close();
  REQUIRE(index.frames() == 2);
  CHECK(frame(index, 0) == "forcea1 forceb2 needlea needleb tissue ");
  CHECK(frame(index, 1) == "event forcea3 forcea4 forceb5 needlea needleb tissue ");
}

TEST_CASE("a file that grows byte by byte is read as far as it is whole") {
  const TemporaryFolder folder;
  const std::string path = folder / "run";
  MessageIndex index(path);
  CHECK_FALSE(index.read_on());
  std::string all;
  for (const std::string& message : messages()) all += message;
  std::ofstream file(path, std::ios::binary);
  for (const char byte : all) {
    file.put(byte);
    file.flush();
    index.read_on();
    CHECK(index.frames() <= 1);
  }
  index.close();
  REQUIRE(index.frames() == 2);
  CHECK(frame(index, 1) == "event forcea3 forcea4 forceb5 needlea needleb tissue ");
}

TEST_CASE("of the past every event is told, and of forces the last of some frames") {
  const TemporaryFolder folder;
  std::string all = messages()[0] + messages()[1];
  for (int i = 0; i < 10; ++i) all += (i % 4 == 1 ? event() : "") + force("a", i) + force("a", i + 0.5) + shape("a");
  MessageIndex index(folder.write("run", all));
  index.read_on();
  index.close();
  REQUIRE(index.frames() == 10);
  std::string told;
  index.visit_history(4, 9, 2, [&](const Frame& each) {
    told += each.topic == "event" ? "! " : std::to_string(each.force).substr(0, 3) + " ";
  });
  CHECK(told == "! 4.5 ! 6.5 8.5 ");
}
