// SPDX-License-Identifier: MIT
#include "client/haptics/program/verification.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ostream>
#include <sstream>
#include <stdexcept>
#include <utility>

namespace acus::haptics {

namespace {

struct Request {
  const char* words;
  Vector3 way;  // of length one
};

constexpr std::array<Request, 6> kRequests{{{"ahead, away from you", {{1, 0, 0}}},
                                            {"back, towards you", {{-1, 0, 0}}},
                                            {"to the left", {{0, 1, 0}}},
                                            {"to the right", {{0, -1, 0}}},
                                            {"up", {{0, 0, 1}}},
                                            {"down", {{0, 0, -1}}}}};

constexpr const char* kUnit = "if that was the motion, the device's unit is not the metre";

std::string text(const char* format, double value) {
  char buffer[200];
  std::snprintf(buffer, sizeof buffer, format, value);
  return buffer;
}

// "y" or "-y" of a way along an axis; empty for one that is along none.
std::string axis_of(const Vector3& way) {
  const double length = norm(way);
  for (int i = 0; i < 3; ++i)
    if (std::abs(way[i]) >= Verification::kAligned * length) return std::string(way[i] < 0 ? "-" : "") + "xyz"[i];
  return {};
}

Vector3 unit_of(const std::string& axis) {
  static const std::array<const char*, 6> kNames{"x", "y", "z", "-x", "-y", "-z"};
  for (std::size_t i = 0; i < kNames.size(); ++i) {
    if (axis != kNames[i]) continue;
    Vector3 unit;
    unit[static_cast<int>(i % 3)] = i < 3 ? 1 : -1;
    return unit;
  }
  throw std::invalid_argument("axes: expected three of x, y, z, -x, -y, -z, found '" + axis + "'");
}

std::vector<std::string> split(const std::string& axes) {
  std::vector<std::string> parts;
  std::istringstream in(axes);
  for (std::string part; std::getline(in, part, ',');) parts.push_back(part);
  return parts;
}

}  // namespace

Quaternion rotation_of_axes(const std::string& axes) {
  const std::vector<std::string> names = split(axes);
  if (names.size() != 3 || axes.back() == ',')
    throw std::invalid_argument("axes: expected three of x, y, z, -x, -y, -z, as in y,-x,z; found '" + axes + "'");
  const Vector3 ahead = unit_of(names[0]), left = unit_of(names[1]), up = unit_of(names[2]);
  if (dot(cross(ahead, left), up) < 0.5)
    throw std::invalid_argument("axes: '" + axes +
                                "' is no rotation; expected ahead, left and up of a right-handed frame");
  // Rows of the rotation, as a quaternion by its largest part.
  const double r[3][3] = {{ahead[0], ahead[1], ahead[2]}, {left[0], left[1], left[2]}, {up[0], up[1], up[2]}};
  const double trace = r[0][0] + r[1][1] + r[2][2];
  if (trace > 0) return normalized({1 + trace, r[2][1] - r[1][2], r[0][2] - r[2][0], r[1][0] - r[0][1]});
  if (r[0][0] >= r[1][1] && r[0][0] >= r[2][2])
    return normalized({r[2][1] - r[1][2], 1 + r[0][0] - r[1][1] - r[2][2], r[0][1] + r[1][0], r[0][2] + r[2][0]});
  if (r[1][1] >= r[2][2])
    return normalized({r[0][2] - r[2][0], r[0][1] + r[1][0], 1 - r[0][0] + r[1][1] - r[2][2], r[1][2] + r[2][1]});
  return normalized({r[1][0] - r[0][1], r[0][2] + r[2][0], r[1][2] + r[2][1], 1 - r[0][0] - r[1][1] + r[2][2]});
}

Verification::Verification(Device& device, const DeviceProperties& properties, const Quaternion& turned, Clock clock,
                           std::ostream& out, const std::atomic<bool>* interrupt)
    : device_(device),
      properties_(properties),
      turned_(turned),
      clock_(std::move(clock)),
      out_(out),
      interrupt_(interrupt),
      due_(clock_.now()) {}

// The handle at the next sample.
Vector3 Verification::read() {
  due_ += 1 / properties_.rate;
  clock_.sleep_until(due_);
  due_ = std::max(due_, clock_.now());  // what was missed is not made up for: the force grows by the clock
  const Vector3 raw = device_.read().pose.position;
  if (!std::isfinite(norm(raw))) throw DeviceError("the device reports a place that is no number");
  if (!(raw == raw_)) changes_.push_back(due_);
  for (int i = 0; i < 3; ++i) {
    const double step = std::abs(raw[i] - raw_[i]);
    if (step > 0 && (least_step_ == 0 || step < least_step_)) least_step_ = step;
  }
  raw_ = raw;
  return place_ = turned_ * raw;
}

bool Verification::tell(bool good, const std::string& what, const std::string& found) {
  out_ << (good ? "  ok      " : "  WRONG   ") << what << ": " << found << '\n' << std::flush;
  return good;
}

// A motion of at least so much, and the rest that ends it.
Verification::Motion Verification::wait_for_motion(double least_way) {
  Motion motion{place_, place_};
  Vector3 rests_at = place_;
  double rests_since = due_;
  for (const double end = due_ + kPatience; due_ < end && !stopped();) {
    const Vector3 place = read();
    motion.farthest = std::max(motion.farthest, norm(place - motion.from));
    if (norm(place - rests_at) > kStill) rests_at = place, rests_since = due_;
    if (motion.farthest > kLongest) return motion;
    if (due_ - rests_since < kStillTime || norm(place - motion.from) < least_way) continue;
    motion.to = place;
    motion.came = true;
    return motion;
  }
  return motion;
}

bool Verification::check_rest() {
  out_ << "Hold the handle still for a second.\n" << std::flush;
  on_request({});
  raw_ = device_.read().pose.position;
  const Vector3 begin = read();
  double most = 0;
  for (const double end = due_ + 1; due_ < end && !stopped();) most = std::max(most, norm(read() - begin));
  if (stopped()) return false;
  const bool good = most < 10 * kStill;
  return tell(good, "rest", text("within %.3f mm", 1e3 * most) + (good ? "" : "; " + std::string(kUnit)));
}

bool Verification::check_motions() {
  std::array<Vector3, 6> ways{};
  for (std::size_t i = 0; i < kRequests.size(); ++i) {
    out_ << "Move the handle 5 cm " << kRequests[i].words << ", and hold it there.\n" << std::flush;
    on_request(kWay * kRequests[i].way);
    const Motion motion = wait_for_motion(kLeastWay);
    if (stopped()) return false;
    if (!motion.came || motion.farthest > kLongest)
      return tell(false, kRequests[i].words, text("the device reported at most %.3g m; ", motion.farthest) + kUnit);
    ways[i] = motion.to - motion.from;
    const double length = norm(ways[i]);
    const double along = dot(ways[i], kRequests[i].way) / length;
    tell(along >= kAligned, kRequests[i].words,
         text("%.1f cm", 100 * length) + ", reported along " +
             (axis_of(ways[i]).empty() ? "no axis" : axis_of(ways[i])) + ", expected " + axis_of(kRequests[i].way));
  }
  return judge_axes(ways);
}

// Whether the six ways are those that were asked for; says what would make them so.
bool Verification::judge_axes(const std::array<Vector3, 6>& ways) {
  std::array<std::string, 3> axes;  // of the device, ahead, left and up
  bool right = true, known = true;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vector3 there = ways[2 * i], back = -ways[2 * i + 1];
    right = right && axis_of(there) == axis_of(kRequests[2 * i].way) && axis_of(back) == axis_of(kRequests[2 * i].way);
    axes[i] = axis_of(turned_.conjugate() * (there + back));
    known = known && !axes[i].empty() && axis_of(there) == axis_of(back);
  }
  if (right) return true;
  if (!known) return tell(false, "axes", "ways there and back disagree, or are along no axis; try again");
  const std::string all = axes[0] + "," + axes[1] + "," + axes[2];
  try {
    rotation_of_axes(all);
  } catch (const std::invalid_argument&) {
    return tell(false, "axes",
                "ahead, left and up are " + all + ", which is mirrored: the device's driver has a wrong sign");
  }
  return tell(false, "axes", "other ones than expected; use --axes=" + all);
}

