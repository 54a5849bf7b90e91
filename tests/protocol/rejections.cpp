// SPDX-License-Identifier: GPL-3.0-or-later
// Each way in which a message can be wrong has its own error code. Wrong messages are made with msgpack itself, so that
// the encoder under test cannot hide them.
#include <doctest/doctest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <msgpack.hpp>

#include "protocol/codec.h"

namespace acus::protocol {
namespace {

using Packer = msgpack::packer<msgpack::sbuffer>;
using Values = std::map<std::string, std::function<void(Packer&)>>;

template <class T>
std::function<void(Packer&)> value(const T& x) {
  return [x](Packer& packer) { packer.pack(x); };
}

Values good_pose() {
  return {{"v", value(kVersion)},
          {"type", value(std::string("pose"))},
          {"needle", value(std::string("needle"))},
          {"seq", value(7)},
          {"time", value(0.5)},
          {"position", value(std::vector<double>{0, 0, 0})},
          {"orientation", value(std::vector<double>{1, 0, 0, 0})}};
}

std::string pack(const Values& values) {
  msgpack::sbuffer buffer;
  Packer packer(buffer);
  packer.pack_map(static_cast<std::uint32_t>(values.size()));
  for (const auto& [key, pack_value] : values) {
    packer.pack(key);
    pack_value(packer);
  }
  return {buffer.data(), buffer.size()};
}

template <class T>
std::string pose_with(const std::string& key, const T& x) {
  Values values = good_pose();
  values[key] = value(x);
  return pack(values);
}

std::string pose_without(const std::string& key) {
  Values values = good_pose();
  values.erase(key);
  return pack(values);
}

std::string rejection(const std::string& bytes) {
  try {
    decode_command(bytes);
    return "accepted";
  } catch (const DecodeError& error) {
    CHECK(std::string(error.what()).size() > 10);
    return name_of(error.code());
  }
}

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

}  // namespace

TEST_CASE("JSON in place of msgpack is named") {
  const auto told = [](const std::string& bytes) -> std::string {
    try {
      decode_command(bytes);
    } catch (const DecodeError& error) {
      return error.what();
    }
    return "accepted";
  };
  for (const char* json : {R"({"v": 2, "type": "hello", "seq": 1})", "{}", " {\n  \"v\": 2\n}", R"([{"v": 2}])",
                           "\xef\xbb\xbf{\"v\":2}", "{'v': 2}"}) {
    CAPTURE(json);
    CHECK(rejection(json) == "trailing_bytes");
    CHECK(told(json).find("the message is JSON; send it as msgpack") == 0);
  }
  CHECK(told("{a") == "the message goes on after its map");
  CHECK(told(std::string(2, '\x01')) == "the message goes on after its map");
}

TEST_CASE("a good message is accepted, with unknown fields and integers for numbers") {
  CHECK(rejection(pack(good_pose())) == "accepted");
  CHECK(rejection(pose_with("colour", std::string("red"))) == "accepted");
  CHECK(rejection(pose_with("position", std::vector<int>{1, -2, 3})) == "accepted");
  CHECK(rejection(pose_with("time", 1.5f)) == "accepted");
  CHECK(rejection(pose_with("spin", 12.5)) == "accepted");
}

TEST_CASE("truncated") {
  const std::string bytes = pack(good_pose());
  for (std::size_t size = 0; size < bytes.size(); ++size) CHECK(rejection(bytes.substr(0, size)) == "truncated");
}

TEST_CASE("trailing_bytes") { CHECK(rejection(pack(good_pose()) + '\0') == "trailing_bytes"); }

TEST_CASE("oversized") {
  CHECK(rejection(pose_with("needle", std::string(kMaxCommandBytes, 'x'))) == "oversized");
  CHECK(rejection(pose_with("needle", std::string(kMaxCommandBytes - 1000, 'x'))) == "accepted");
}

TEST_CASE("a snapshot may be larger than other messages, up to a limit") {
  Restore restore;
  restore.snapshot.resize(kMaxCommandBytes);
  CHECK(rejection(encode(restore)) == "accepted");
  restore.snapshot.resize(kMaxRestoreBytes);
  CHECK(rejection(encode(restore)) == "oversized");
  // What only says that it is one, and is large by what else is in it.
  std::string bytes = "\x83\xa1v\x01\xa4type\xa7restore\xa1x\xdd";
  const std::uint32_t count = 2 << 20;
  for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(count >> shift & 0xff);
  bytes += std::string(count, '\x00');
  CHECK(rejection(bytes) == "oversized");
}

TEST_CASE("too_complex: nested too deep, or claiming elements that are not there") {
  CHECK(rejection(std::string(100000, '\x91')) == "too_complex");
  CHECK(rejection(std::string("\xdd\x7f\xff\xff\xff", 5)) == "too_complex");
  CHECK(rejection(std::string("\xdf\x7f\xff\xff\xff", 5)) == "too_complex");
}

TEST_CASE("strings and binary data that claim more bytes than there are cost nothing") {
  CHECK(rejection(std::string("\xdb\x7f\xff\xff\xff", 5)) == "truncated");
  CHECK(rejection(std::string("\xc6\x7f\xff\xff\xff", 5)) == "truncated");
}

TEST_CASE("invalid_msgpack") { CHECK(rejection("\xc1") == "invalid_msgpack"); }

TEST_CASE("not_a_map") {
  CHECK(rejection("\x01") == "not_a_map");
  CHECK(rejection("\x90") == "not_a_map");
  CHECK(rejection("\xa1p") == "not_a_map");
}

TEST_CASE("wrong_version") {
  CHECK(rejection(pose_with("v", 0)) == "wrong_version");
  CHECK(rejection(pose_with("v", 1)) == "wrong_version");
  CHECK(rejection(pose_with("v", 3)) == "wrong_version");
}

TEST_CASE("a hello is taken if a version of its range is spoken here") {
  const auto hello = [](std::uint64_t newest, std::optional<std::uint64_t> oldest) {
    Values values{{"v", value(newest)}, {"type", value(std::string("hello"))}, {"seq", value(7)}};
    if (oldest) values["oldest_version"] = value(*oldest);
    return pack(values);
  };
  for (const std::string& bytes : {hello(2, {}), hello(2, 1), hello(3, 2), hello(9, 1)})
    CHECK(std::get<Hello>(decode_command(bytes)).seq == 7);
  for (const std::string& bytes : {hello(1, {}), hello(3, {}), hello(1, 0), hello(9, 3)}) {
    CAPTURE(bytes);
    CHECK(rejection(bytes) == "wrong_version");
  }
  try {
    decode_command(hello(5, 3));
    FAIL("no error");
  } catch (const DecodeError& error) {
    CHECK(std::string(error.what()).starts_with("protocol version 3 to 5 is not spoken here, but 2;"));
    CHECK(error.seq == 7);
  }
}

TEST_CASE("unknown_type") {
  CHECK(rejection(pose_with("type", std::string("possum"))) == "unknown_type");
  CHECK(rejection(encode(Done{})) == "unknown_type");
}

TEST_CASE("missing_field") {
  for (const auto& [key, unused] : good_pose()) {
    CAPTURE(key);
    CHECK(rejection(pose_without(key)) == "missing_field");
  }
}

TEST_CASE("wrong_field_type") {
  CHECK(rejection(pose_with("v", std::string("1"))) == "wrong_field_type");
  CHECK(rejection(pose_with("type", 3)) == "wrong_field_type");
  CHECK(rejection(pose_with("needle", 3)) == "wrong_field_type");
  CHECK(rejection(pose_with("seq", 1.5)) == "wrong_field_type");
  CHECK(rejection(pose_with("time", std::string("now"))) == "wrong_field_type");
  CHECK(rejection(pose_with("position", 3)) == "wrong_field_type");
  CHECK(rejection(pose_with("position", std::vector<double>{1, 2})) == "wrong_field_type");
  CHECK(rejection(pose_with("position", std::vector<std::string>{"1", "2", "3"})) == "wrong_field_type");
  CHECK(rejection(pose_with("orientation", std::vector<double>{1, 0, 0})) == "wrong_field_type");
  CHECK(rejection(pose_with("spin", msgpack::type::nil_t())) == "wrong_field_type");
}

TEST_CASE("not_finite") {
  for (double bad : {kNan, kInfinity, -kInfinity}) {
    CHECK(rejection(pose_with("time", bad)) == "not_finite");
    CHECK(rejection(pose_with("spin", bad)) == "not_finite");
    CHECK(rejection(pose_with("position", std::vector<double>{0, bad, 0})) == "not_finite");
    CHECK(rejection(pose_with("orientation", std::vector<double>{1, bad, 0, 0})) == "not_finite");
  }
  TissueShape shape;
  shape.positions = {0, std::numeric_limits<float>::quiet_NaN(), 0};
  CHECK_THROWS_AS(decode_state(encode(shape)), DecodeError);
}

TEST_CASE("not_unit_quaternion") {
  CHECK(rejection(pose_with("orientation", std::vector<double>{0, 0, 0, 0})) == "not_unit_quaternion");
  CHECK(rejection(pose_with("orientation", std::vector<double>{1.0011, 0, 0, 0})) == "not_unit_quaternion");
  CHECK(rejection(pose_with("orientation", std::vector<double>{0.5, 0.5, 0.5, 0.49})) == "not_unit_quaternion");
  CHECK(rejection(pose_with("orientation", std::vector<double>{1e300, 1e300, 0, 0})) == "not_unit_quaternion");
}

TEST_CASE("bad_value") {
  CHECK(rejection(pose_with("seq", 0)) == "bad_value");
  CHECK(rejection(pose_with("seq", -1)) == "bad_value");
  for (std::uint32_t ticks : {0u, kMaxStepTicks + 1}) {
    Step step;
    step.ticks = ticks;
    CHECK(rejection(encode(step)) == "bad_value");
  }
  Values step{
      {"v", value(kVersion)}, {"type", value(std::string("step"))}, {"seq", value(1)}, {"ticks", value(1ull << 40)}};
  CHECK(rejection(pack(step)) == "bad_value");
}

TEST_CASE("bad_value: positions outside the workspace, and spins beyond all use") {
  const auto position = [](double x) { return pose_with("position", std::vector<double>{0, 0, x}); };
  const auto spin = [](double angle) {
    Spin message;
    message.spin = angle;
    return encode(message);
  };
  for (const double sign : {1.0, -1.0}) {
    CHECK(rejection(position(sign * kMaxPosition)) == "accepted");
    CHECK(rejection(position(sign * std::nextafter(kMaxPosition, kInfinity))) == "bad_value");
    CHECK(rejection(position(sign * 1e308)) == "bad_value");
    CHECK(rejection(spin(sign * kMaxSpin)) == "accepted");
    CHECK(rejection(spin(sign * std::nextafter(kMaxSpin, kInfinity))) == "bad_value");
    CHECK(rejection(spin(sign * 1e307)) == "bad_value");
    CHECK(rejection(pose_with("spin", sign * kMaxSpin)) == "accepted");
    CHECK(rejection(pose_with("spin", sign * 1e307)) == "bad_value");
  }
  CHECK_THROWS_WITH_AS(decode_command(position(1e308)), "field 'position' must be in [-100, 100] m, found 1e+308",
                       DecodeError);
  CHECK_THROWS_WITH_AS(decode_command(spin(-1e307)), "field 'spin' must be in [-1e+06, 1e+06] rad, found -1e+307",
                       DecodeError);
}

TEST_CASE("packed arrays must hold whole elements") {
  Values shape{
      {"v", value(kVersion)}, {"type", value(std::string("tissue"))},
      {"epoch", value(1)},    {"tick", value(1)},
      {"time", value(0.0)},   {"positions", [](Packer& packer) { packer.pack_bin(5).pack_bin_body("12345", 5); }}};
  try {
    decode_state(pack(shape));
    FAIL("accepted");
  } catch (const DecodeError& error) {
    CHECK(error.code() == ErrorCode::wrong_field_type);
  }
}

TEST_CASE("a rejection tells which message it was, as far as that can be read") {
  try {
    decode_command(pose_with("position", 3));
    FAIL("accepted");
  } catch (const DecodeError& error) {
    CHECK(error.type == "pose");
    CHECK(error.seq == 7);
    CHECK(std::string(error.what()).find("'position'") != std::string::npos);
  }
  try {
    decode_command("\xc1");
    FAIL("accepted");
  } catch (const DecodeError& error) {
    CHECK_FALSE(error.type.has_value());
    CHECK_FALSE(error.seq.has_value());
  }
}

}  // namespace acus::protocol
