// SPDX-License-Identifier: GPL-3.0-or-later
#include "client/replay/trajectory.h"

#include <doctest/doctest.h>

#include <cmath>
#include <string>

#include "tests/support/places.h"

using acus::client::parse_trajectory;
using acus::client::read_trajectory;
using acus::client::Trajectory;
using acus::client::TrajectoryError;

namespace {

const std::string kHeader = "t,needle,x,y,z,qw,qx,qy,qz,spin\n";

std::string error_of(const std::string& text) {
  try {
    parse_trajectory(text, "file.csv");
  } catch (const TrajectoryError& error) {
    return error.what();
  }
  return "no error";
}

std::string row_error(const std::string& row) { return error_of(kHeader + row + "\n"); }

}  // namespace

TEST_CASE("a trajectory reads its rows and holds its ends") {
  const auto trajectory = parse_trajectory(kHeader + "1,a,0.1,0.2,0.3,1,0,0,0,0\n2,a,0.2,0.4,0.6,1,0,0,0,7\n", "f");
  REQUIRE(trajectory.motions.size() == 1);
  const auto& motion = trajectory.motions[0];
  CHECK(motion.needle == "a");
  CHECK(motion.at(-5).position == std::array{0.1, 0.2, 0.3});
  CHECK(motion.at(99).position == std::array{0.2, 0.4, 0.6});
  CHECK(motion.at(99).spin == 7);
  CHECK(trajectory.begin() == 1);
  CHECK(trajectory.end() == 2);
}

TEST_CASE("position and spin run straight between samples, over many turns") {
  const auto trajectory = parse_trajectory(kHeader + "0,a,0,0,1,1,0,0,0,0\n4,a,8,0,0,1,0,0,0,100\n", "f");
  const auto pose = trajectory.motions[0].at(1);
  CHECK(pose.position[0] == doctest::Approx(2));
  CHECK(pose.position[2] == doctest::Approx(0.75));
  CHECK(pose.spin.value() == doctest::Approx(25));
}

TEST_CASE("orientations turn at a constant rate along the shortest arc, whatever the sign of the quaternion") {
  const double angle = 1.2;  // rad about z
  const auto c = std::to_string(-std::cos(angle / 2));
  const auto s = std::to_string(-std::sin(angle / 2));
  const auto trajectory = parse_trajectory(kHeader + "0,a,0,0,0,1,0,0,0,0\n1,a,0,0,0," + c + ",0,0," + s + ",0\n", "f");
  for (const double u : {0.1, 0.5, 0.8}) {
    const auto q = trajectory.motions[0].at(u).orientation;
    CHECK(std::abs(q[0]) == doctest::Approx(std::cos(u * angle / 2)).epsilon(1e-5));
    CHECK(q[0] * q[3] > 0);
    CHECK(std::abs(q[3]) == doctest::Approx(std::sin(u * angle / 2)).epsilon(1e-5));
  }
}

TEST_CASE("neighbouring orientations that are equal interpolate to themselves") {
  const auto trajectory = parse_trajectory(kHeader + "0,a,0,0,0,0.6,0.8,0,0,0\n1,a,0,0,0,-0.6,-0.8,0,0,0\n", "f");
  const auto q = trajectory.motions[0].at(0.3).orientation;
  CHECK(q[0] == doctest::Approx(0.6));
  CHECK(q[1] == doctest::Approx(0.8));
}

TEST_CASE("columns come in any order, spin may be absent, comments, blanks and CRLF do not matter") {
  const auto trajectory = parse_trajectory(
      "# a comment\r\nneedle, z, y, x, t, qx, qy, qz, qw\r\n\r\nb, 3, 2, 1, 0, 0, 0, 0, 1\r\n# more", "f");
  const auto pose = trajectory.motions.at(0).at(0);
  CHECK(pose.position == std::array{1.0, 2.0, 3.0});
  CHECK(pose.orientation == std::array{1.0, 0.0, 0.0, 0.0});
  CHECK_FALSE(pose.spin.has_value());
}