// The most new readings in a quarter of a second, while the handle moved.
bool Verification::check_rate() {
  constexpr double kWindow = 0.25;
  std::size_t most = 0, first = 0;
  for (std::size_t i = 0; i < changes_.size(); ++i) {
    while (changes_[i] - changes_[first] > kWindow - 0.5 / properties_.rate) ++first;
    most = std::max(most, i - first + 1);
  }
  const double rate = static_cast<double>(most) / kWindow;
  return tell(rate >= 0.5 * properties_.rate, "rate",
              text("%.0f new readings a second", rate) + text(" of %.0f", properties_.rate) +
                  (rate >= 0.5 * properties_.rate ? "" : "; choose a --rate that the device has"));
}

bool Verification::check_resolution() {
  const double stated = properties_.translation.resolution;
  const bool good = stated == 0 || least_step_ <= 1.5 * stated;
  return tell(good, "resolution",
              text("steps of %.3g µm", 1e6 * least_step_) + text(", stated %.3g µm", 1e6 * stated) +
                  (good ? "" : "; state the steps, on which the coupling relies"));
}

// A force that grows until the handle has moved.
bool Verification::push(int axis) {
  const double most = std::min(kForce, properties_.translation.largest_force / 2);
  Vector3 direction;
  direction[axis] = 1;
  const Vector3 from = place_;
  double force = 0;
  for (const double begin = due_; due_ - begin < 1.5 * kRamp && norm(place_ - from) < kPushed && !stopped();) {
    force = most * std::min((due_ - begin) / kRamp, 1.0);
    device_.write({turned_.conjugate() * (force * direction), {}});
    read();
  }
  device_.write({});
  if (stopped()) return false;
  const Vector3 way = place_ - from;
  const std::string name = std::string("force along ") + "xyz"[axis];
  if (norm(way) < kPushed)
    return tell(false, name,
                text("the handle moved by less than 4 mm under %.1f N; ", force) +
                    "hold it more loosely, or the device renders no force");
  const bool good = dot(way, direction) >= kAligned * norm(way);
  return tell(good, name,
              text("%.2f N pushed the handle along ", force) + (axis_of(way).empty() ? "no axis" : axis_of(way)));
}

bool Verification::check_forces() {
  if (!(properties_.translation.largest_force > 0)) {
    out_ << "  --      force: this device renders none\n";
    return true;
  }
  out_ << text("Hold the handle loosely: it will be pushed ahead, to the left and up, by at most %.1f N.\n",
               std::min(kForce, properties_.translation.largest_force / 2));
  bool good = true;
  for (int axis = 0; axis < 3 && good && !stopped(); ++axis) {
    on_request({});
    for (const double end = due_ + 1; due_ < end && !stopped();) read();
    good = push(axis);
  }
  return good;
}

std::optional<bool> Verification::run() {
  // A device whose places are wrong is not to push.
  bool good = check_rest() && check_motions();
  if (!stopped() && !changes_.empty()) {
    good = check_rate() && good;
    good = check_resolution() && good;
    if (good) good = check_forces();
  }
  if (stopped()) {
    out_ << "Interrupted: the check is not complete.\n";
    return std::nullopt;
  }
  out_ << (good ? "The device is as it should be.\n"
                : "The device is not to be used as it is; see what is WRONG above.\n");
  return good;
}

}  // namespace acus::haptics
