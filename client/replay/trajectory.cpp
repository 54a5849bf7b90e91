// SPDX-License-Identifier: MIT
#include "client/replay/trajectory.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>
#include <utility>

#include "client/replay/csv.h"
#include "protocol/messages.h"

namespace acus::client {
namespace {

enum Column { kTime, kNeedle, kX, kY, kZ, kQw, kQx, kQy, kQz, kSpin, kColumnCount };
constexpr std::array<std::string_view, kColumnCount> kColumnNames{"t",  "needle", "x",  "y",  "z",
                                                                  "qw", "qx",     "qy", "qz", "spin"};
constexpr double kUnitTolerance = 1e-3;      // of the norm of an orientation in the file
constexpr double kHalfTurnCosine = 0.00873;  // cosine of half of 179 degrees: turns beyond have no clear direction

// Where a cell stands, and how to complain about it.
struct Place {
  const std::string& file;
  std::size_t line = 0;

  [[noreturn]] void fail(std::size_t column, std::string_view field, const std::string& expected,
                         std::string_view found) const {
    throw TrajectoryError(file + ":" + std::to_string(line) + ":" + std::to_string(column) + ": " + std::string(field) +
                          ": expected " + expected + ", found " + std::string(found));
  }
};

std::string quoted(std::string_view text) { return std::string(1, '\'').append(text) += '\''; }

std::string shown(double number) {
  std::array<char, 32> buffer{};
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), number).ptr;
  return {buffer.data(), end};
}

// Which cell of a row holds which column.
struct Header {
  std::array<std::optional<std::size_t>, kColumnCount> cell_of;
  std::size_t cell_count = 0;
  char separator = ',';
};

std::vector<Cell> cells_of(std::string_view line, char separator, const Place& place) {
  auto cells = split(line, separator);
  if (!cells) place.fail(line.find('"') + 1, "row", "a quote that is closed in its line", "none");
  return std::move(*cells);
}

Header parse_header(std::string_view line, const Place& place) {
  Header header;
  header.separator = separator_of(line);
  const auto cells = cells_of(line, header.separator, place);
  header.cell_count = cells.size();
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const auto name = std::find(kColumnNames.begin(), kColumnNames.end(), cells[i].text);
    if (name == kColumnNames.end()) {
      place.fail(cells[i].column, "header",
                 "one of t, needle, x, y, z, qw, qx, qy, qz, spin (s, m, rad, no unit in the name)",
                 quoted(cells[i].text));
    }
    auto& cell = header.cell_of[static_cast<std::size_t>(name - kColumnNames.begin())];
    if (cell) place.fail(cells[i].column, "header", "each column once", "a second " + quoted(cells[i].text));
    cell = i;
  }
  for (std::size_t column = 0; column < kSpin; ++column) {
    if (!header.cell_of[column]) place.fail(1, "header", "a column " + quoted(kColumnNames[column]), "none");
  }
  return header;
}

// One row, with its cells named.
class Row {
 public:
  // `decimal` is the sign of the numbers read so far, 0 before the first that has one.
  Row(std::string_view line, const Header& header, const Place& place, char& decimal)
      : header_(header), place_(place), cells_(cells_of(line, header.separator, place)), decimal_(decimal) {
    if (cells_.size() == header.cell_count) return;
    place.fail(
        cells_.back().column, "row", std::to_string(header.cell_count) + " cells as in the header",
        std::to_string(cells_.size()) +
            (cells_.size() > header.cell_count ? "; where numbers have a decimal comma, separate cells by ';'" : ""));
  }

  bool has(Column column) const { return header_.cell_of[column].has_value(); }
  const Cell& cell(Column column) const { return cells_[*header_.cell_of[column]]; }

  double number(Column column) const {
    const auto text = cell(column).text;
    const auto sign = text.find_first_of(".,");
    if (sign != std::string_view::npos && decimal_ == 0) decimal_ = text[sign];
    if (const auto value = number_of(text, decimal_)) return *value;
    if (sign != std::string_view::npos && text[sign] != decimal_) {
      fail(column,
           std::string("a number with the decimal sign '") + decimal_ + "' of those before, without groups of digits",
           quoted(text));
    }
    fail(column, "a finite number", quoted(text));
  }

  [[noreturn]] void fail(Column column, const std::string& expected, std::string_view found) const {
    place_.fail(cell(column).column, kColumnNames[column], expected, found);
  }

 private:
  const Header& header_;
  const Place& place_;
  std::vector<Cell> cells_;
  char& decimal_;
};

double parse_within(const Row& row, Column column, double most, const std::string& unit) {
  const double value = row.number(column);
  if (std::abs(value) <= most) return value;
  row.fail(column, "a number in [" + shown(-most) + ", " + shown(most) + "] " + unit, shown(value));
}

double parse_position(const Row& row, Column column) { return parse_within(row, column, protocol::kMaxPosition, "m"); }

std::array<double, 4> parse_orientation(const Row& row) {
  std::array<double, 4> q{row.number(kQw), row.number(kQx), row.number(kQy), row.number(kQz)};
  const double norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  if (!(std::abs(norm - 1) <= kUnitTolerance)) row.fail(kQw, "a unit quaternion", "one of norm " + shown(norm));
  for (double& component : q) component /= norm;
  return q;
}

Sample parse_sample(const Row& row) {
  Sample sample;
  sample.time = row.number(kTime);
  sample.pose.position = {parse_position(row, kX), parse_position(row, kY), parse_position(row, kZ)};
  sample.pose.orientation = parse_orientation(row);
  if (row.has(kSpin)) sample.pose.spin = parse_within(row, kSpin, protocol::kMaxSpin, "rad");
  return sample;
}

