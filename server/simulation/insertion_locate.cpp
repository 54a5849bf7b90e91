// SPDX-License-Identifier: GPL-3.0-or-later
// Stage 4 of an insertion: where the tip and the path's points stand in this tick.
#include <algorithm>
#include <cmath>

#include "server/simulation/insertion.h"

namespace acus {

namespace {

// A last vertex this close to the end of its path (in spacings) holds nothing yet: two points at one place.
constexpr double kEndClearance = 0.1;
// A tip this close to the end of its path is there: one at rest must not come and go by rounding.
constexpr double kAtEnd = 1e-6;  // m
// A tip pulled back by more than this (in spacings) from a border does not rest against it any more.
constexpr double kBorderClearance = 0.1;
// Softer than this (in W of the rows) a vertex holds nothing.
constexpr double kSoftest = 1e6;
// Cosine of the largest angle between a path and the needle in it.
constexpr double kLeastAlong = 0.5;
// Square of the sine below which a path against the needle lies to no side of it.
constexpr double kNoSide = 1e-12;

// The direction of a path, but no further from the needle's than that angle: rows across a path that runs across the
// needle would pull along the shaft, on which the vertex then runs away.
Vector3 beside(const Vector3& needle, const Vector3& path) {
  const double along = path.dot(needle);
  if (along >= kLeastAlong) return path;
  const Vector3 across = path - along * needle;
  if (across.squaredNorm() < kNoSide) return needle;
  return kLeastAlong * needle + std::sqrt(1 - kLeastAlong * kLeastAlong) * across.stableNormalized();
}

}  // namespace

void Insertion::locate(const NeedleView& needle, const TissueView& tissue, std::vector<Path>& paths) {
  left_out_ = false;
  obstacle_.reset();
  const int first = shaft_.empty() ? 0 : shaft_.front().vertex, last = shaft_.empty() ? -1 : shaft_.back().vertex;
  shaft_.clear();
  if (path_ < 0) locate_outside(needle, tissue, paths);
  if (path_ >= 0) locate_inside(needle, tissue, paths[path_]);
  take_over_traction(first, last);
}

void Insertion::locate_outside(const NeedleView& needle, const TissueView& tissue, std::vector<Path>& paths) {
  const Vector3 before = needle.start_tip();
  const CurvePoint tip = needle.tip();
  const double margin = kContactMargin + 2 * (tip.position - before).norm();
  if (!tissue.surface.near(tissue.x, before, margin)) return;
  SurfacePoint at;
  if (phase_ == Phase::contact) {
    at = tissue.surface.closest(tissue.x, before);
  } else {
    const auto entry = tissue.surface.entry(tissue.x, before, tip.position);
    at = entry ? *entry : tissue.surface.closest(tissue.x, before);
  }
  if (std::abs(at.distance) > margin && phase_ != Phase::contact) return;

  // An open mouth under the tip: no surface to push against.
  const Mouth mouth = find_mouth(at.position, tissue, paths);
  if (mouth.path >= 0) {
    Path& path = paths[mouth.path];
    const Vector3 past = tip.position - tissue.position(mouth.far_end ? path.end : path.vertices[0]);
    const Vector3 inwards = mouth.far_end ? Vector3(-end_tangent(tissue, path, -tip.tangent))
                                          : path_tangent(tissue, path, 0, tip.tangent);
    if (at.normal.dot(past) >= 0 || inwards.dot(past) <= 0) return;
    if (mouth.far_end) path.turn_round();
    enter(mouth.path, paths);
    reentered_ = true;
    return;
  }
  const MaterialPoint material = tissue.surface.material(at);
  obstacle_ = {tissue.region(material), at, material};
}

// The nearest mouth within a needle's diameter of a place on the surface.
Insertion::Mouth Insertion::find_mouth(const Vector3& place, const TissueView& tissue,
                                       std::span<const Path> paths) const {
  Mouth nearest;
  double distance = parameters_.outer_diameter;
  const auto consider = [&](int path, bool far_end, const MaterialPoint& mouth) {
    const double apart = (tissue.position(mouth) - place).norm();
    if (apart > distance) return;
    distance = apart;
    nearest = {path, far_end};
  };
  for (int i = 0; i < static_cast<int>(paths.size()); ++i) {
    const Path& path = paths[i];
    if (path.empty() || path.needle >= 0) continue;
    consider(i, false, path.vertices[0]);
    if (path.exited) consider(i, true, path.end);
  }
  return nearest;
}

void Insertion::enter(int path, std::vector<Path>& paths) {
  path_ = path;
  paths[path].needle = needle_;
  phase_ = Phase::inside;
  tip_ = TipMemory{};
  std::fill(memory_.begin(), memory_.end(), Memory{.s = parameters_.length});
  end_s_ = parameters_.length;
  end_force_.setZero();
}

Vector3 Insertion::path_tangent(const TissueView& tissue, const Path& path, int vertex,
                                const Vector3& needle_tangent) const {
  const int last = static_cast<int>(path.vertices.size()) - 1;
  const Vector3 here = tissue.position(path.vertices[vertex]);
  const Vector3 before = vertex > 0 ? tissue.position(path.vertices[vertex - 1]) : here;
  const Vector3 after = vertex < last ? tissue.position(path.vertices[vertex + 1]) : tissue.position(path.end);
  return young_direction(after - before, needle_tangent);
}

Vector3 Insertion::end_tangent(const TissueView& tissue, const Path& path, const Vector3& needle_tangent) const {
  const int last = holding_vertices(path) - 1;
  return young_direction(tissue.position(path.end) - tissue.position(path.vertices[last]), needle_tangent);
}

// A path much shorter than its spacing has no direction of its own: what the tip slid sideways in a tick would turn it.
// Up to half a spacing the direction goes over from the needle's to the path's.
Vector3 Insertion::young_direction(const Vector3& along, const Vector3& needle_tangent) const {
  const double share = 2 * along.norm() / parameters_.constraint_spacing;
  if (share >= 1) return along.normalized();
  return ((1 - share) * needle_tangent + share * along.stableNormalized()).normalized();
}

// Vertices that are far enough from the path's end to hold the shaft.
int Insertion::holding_vertices(const Path& path) const {
  const auto count = static_cast<int>(path.vertices.size());
  return count > 1 && path.tail < kEndClearance * path.spacing ? count - 1 : count;
}

void Insertion::locate_inside(const NeedleView& needle, const TissueView& tissue, const Path& path) {
  const double length = needle.model.length;
  const Vector3 tip_tangent = needle.tip().tangent;
  for (int i = 0; i < holding_vertices(path); ++i) {
    const Vector3 along_needle = curve_point(needle.model, needle.shape, memory_[i].s).tangent;
    const Vector3 tangent = beside(along_needle, path_tangent(tissue, path, i, tip_tangent));
    memory_[i].s = project_on_curve(needle, tissue.position(path.vertices[i]), tangent, memory_[i].s);
    const double s = memory_[i].s;
    if (s < 0 || s > length) continue;
    if (shaft_.size() < shaft_.capacity()) {
      shaft_.push_back({i, s, 0, tangent, 0});
    } else {
      left_out_ = true;
    }
  }
  end_s_ = project_on_curve(needle, tissue.position(path.end), end_tangent(tissue, path, tip_tangent), end_s_);
  place_tip(needle, tissue, path);
  find_border(needle, tissue, path);
  const double end = phase_ == Phase::through ? std::min(length, end_s_) : length;
  depth_ = std::max(0.0, end - std::max(0.0, memory_[0].s));
  share_length(end);
}

// Every point owns the needle halfway to its neighbours; the first from where the needle enters (its own place, as it is
// the mouth, or the base), the last to `end`.
void Insertion::share_length(double end) {
  const auto count = static_cast<int>(shaft_.size());
  for (int i = 0; i < count; ++i) {
    const double from = i > 0 ? 0.5 * (shaft_[i - 1].s + shaft_[i].s) : (shaft_[0].vertex == 0 ? shaft_[0].s : 0);
    const double to = i + 1 < count ? 0.5 * (shaft_[i].s + shaft_[i + 1].s) : end;
    shaft_[i].owned = std::max(0.0, to - from);
  }
}

// Vertices that were not alongside in the last tick, from `first` to `last`, are as strained as the one before them.
void Insertion::take_over_traction(int first, int last) {
  double before = 0;
  for (const ShaftPoint& point : shaft_) {
    double& traction = memory_[point.vertex].traction;
    if (point.vertex < first || point.vertex > last) traction = before;
    before = traction;
  }
}

Vector3 Insertion::cutting_direction(const NeedleView& needle) const {
  return needle.shape.frames.back() * cutting_direction_;
}

// Where the tip stands in its path: at the end, where it cuts, or back inside, between two vertices.
void Insertion::place_tip(const NeedleView& needle, const TissueView& tissue, const Path& path) {
  const Vector3 tip_tangent = needle.tip().tangent;
  const double length = needle.model.length;
  const int count = holding_vertices(path);
  int next = 0;
  while (next < count && memory_[next].s <= length) ++next;
  if (held_ >= 0) next = count;     // what slides on a border is at the end, wherever it came from
  const bool tail = next == count;  // between the last vertex and the end
  const double next_s = tail ? end_s_ : memory_[next].s;
  // Where the base takes the tip is not yet where it goes: a needle bent against a border follows it a long way.
  const double moved = (needle.tip().position - needle.start_tip()).norm();
  const double clearance = held_ >= 0 ? kBorderClearance * path.spacing + moved : kAtEnd;
  in_tail_ = tail && !path.exited;
  at_end_ = in_tail_ && next_s <= length + clearance;
  tip_offset_ = 0;
  double u = 1;  // of the way from the last vertex alongside to the next, or to the end
  if (at_end_ || next == 0) {
    tip_point_ = {at_end_ ? path.end : path.vertices[0], {}, 0};
    tip_softness_ = 0;
    tip_tangent_ = at_end_ ? cutting_direction(needle) : tip_tangent;
  } else {
    const double from_s = memory_[next - 1].s;
    if (next_s > from_s) u = std::clamp((length - from_s) / (next_s - from_s), 0.0, 1.0);
    tip_point_ = {path.vertices[next - 1], tail ? path.end : path.vertices[next], u};
    tip_softness_ = (1 - u) * (1 - u);
    if (tail) tip_offset_ = u;
    const Vector3 from = path_tangent(tissue, path, next - 1, tip_tangent);
    const Vector3 to = tail ? end_tangent(tissue, path, tip_tangent) : path_tangent(tissue, path, next, tip_tangent);
    tip_tangent_ = ((1 - u) * from + u * to).normalized();
  }
  if (!in_tail_ || shaft_.empty()) return;
  // The last vertex fades in as the cut leaves it behind; a tip pulled back to it is held by it alone.
  const double tail_spacings = path.tail / path.spacing + static_cast<double>(path.vertices.size()) - count;
  if (tail_spacings >= 1) return;
  const double soft = (1 - tail_spacings) / std::max(tail_spacings, 1 / kSoftest);
  shaft_.back().softness = std::min(kSoftest, u * soft * soft);
}

// The border of a region that a tip at the end of its path rests against, or may reach in this tick. A tip that is not
// quite at the end may be back there, and beyond, by the end of the tick.
void Insertion::find_border(const NeedleView& needle, const TissueView& tissue, const Path& path) {
  if (!in_tail_ || !tissue.borders.any()) return;
  const Vector3 before = needle.start_tip();
  const double reach = kContactMargin + 2 * (needle.tip().position - before).norm();
  const auto closest_on = [&](int region, const Vector3& p) {
    const Surface& surface = tissue.borders.surface(region);
    const SurfacePoint at = surface.closest(tissue.x, p);
    return Obstacle{region, at, surface.material(at)};
  };
  if (held_ >= 0 && at_end_) {
    obstacle_ = closest_on(held_, tissue.position(path.end));
    return;
  }
  Vector3 from = tissue.position(path.end);
  const Vector3 direction = cutting_direction(needle);
  const Vector3 to = from + reach * direction;
  const Vector3 unloaded = needle.tip().position - cutting_compliance(tissue, path) * tip_.cutting * direction;
  int start = path.end.tetrahedron, came_from = -1;
  for (int i = 0; i < kMaxCrossings; ++i) {
    const Trace trace = trace_segment(tissue.mesh, tissue.x, start, from, to, tissue.regions, came_from);
    if (trace.next < 0) return;
    from = tissue.position(trace.end);
    const int region = tissue.regions[trace.next];
    if (tissue.border(trace.end, region).holds) {
      obstacle_ = closest_on(region, from);
      obstacle_->under = at_end_ && obstacle_->at.normal.dot(unloaded - obstacle_->at.position) < 0;
      return;
    }
    came_from = trace.end.tetrahedron;
    start = trace.next;
  }
}

int Insertion::tetrahedron_ahead(const NeedleView& needle, const TissueView& tissue, std::span<const Path> paths,
                                 double distance) const {
  const bool cuts = phase_ == Phase::inside && in_tail_;
  if (!cuts && !(phase_ == Phase::contact && obstacle_)) return -1;
  const MaterialPoint& start = cuts ? paths[path_].end : obstacle_->material;
  const Vector3 from = tissue.position(start), to = from + distance * cutting_direction(needle);
  return trace_segment(tissue.mesh, tissue.x, start.tetrahedron, from, to).end.tetrahedron;
}

}  // namespace acus