TEST_CASE("rows of several needles may be mixed") {
  const auto trajectory = parse_trajectory(
      kHeader + "0,a,1,0,0,1,0,0,0,0\n0,b,2,0,0,1,0,0,0,0\n1,a,3,0,0,1,0,0,0,0\n5,b,4,0,0,1,0,0,0,0\n", "f");
  REQUIRE(trajectory.motions.size() == 2);
  CHECK(trajectory.motions[0].samples.size() == 2);
  CHECK(trajectory.motions[1].at(5).position[0] == 4);
  CHECK(trajectory.end() == 5);
}

TEST_CASE("errors name file, line, column, field, what was expected and what was found") {
  CHECK(row_error("0,a,0,zero,0,1,0,0,0,0") == "file.csv:2:7: y: expected a finite number, found 'zero'");
  CHECK(row_error("0,a,0,0, nan,1,0,0,0,0") == "file.csv:2:10: z: expected a finite number, found 'nan'");
  CHECK(row_error("0,a,0,0,,1,0,0,0,0") == "file.csv:2:9: z: expected a finite number, found ''");
  CHECK(row_error("0,a,0,0,1e999,1,0,0,0,0").find("file.csv:2:9: z: expected a finite number") == 0);
  CHECK(row_error("0,a,0,0,0,1,1,0,0,0").find("file.csv:2:11: qw: expected a unit quaternion") == 0);
  CHECK(row_error("0,,0,0,0,1,0,0,0,0").find("file.csv:2:3: needle: expected the name of a needle") == 0);
  CHECK(row_error("0,a,0,0,0,1,0,0,0").find("row: expected 10 cells as in the header, found 9") != std::string::npos);
  CHECK(row_error("1,a,0,0,0,1,0,0,0,0\n1,a,0,0,0,1,0,0,0,0") ==
        "file.csv:3:1: t: expected a time after 1 s, this needle's previous one, found 1");
  CHECK(
      row_error("1,a,0,0,0,1,0,0,0,0\n2,a,0,0,0,0,1,0,0,0").find("file.csv:3:11: qw: expected less than half a turn") ==
      0);
}

TEST_CASE("a position or a spin that no server takes is an error of its line") {
  CHECK(row_error("0,a,100,-100,0,1,0,0,0,-1e6") == "no error");
  CHECK(row_error("0,a,0,1e308,0,1,0,0,0,0") == "file.csv:2:7: y: expected a number in [-100, 100] m, found 1e+308");
  CHECK(row_error("0,a,0,0,0,1,0,0,0,0\n1,a,0,0,0,1,0,0,0,-1e307") ==
        "file.csv:3:19: spin: expected a number in [-1e+06, 1e+06] rad, found -1e+307");
}

TEST_CASE("errors of the header") {
  CHECK(error_of("t,needle,x,y,z,qw,qx,qy,qq\n").find("file.csv:1:25: header: expected one of") == 0);
  CHECK(error_of("t,needle,x,y,z,qw,qx,qy\n") == "file.csv:1:1: header: expected a column 'qz', found none");
  CHECK(error_of("t,t,needle,x,y,z,qw,qx,qy,qz\n") ==
        "file.csv:1:3: header: expected each column once, found a second 't'");
  CHECK(error_of("").find("header: expected t,needle,x,y,z,qw,qx,qy,qz,spin, found an empty file") !=
        std::string::npos);
  CHECK(error_of(kHeader).find("row: expected at least one") != std::string::npos);
  CHECK_THROWS_WITH_AS(read_trajectory("/nowhere/to/be/found.csv"),
                       "/nowhere/to/be/found.csv: expected a readable trajectory file, found none", TrajectoryError);
}

TEST_CASE("the default trajectory starts and ends outside, moves without jumps and reaches 75 mm") {
  const auto trajectory = read_trajectory(acus::source_path("scenes/trajectories/insertion_pullback.csv"));
  REQUIRE(trajectory.motions.size() == 1);
  const auto& motion = trajectory.motions[0];
  const auto z_at = [&](double time) { return motion.at(time).position[2]; };
  CHECK(z_at(trajectory.begin()) == doctest::Approx(0.21));
  CHECK(z_at(trajectory.end()) == doctest::Approx(0.21));

  const double step = 0.01;  // s
  double lowest = 1;         // m
  double fastest = 0;        // m/s
  double hardest = 0;        // m/s^2
  for (double t = step; t < trajectory.end() - step; t += step) {
    lowest = std::min(lowest, z_at(t));
    fastest = std::max(fastest, std::abs(z_at(t + step) - z_at(t)) / step);
    hardest = std::max(hardest, std::abs(z_at(t + step) - 2 * z_at(t) + z_at(t - step)) / (step * step));
  }
  CHECK(lowest == doctest::Approx(0.125));  // the tip 75 mm below the face at 0.05 m, the needle 0.15 m long
  CHECK(fastest == doctest::Approx(0.02).epsilon(1e-3));
  CHECK(hardest < 0.4);
}