double dot(const std::array<double, 4>& a, const std::array<double, 4>& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
}

void check_successor(const Sample& previous, const Sample& next, const Row& row) {
  if (!(next.time > previous.time)) {
    row.fail(kTime, "a time after " + shown(previous.time) + " s, this needle's previous one", shown(next.time));
  }
  if (std::abs(dot(previous.pose.orientation, next.pose.orientation)) < kHalfTurnCosine) {
    row.fail(kQw, "less than half a turn since this needle's previous row (add rows between)", "half a turn");
  }
}

Motion& motion_of(Trajectory& trajectory, const Row& row) {
  const std::string name = unquoted(row.cell(kNeedle).text);
  if (name.empty()) row.fail(kNeedle, "the name of a needle of the scene", "an empty cell");
  auto& motions = trajectory.motions;
  const auto known = std::find_if(motions.begin(), motions.end(), [&](const Motion& m) { return m.needle == name; });
  if (known != motions.end()) return *known;
  return motions.emplace_back(Motion{name, {}});
}

void append_row(Trajectory& trajectory, const Row& row) {
  Motion& motion = motion_of(trajectory, row);
  const Sample sample = parse_sample(row);
  if (!motion.samples.empty()) check_successor(motion.samples.back(), sample, row);
  motion.samples.push_back(sample);
}

// Both unit and less than half a turn apart; u in [0, 1].
std::array<double, 4> shortest_arc(const std::array<double, 4>& from, std::array<double, 4> to, double u) {
  double cosine = dot(from, to);
  if (cosine < 0) {  // q and -q are the same rotation
    for (double& component : to) component = -component;
    cosine = -cosine;
  }
  const double angle = std::acos(std::min(cosine, 1.0));
  const bool tiny = angle < 1e-6;  // sin(angle) would divide by rounding; the chord is as good
  const double a = tiny ? 1 - u : std::sin((1 - u) * angle) / std::sin(angle);
  const double b = tiny ? u : std::sin(u * angle) / std::sin(angle);
  std::array<double, 4> q{};
  for (std::size_t i = 0; i < 4; ++i) q[i] = a * from[i] + b * to[i];
  const double norm = std::sqrt(dot(q, q));
  for (double& component : q) component /= norm;
  return q;
}

BasePose between(const BasePose& from, const BasePose& to, double u) {
  BasePose pose;
  for (std::size_t i = 0; i < 3; ++i) pose.position[i] = (1 - u) * from.position[i] + u * to.position[i];
  pose.orientation = shortest_arc(from.orientation, to.orientation, u);
  if (from.spin && to.spin) pose.spin = (1 - u) * *from.spin + u * *to.spin;
  return pose;
}

}  // namespace

BasePose Motion::at(double time) const {
  const auto after = std::upper_bound(samples.begin(), samples.end(), time,
                                      [](double t, const Sample& sample) { return t < sample.time; });
  if (after == samples.begin()) return samples.front().pose;
  if (after == samples.end()) return samples.back().pose;
  const auto before = std::prev(after);
  return between(before->pose, after->pose, (time - before->time) / (after->time - before->time));
}

double Trajectory::begin() const {
  double earliest = std::numeric_limits<double>::infinity();
  for (const Motion& motion : motions) earliest = std::min(earliest, motion.samples.front().time);
  return earliest;
}

double Trajectory::end() const {
  double latest = -std::numeric_limits<double>::infinity();
  for (const Motion& motion : motions) latest = std::max(latest, motion.samples.back().time);
  return latest;
}

Trajectory parse_trajectory(std::string_view text, const std::string& name) {
  Trajectory trajectory;
  std::optional<Header> header;
  Place place{name};
  if (const auto kind = not_utf8(text); !kind.empty()) Place{name, 1}.fail(1, "file", "text in UTF-8", kind);
  text = without_mark(text);
  for (std::size_t begin = 0; begin < text.size();) {
    const auto end = std::min(text.find('\n', begin), text.size());
    const auto line = text.substr(begin, end - begin);
    begin = end + 1;
    ++place.line;
    if (is_blank(line)) continue;
    if (!header) {
      header = parse_header(line, place);
      continue;
    }
    if (++trajectory.rows > kMaxTrajectoryRows)
      place.fail(1, "row", "at most " + std::to_string(kMaxTrajectoryRows), "more");
    append_row(trajectory, Row(line, *header, place, trajectory.decimal));
  }
  if (!header) place.fail(1, "header", "t,needle,x,y,z,qw,qx,qy,qz,spin", "an empty file");
  if (trajectory.rows == 0) place.fail(1, "row", "at least one", "none after the header");
  trajectory.separator = header->separator;
  return trajectory;
}

std::string told(const Trajectory& trajectory) {
  const std::string separator = trajectory.separator == '\t' ? "tabs" : quoted({&trajectory.separator, 1});
  return std::to_string(trajectory.rows) + " rows of " + std::to_string(trajectory.motions.size()) +
         (trajectory.motions.size() == 1 ? " body" : " bodies") + ", separated by " + separator + ", decimal " +
         (trajectory.decimal == ',' ? "comma" : "point") + "; in order of t, " + shown(trajectory.begin()) + " to " +
         shown(trajectory.end()) + " s; places of bases in m in the world, not depths";
}

Trajectory read_trajectory(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw TrajectoryError(path + ": expected a readable trajectory file, found none");
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  if (file.bad()) throw TrajectoryError(path + ": reading it failed");
  return parse_trajectory(text, path);
}

}  // namespace acus::client
