// SPDX-License-Identifier: GPL-3.0-or-later
// What is encoded comes back as it was, for every message; and looks on the wire as the contract says.
#include <doctest/doctest.h>

#include <msgpack.hpp>

#include "tests/protocol/random_message.h"

namespace acus::protocol::testing {
namespace {

// Decoding normalises quaternions, which may move a component's last bit; the second trip must not move anything.
template <class Variant>
void check_round_trips() {
  Random random(1);
  for (int repetition = 0; repetition < 200; ++repetition) {
    for_each_message<Variant>(random, [](const auto& message) {
      using Message = std::remove_cvref_t<decltype(message)>;
      CAPTURE(to_text(message));
      const Variant decoded = decode<Variant>(encode(message));
      REQUIRE(std::holds_alternative<Message>(decoded));
      CHECK(to_text(std::get<Message>(decoded)) == to_text(message));
      const std::string settled = encode(std::get<Message>(decoded));
      CHECK(settled.size() == encode(message).size());
      const Variant again = decode<Variant>(settled);
      CHECK(to_text(std::get<Message>(again)) == to_text(message));
    });
  }
}

}  // namespace

TEST_CASE("every command round-trips") { check_round_trips<Command>(); }
TEST_CASE("every reply round-trips") { check_round_trips<Reply>(); }
TEST_CASE("every state round-trips") { check_round_trips<State>(); }

TEST_CASE("numbers and packed arrays come back bit by bit") {
  NeedleShape shape;
  shape.tick = std::uint64_t{1} << 63;
  shape.time = 0.1 + 0.2;
  shape.positions = {1.0 / 3, -0.0, 1e-300};
  const auto back = std::get<NeedleShape>(decode_state(encode(shape)));
  CHECK(back.tick == shape.tick);
  CHECK(back.time == shape.time);
  CHECK(back.positions == shape.positions);
  CHECK(std::signbit(back.positions[1]));

  DescribeReply describe;
  describe.positions = {0.1f, -2.5f, 3e-30f};
  describe.tetrahedra = {0, -1, 2147483647, -2147483647 - 1};
  describe.region_colours = {"", "#c08060"};
  const auto described = std::get<DescribeReply>(decode_reply(encode(describe)));
  CHECK(described.positions == describe.positions);
  CHECK(described.tetrahedra == describe.tetrahedra);
  CHECK(described.region_colours == describe.region_colours);
}

TEST_CASE("a message is one map that opens with version and type") {
  Pose pose;
  pose.needle = "left";
  pose.position = {1, 2, 3};
  const std::string bytes = encode(pose);
  const msgpack::object_handle handle = msgpack::unpack(bytes.data(), bytes.size());
  const msgpack::object& map = handle.get();
  REQUIRE(map.type == msgpack::type::MAP);
  REQUIRE(map.via.map.size == 7);  // v, type and the five fields that a pose must have
  CHECK(map.via.map.ptr[0].key.as<std::string>() == "v");
  CHECK(map.via.map.ptr[0].val.as<int>() == kVersion);
  CHECK(map.via.map.ptr[1].key.as<std::string>() == "type");
  CHECK(map.via.map.ptr[1].val.as<std::string>() == "pose");
  CHECK(map.via.map.ptr[5].key.as<std::string>() == "position");
  CHECK(map.via.map.ptr[5].val.as<std::vector<double>>() == std::vector<double>{1, 2, 3});
}

TEST_CASE("numbers are float64 on the wire even when they are whole") {
  Spin spin;
  spin.spin = 2;
  const std::string bytes = encode(spin);
  const msgpack::object_handle handle = msgpack::unpack(bytes.data(), bytes.size());
  const msgpack::object_map& map = handle.get().via.map;
  CHECK(map.ptr[map.size - 1].val.type == msgpack::type::FLOAT64);
  CHECK(map.ptr[map.size - 1].val.via.f64 == 2);

  spin.spin = -0.0;
  CHECK(std::signbit(std::get<Spin>(decode_command(encode(spin))).spin));
}

TEST_CASE("a quaternion close to unit length is normalised") {
  Pose pose;
  pose.orientation = {1.0009, 0, 0, 0};
  CHECK(std::get<Pose>(decode_command(encode(pose))).orientation == Quaternion{});
}

TEST_CASE("text shows the fields that are there") {
  Spin spin;
  spin.needle = "left";
  spin.spin = 0.5;
  CHECK(to_text(spin) == "spin {needle: \"left\", seq: 1, time: 0, spin: 0.5}");
  CHECK(to_text(Error{{}, "pose", ErrorCode::not_finite, "no"}) ==
        "error {rejected: \"pose\", code: not_finite, message: \"no\"}");
}

}  // namespace acus::protocol::testing