TEST_CASE("files of spreadsheets are read: byte-order mark, semicolons or tabs with decimal commas, quotes") {
  const std::string rows = "t,needle,x,y,z,qw,qx,qy,qz\n0,a,0.5,0,0.25,1,0,0,0\n1.5,a,0.5,0,0.125,1,0,0,0\n";
  const auto with = [&](char separator, char decimal) {
    std::string text = rows;
    for (char& c : text) c = c == ',' ? separator : c == '.' ? decimal : c;
    return text;
  };
  const std::string quoted =
      "\"t\",\"needle\",\"x\",y,z,qw,qx,qy,qz\n0,\"a\",\"0,5\",0,\"0,25\",1,0,0,0\n\"1,5\",a,\"0,5\",0,\"0,125\",1,0,0,"
      "0\n";
  for (const std::string& text : {rows, "\xef\xbb\xbf" + rows, with(';', ','), with('\t', ','), with(';', '.'),
                                  "\xef\xbb\xbf% a\r\n// b\r\n;;;\r\n" + with(';', ','), quoted}) {
    CAPTURE(text);
    const auto trajectory = parse_trajectory(text, "f");
    REQUIRE(trajectory.motions.size() == 1);
    CHECK(trajectory.motions[0].needle == "a");
    CHECK(trajectory.end() == 1.5);
    CHECK(trajectory.motions[0].at(2).position == std::array{0.5, 0.0, 0.125});
  }
}

TEST_CASE("a name in quotes may hold what stands between cells") {
  const auto trajectory = parse_trajectory(kHeader + "0,\"the \"\"long\"\" one, left\",0,0,0,1,0,0,0,0\n", "f");
  CHECK(trajectory.motions.at(0).needle == "the \"long\" one, left");
  CHECK(row_error("0,\"a,0,0,0,1,0,0,0,0") ==
        "file.csv:2:3: row: expected a quote that is closed in its line, found none");
}

TEST_CASE("how a trajectory was read is told in a line") {
  CHECK(told(parse_trajectory("t;needle;x;y;z;qw;qx;qy;qz\n0;a;0,5;0;0;1;0;0;0\n2;b;0;0;0;1;0;0;0\n", "f")) ==
        "2 rows of 2 bodies, separated by ';', decimal comma; in order of t, 0 to 2 s; places of bases in m in the "
        "world, "
        "not depths");
}

TEST_CASE("what is no text in UTF-8, and numbers of two kinds, are refused with the remedy") {
  using namespace std::string_literals;
  CHECK(error_of("\xff\xfet\0,\0"s)
            .find("file.csv:1:1: file: expected text in UTF-8, found UTF-16; save it as CSV in UTF-8") == 0);
  CHECK(error_of("t\0,\0n\0"s).find("found UTF-16") != std::string::npos);
  CHECK(error_of("PK\x03\x04").find("found a workbook; save it as CSV") != std::string::npos);
  CHECK(row_error("0,a,0,5,0,0,1,0,0,0,0,0")
            .find("found 12; where numbers have a decimal comma, separate cells by ';'") != std::string::npos);
  for (const char* cell : {"\"1,000\"", "\"1,000.5\"", "1'000", "1 000", "1_000"}) {
    CAPTURE(cell);
    CHECK(row_error("0.5,a,"s + cell + ",0,0,1,0,0,0,0").find("file.csv:2:") == 0);
  }
  CHECK(row_error("0.5,a,\"1,000\",0,0,1,0,0,0,0") ==
        "file.csv:2:8: x: expected a number with the decimal sign '.' of those before, without groups of digits, found "
        "'1,000'");
  CHECK(error_of("t_ms,needle,x_mm,y,z,qw,qx,qy,qz\n").find("(s, m, rad, no unit in the name), found 't_ms'") !=
        std::string::npos);
}
