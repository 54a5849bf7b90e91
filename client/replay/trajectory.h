// SPDX-License-Identifier: MIT
// Recorded motions of needle bases: a CSV file in, a pose at any time out. SI units, world frame, quaternions
// [w, x, y, z]. It knows nothing of the tissue; a trajectory means something only together with its scene.
//
// The file has a header with the columns t, needle, x, y, z, qw, qx, qy, qz and optionally spin, in any order; empty
// lines and lines that start with #, % or // are skipped. Rows of several needles may be mixed; the times of each
// needle rise. A semicolon or a tab may stand between cells, and numbers may have a decimal comma; csv.h has the rest.
#pragma once

#include <array>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace acus::client {

// A trajectory that cannot be followed. what() reads "file:line:column: field: expected ..., found ...".
struct TrajectoryError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

struct BasePose {
  std::array<double, 3> position{};               // m
  std::array<double, 4> orientation{1, 0, 0, 0};  // unit, w x y z, without spin
  std::optional<double> spin;                     // rad, continuous over many turns; absent if the file has no spin
};

struct Sample {
  double time = 0;  // s
  BasePose pose;
};

// The motion of one needle's base.
struct Motion {
  std::string needle;           // its name in the scene
  std::vector<Sample> samples;  // at least one, times strictly rising

  // Position and spin run straight between samples, the orientation along the shortest arc; before the first sample
  // and after the last one the base rests.
  BasePose at(double time) const;
};

struct Trajectory {
  std::vector<Motion> motions;  // one per needle, in the order of their first rows
  std::size_t rows = 0;         // of the file
  char separator = ',';         // between its cells
  char decimal = 0;             // sign of its numbers; 0 where all are whole

  double begin() const;  // s, of the earliest sample
  double end() const;    // s, of the latest sample
};

inline constexpr std::size_t kMaxTrajectoryRows = 10'000'000;

// Throws TrajectoryError: no such file, a column that is missing or unknown, a cell that is no finite number, a
// position or spin that no pose may have (protocol::kMaxPosition, kMaxSpin), an orientation that is no unit quaternion
// (within 1e-3; it is normalised), a time that does not rise, half a turn between neighbouring samples (it has no
// shortest arc), no rows or too many.
Trajectory read_trajectory(const std::string& path);

// The same from text; `name` stands for the file in messages.
Trajectory parse_trajectory(std::string_view text, const std::string& name);

// How the file was read, in a line: rows, separator, decimal sign, order, and what positions are measured from.
std::string told(const Trajectory& trajectory);

}  // namespace acus::client
