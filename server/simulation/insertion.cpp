// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/simulation/insertion.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "server/math/rotation.h"

namespace acus {

namespace {

// A last vertex this close to the end of its path (in spacings) holds nothing yet: two points at one place.
constexpr double kEndClearance = 0.1;
// Contact is looked for within this distance beyond what the tip moves in a tick.
constexpr double kContactMargin = 1e-3;  // m
// A force counts as at its cap from this fraction on.
constexpr double kAtCap = 1 - 1e-9;
// A tip that a tick took past a border comes back to it no faster than this.
constexpr double kRecoverySpeed = 0.1;  // m/s
// A tip pulled back by more than this (in spacings) from a border does not rest against it any more.
constexpr double kBorderClearance = 0.1;
// Softer than this (in W of the rows) a vertex holds nothing.
constexpr double kSoftest = 1e6;
// A point holds as if it stood for at least this length of shaft (in spacings).
constexpr double kLeastOwned = 0.1;

// Which of two paths a new one may take the place of: empty ones first, then the one left longest ago.
bool forgotten_before(const Path& a, const Path& b) {
  const auto rank = [](const Path& p) { return p.empty() ? 0 : p.needle < 0 ? 1 : 2; };
  return rank(a) != rank(b) ? rank(a) < rank(b) : a.left < b.left;
}

}  // namespace

int Insertion::max_points(const Needle& p) { return 2 * static_cast<int>(std::ceil(p.length / p.constraint_spacing)) + 4; }

Insertion::Insertion(int needle, const Needle& parameters, int path_capacity)
    : needle_(needle), parameters_(parameters), cutting_direction_(parameters.cutting_direction.normalized()) {
  memory_.resize(static_cast<std::size_t>(path_capacity));
  shaft_.reserve(static_cast<std::size_t>(max_points(parameters)));
}

void Insertion::reset() {
  phase_ = Phase::free;
  path_ = -1;
  depth_ = 0;
  reentered_ = puncturing_ = cutting_ = at_end_ = false;
  held_ = -1;
  obstacle_.reset();
  std::fill(memory_.begin(), memory_.end(), Memory{});
  shaft_.clear();
  tip_ = TipMemory{};
}

// ---------------------------------------------------------------------------------------------------- 4. locate

void Insertion::locate(const NeedleView& needle, const TissueView& tissue, std::vector<Path>& paths) {
  reentered_ = left_out_ = false;
  obstacle_.reset();
  shaft_.clear();
  if (path_ < 0) locate_outside(needle, tissue, paths);
  if (path_ >= 0) locate_inside(needle, tissue, paths[path_]);
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
  const int mouth = find_mouth(at.position, tissue, paths);
  if (mouth >= 0) {
    const Vector3 past = tip.position - tissue.position(paths[mouth].vertices[0]);
    if (at.normal.dot(past) >= 0 || path_tangent(tissue, paths[mouth], 0, tip.tangent).dot(past) <= 0) return;
    enter(mouth, paths);
    reentered_ = true;
    return;
  }
  const MaterialPoint material = tissue.surface.material(at);
  obstacle_ = {tissue.region(material), at, material};
}

// The path whose mouth is at a place of the surface, or -1. A path with a mouth at either end is turned round if it is
// its far end.
int Insertion::find_mouth(const Vector3& place, const TissueView& tissue, std::vector<Path>& paths) const {
  const auto near = [&](const MaterialPoint& p) {
    return (tissue.position(p) - place).norm() <= parameters_.outer_diameter;
  };
  for (int i = 0; i < static_cast<int>(paths.size()); ++i) {
    Path& path = paths[i];
    if (path.empty() || path.needle >= 0) continue;
    if (near(path.vertices[0])) return i;
    if (!path.exited || !near(path.end)) continue;
    path.turn_round();
    return i;
  }
  return -1;
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
    const Vector3 tangent = path_tangent(tissue, path, i, tip_tangent);
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
  const bool tail = next == count;  // between the last vertex and the end
  const double next_s = tail ? end_s_ : memory_[next].s;
  const double clearance = held_ >= 0 ? kBorderClearance * path.spacing : 0;
  at_end_ = tail && next_s <= length + clearance && !path.exited;
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
  if (!tail || shaft_.empty() || path.exited) return;
  // The last vertex fades in as the cut leaves it behind; a tip pulled back to it is held by it alone.
  const double tail_spacings = path.tail / path.spacing + static_cast<double>(path.vertices.size()) - count;
  if (tail_spacings >= 1) return;
  const double soft = (1 - tail_spacings) / std::max(tail_spacings, 1 / kSoftest);
  shaft_.back().softness = std::min(kSoftest, u * soft * soft);
}

// The border of a region that a tip at the end of its path rests against, or may reach in this tick.
void Insertion::find_border(const NeedleView& needle, const TissueView& tissue, const Path& path) {
  if (!at_end_ || !tissue.borders.any()) return;
  const Vector3 before = needle.start_tip();
  const double reach = kContactMargin + 2 * (needle.tip().position - before).norm();
  const auto closest_on = [&](int region, const Vector3& p) {
    const Surface& surface = tissue.borders.surface(region);
    const SurfacePoint at = surface.closest(tissue.x, p);
    return Obstacle{region, at, surface.material(at)};
  };
  if (held_ >= 0) {
    obstacle_ = closest_on(held_, before);
    return;
  }
  Vector3 from = tissue.position(path.end);
  const Vector3 to = from + reach * tip_tangent_;
  int start = path.end.tetrahedron, came_from = -1;
  for (int i = 0; i < kMaxCrossings; ++i) {
    const Trace trace = trace_segment(tissue.mesh, tissue.x, start, from, to, tissue.regions, came_from);
    if (trace.next < 0) return;
    from = tissue.position(trace.end);
    const int region = tissue.regions[trace.next];
    if (tissue.borders.at(tissue.region(trace.end), region).holds) {
      obstacle_ = closest_on(region, from);
      obstacle_->under = obstacle_->at.normal.dot(needle.tip().position - obstacle_->at.position) < 0;
      return;
    }
    came_from = trace.end.tetrahedron;
    start = trace.next;
  }
}

// ------------------------------------------------------------------------------------------------------ 5. rows

bool Insertion::build_rows(const NeedleView& needle, const TissueView& tissue, std::span<const Path> paths,
                           Rows& rows) {
  if (path_ < 0) return !obstacle_ || add_surface(needle, tissue, rows);
  const Path& path = paths[path_];
  bool all = !left_out_;
  if (obstacle_ && obstacle_->under) {
    all = add_border(needle, tissue, path, rows) && all;
  } else if (phase_ != Phase::through) {
    all = add_tip(needle, tissue, path, rows) && all;
  }
  for (const ShaftPoint& point : shaft_) all = add_shaft(needle, tissue, path, point, rows) && all;
  return all;
}

// The tip against the obstacle, along its normal.
bool Insertion::add_contact(const NeedleView& needle, double puncture_force, double gap, Rows& rows) const {
  Row row{needle_, RowRole::contact, -1, needle.tip(), {obstacle_->material, {}, 0}, obstacle_->at.normal, gap};
  return rows.add(row, {LawKind::unilateral, puncture_force}, tip_.contact);
}

// And along its surface.
bool Insertion::add_contact_friction(const NeedleView& needle, const TissueView& tissue, double friction,
                                     double cohesion, int normal_row, Rows& rows) const {
  if (friction == 0 && cohesion == 0) return true;
  Row row{needle_, RowRole::contact_friction, -1, needle.tip(), {obstacle_->material, {}, 0}, Vector3::Zero(), 0};
  const Vector3 moved = (row.on_needle.position - tissue.position(obstacle_->material)) -
                        (needle.start_tip() - tissue.start_position(obstacle_->material));
  Vector3 across[2];
  perpendicular_basis(obstacle_->at.normal, across[0], across[1]);
  bool all = true;
  for (int k = 0; k < 2; ++k) {
    row.n = across[k];
    row.gap = row.n.dot(moved);
    const Law law{.kind = k == 0 ? LawKind::disk_first : LawKind::disk_second,
                  .limit = friction,
                  .normal_row = normal_row,
                  .cohesion = cohesion};
    all = rows.add(row, law, tip_.lateral.dot(row.n)) && all;
  }
  return all;
}

bool Insertion::add_surface(const NeedleView& needle, const TissueView& tissue, Rows& rows) const {
  const Interaction& law = tissue.interaction(obstacle_->material);
  const double apart = obstacle_->at.normal.dot(needle.tip().position - tissue.position(obstacle_->material));
  // A tip that starts the tick below the surface, torn out of its path sideways, is held where it is, not thrown out.
  const double gap = apart - std::min(0.0, obstacle_->at.distance);
  const int normal_row = rows.count();
  return add_contact(needle, law.puncture_force, gap, rows) &&
         add_contact_friction(needle, tissue, law.friction_contact, 0, normal_row, rows);
}

// A tip that rests against a border inside.
bool Insertion::add_border(const NeedleView& needle, const TissueView& tissue, const Path& path, Rows& rows) const {
  const Border& border = tissue.borders.at(tissue.region(obstacle_->material), obstacle_->region);
  const double apart = obstacle_->at.normal.dot(needle.tip().position - tissue.position(obstacle_->material));
  const int normal_row = rows.count();
  return add_contact(needle, border.puncture_force, std::max(apart, -kRecoverySpeed * needle.h), rows) &&
         add_contact_friction(needle, tissue, border.friction_contact, tissue.interaction(path.end).cutting_force,
                              normal_row, rows);
}

bool Insertion::add_tip(const NeedleView& needle, const TissueView& tissue, const Path& path, Rows& rows) const {
  const CurvePoint tip = needle.tip();
  bool all = true;
  if (!path.exited) {
    Row row{needle_, RowRole::cutting, -1, tip, {path.end, {}, 0}, -cutting_direction(needle), 0};
    row.gap = row.n.dot(tip.position - tissue.position(path.end));
    all = rows.add(row, {LawKind::unilateral, tissue.interaction(path.end).cutting_force}, tip_.cutting);
  }
  if (obstacle_) {
    const Border& border = tissue.borders.at(tissue.region(obstacle_->material), obstacle_->region);
    const double apart = obstacle_->at.normal.dot(tip.position - tissue.position(obstacle_->material));
    all = add_contact(needle, border.puncture_force, std::max(apart, -kRecoverySpeed * needle.h), rows) && all;
  }
  Vector3 across[2];
  perpendicular_basis(tip_tangent_, across[0], across[1]);
  Vector3 apart = tip.position - tissue.position(tip_point_);
  double compliance = 0;
  if (at_end_) {
    apart -= needle.start_tip() - tissue.start_position(tip_point_.a);
  } else {
    compliance = tissue.lateral_compliance(tip_point_.a, needle.model.diameter) / path.spacing;
    apart -= tip_offset_ * compliance * end_force_;
  }
  for (const Vector3& n : across) {
    const Row row{needle_, RowRole::tip_lateral, -1, tip, tip_point_, n, n.dot(apart), tip_softness_};
    all = rows.add(row, {.compliance = compliance}, tip_.lateral.dot(n)) && all;
  }
  if (at_end_) return all;
  return add_support(tissue, {needle_, RowRole::tip_lateral, -1, tip, {tip_point_.a, {}, 0}, Vector3::Zero(), 0}, rows) &&
         all;
}

bool Insertion::add_shaft(const NeedleView& needle, const TissueView& tissue, const Path& path,
                          const ShaftPoint& point, Rows& rows) const {
  const MaterialPoint& material = path.vertices[point.vertex];
  const CurvePoint on_needle = curve_point(needle.model, needle.shape, point.s);
  const Vector3 apart = on_needle.position - tissue.position(material);
  Row row{needle_, RowRole::lateral, point.vertex, on_needle, {material, {}, 0}, Vector3::Zero(), 0, point.softness};
  const double owned = std::max(point.owned, kLeastOwned * path.spacing);
  const double compliance = tissue.lateral_compliance(material, needle.model.diameter) / owned;
  Vector3 across[2];
  perpendicular_basis(point.tangent, across[0], across[1]);
  bool all = true;
  for (const Vector3& n : across) {
    row.n = n;
    row.gap = n.dot(apart);
    all = rows.add(row, {.compliance = compliance}, memory_[point.vertex].lateral.dot(n)) && all;
  }
  row.softness = 0;
  all = add_support(tissue, row, rows) && all;
  row.n = point.tangent;
  return add_friction(needle, tissue, point, row, rows) && all;
}

// A border that the path lies on keeps the needle out of the region behind it, however soft the tissue on this side is.
bool Insertion::add_support(const TissueView& tissue, Row row, Rows& rows) const {
  const auto normal = tissue.border_normal(row.in_tissue.a);
  if (!normal) return true;
  row.n = *normal;
  row.gap = row.n.dot(row.on_needle.position - tissue.position(row.in_tissue.a));
  return rows.add(row, {LawKind::unilateral, kInfinity}, 0);
}

bool Insertion::add_friction(const NeedleView& needle, const TissueView& tissue, const ShaftPoint& point, Row& row,
                             Rows& rows) const {
  const MaterialPoint& material = row.in_tissue.a;
  const Interaction& law = tissue.interaction(material);
  const Memory& memory = memory_[point.vertex];
  const double normal = point.owned * std::numbers::pi * needle.model.diameter * *law.pressure;
  const auto threshold = [&](bool slips) { return normal * (slips ? law.friction_dynamic : law.friction_static); };
  const double viscosity = point.owned * law.friction_viscous / needle.h;
  bool all = true;
  if (threshold(false) > 0 || viscosity > 0) {
    const Vector3 before = needle.start_position(point.s) - tissue.start_position(material);
    row.role = RowRole::friction;
    row.gap = row.n.dot(row.on_needle.position - tissue.position(material) - before);
    all = rows.add(row, {LawKind::friction, threshold(memory.sliding), viscosity}, memory.friction);
  }
  const double share = parameters_.torsional_friction;
  if (share * threshold(false) == 0) return all;
  row.role = RowRole::torsion;
  row.radius = needle.model.diameter / 2;
  row.gap = row.radius * row.n.dot(needle.turned(row.on_needle) -
                                   material_rotation(tissue.mesh, tissue.x_start, tissue.x, material.tetrahedron));
  return rows.add(row, {LawKind::friction, share * threshold(memory.turning)}, memory.torsion) && all;
}

void Insertion::read_forces(const Rows& rows, NeedleReport& report) {
  puncturing_ = cutting_ = false;
  tip_ = TipMemory{};
  report.tip_force.setZero();
  report.cutting_force.setZero();
  report.friction_force.setZero();
  report.lateral_force.setZero();
  for (const ShaftPoint& p : shaft_) memory_[p.vertex].lateral.setZero();

  for (int i = 0; i < rows.count(); ++i) {
    const Row& row = rows.row(i);
    if (row.needle != needle_) continue;
    const double lambda = rows.lambda()[i];
    const Vector3 force = rows.force(i);
    switch (row.role) {
      case RowRole::contact:
        tip_.contact = lambda;
        puncturing_ = lambda >= kAtCap * rows.law(i).limit && rows.delta()[i] < 0;
        report.cutting_force += force;
        break;
      case RowRole::contact_friction:
        tip_.lateral += force;
        report.cutting_force += force;
        break;
      case RowRole::cutting:
        tip_.cutting = lambda;
        cutting_ = lambda >= kAtCap * rows.law(i).limit;
        report.cutting_force += force;
        break;
      case RowRole::tip_lateral:
        tip_.lateral += force;
        report.lateral_force += force;
        break;
      case RowRole::lateral:
        memory_[row.index].lateral += force;
        report.lateral_force += force;
        break;
      case RowRole::friction:
        memory_[row.index].friction = lambda;
        memory_[row.index].sliding = std::abs(lambda) >= kAtCap * rows.law(i).limit;
        report.friction_force += force;
        break;
      case RowRole::torsion:
        memory_[row.index].torsion = lambda;
        memory_[row.index].turning = std::abs(lambda) >= kAtCap * rows.law(i).limit;
        break;
      case RowRole::guide:
      case RowRole::guide_friction:
        continue;
    }
    if (row.index < 0) report.tip_force += force;
  }
  if (at_end_) end_force_ = tip_.lateral;
}

// ----------------------------------------------------------------------------------------------- 9. transitions

std::uint32_t Insertion::transitions(const NeedleView& needle, const TissueView& tissue, std::uint64_t tick,
                                     std::vector<Path>& paths, std::vector<Event>& events) {
  const Transition now{needle, tissue, tick, events};
  if (path_ < 0) {
    leave_contact_or_puncture(now, paths);
    return 0;
  }
  Path& path = paths[path_];
  const int mouth_region = tissue.region(path.vertices[0]);
  if (reentered_) report(now, EventKind::reentry, mouth_region, 0);

  const CurvePoint tip = needle.tip();
  const Vector3 mouth_tangent = path_tangent(tissue, path, 0, tip.tangent);
  if (mouth_tangent.dot(tip.position - tissue.position(path.vertices[0])) < 0 &&
      tip.tangent.dot(tip.position - tissue.position(path.vertices[0])) < 0) {
    report(now, EventKind::withdrawal, mouth_region, 0);
    path.needle = -1;
    path.left = tick;
    reset();
    return 0;
  }
  return advance_end(now, path);
}

void Insertion::report(const Transition& now, EventKind kind, int region, double force) const {
  if (now.events.size() == now.events.capacity()) return;
  now.events.push_back({now.tick, needle_, kind, region, now.needle.tip().position, force});
}

void Insertion::leave_contact_or_puncture(const Transition& now, std::vector<Path>& paths) {
  depth_ = 0;
  const bool pressed = obstacle_ && tip_.contact > 0;
  const int region = obstacle_ ? obstacle_->region : 0;
  if (pressed && phase_ == Phase::free) report(now, EventKind::contact, region, tip_.contact);
  if (!pressed && phase_ == Phase::contact) report(now, EventKind::release, region, 0);
  phase_ = pressed ? Phase::contact : Phase::free;
  if (!obstacle_ || !puncturing_) return;

  const auto vacant = std::min_element(paths.begin(), paths.end(), forgotten_before);
  if (vacant->needle >= 0) return;  // a needle in every path: the surface keeps its cap
  report(now, EventKind::puncture, region, tip_.contact);
  place_mouth(now.needle.tip(), now.tissue);
  const MaterialPoint mouth = obstacle_->material;
  vacant->begin(mouth, parameters_.constraint_spacing);
  enter(static_cast<int>(vacant - paths.begin()), paths);
  grow(now, *vacant, mouth.tetrahedron, -1);
  if (vacant->exited) vacant->begin(mouth, parameters_.constraint_spacing);  // grazing an edge: not inside yet
}

// The mouth is where the needle crosses the surface; the point of contact is where the tip was a tick ago.
void Insertion::place_mouth(const CurvePoint& tip, const TissueView& tissue) {
  const auto crossing = tissue.surface.entry(tissue.x, tip.position - kContactMargin * tip.tangent, tip.position);
  if (crossing) obstacle_->material = tissue.surface.material(*crossing);
}

// The path's end after a tick inside: the border that holds it, growth, exit.
std::uint32_t Insertion::advance_end(const Transition& now, Path& path) {
  if (held_ >= 0 && !obstacle_) {
    report(now, EventKind::release, held_, 0);
    held_ = -1;
  }
  if (obstacle_ && (obstacle_->under || tip_.contact > 0)) return meet_border(now, path);

  const CurvePoint tip = now.needle.tip();
  const bool beyond = tip.tangent.dot(tip.position - now.tissue.position(path.end)) > 0;
  std::uint32_t flags = 0;
  if (!path.exited && beyond && cutting_) {
    const int region = now.tissue.region(path.end);
    flags = grow(now, path, path.end.tetrahedron, -1);
    if (path.exited) report(now, EventKind::exit, region, tip_.cutting);
  } else if (path.exited && beyond != (phase_ == Phase::through)) {
    report(now, beyond ? EventKind::exit : EventKind::reentry, now.tissue.region(path.end), 0);
  }
  if (path.exited) phase_ = beyond ? Phase::through : Phase::inside;
  return flags;
}

// The tip presses on a border, or has slid along it.
std::uint32_t Insertion::meet_border(const Transition& now, Path& path) {
  const TissueView& tissue = now.tissue;
  const Surface& surface = tissue.borders.surface(obstacle_->region);
  const int start = path.end.tetrahedron;
  const Vector3 from = tissue.position(path.end);
  if (puncturing_) {
    report(now, EventKind::crossing, obstacle_->region, tip_.contact);
    held_ = -1;
    const std::uint32_t flags = lay_vertices(now, path, start, from, tissue.position(obstacle_->material));
    path.end = obstacle_->material;
    return flags | grow(now, path, surface.beyond(obstacle_->at), path.end.tetrahedron);
  }
  const Vector3 tip = now.needle.tip().position;
  const SurfacePoint under = surface.closest(tissue.x, tip);
  const bool beside = (tip - under.position - under.distance * under.normal).norm() > kContactMargin;  // past its rim
  if (tip_.contact > 0 && !beside) {
    if (held_ < 0) report(now, EventKind::contact, obstacle_->region, tip_.contact);
    held_ = obstacle_->region;
    const std::uint32_t flags = lay_vertices(now, path, start, from, under.position);
    path.end = surface.material(under);
    return flags;
  }
  return grow(now, path, start, -1);
}

// Moves the path's end to the tip, through every border that does not hold it, to the first one that does. The end lies
// in tetrahedron `start`, or on its face towards `came_from`.
std::uint32_t Insertion::grow(const Transition& now, Path& path, int start, int came_from) {
  const TissueView& tissue = now.tissue;
  const Vector3 to = now.needle.tip().position;
  std::uint32_t flags = 0;
  for (int i = 0; i < kMaxCrossings && start >= 0; ++i) {
    const Vector3 from = tissue.position(path.end);
    const Trace trace = trace_segment(tissue.mesh, tissue.x, start, from, to, tissue.regions, came_from);
    flags |= lay_vertices(now, path, start, from, tissue.position(trace.end));
    path.end = trace.end;
    path.exited = trace.left && trace.end.weights.minCoeff() > -1e-6;
    if (trace.next < 0) break;
    const int region = tissue.regions[trace.next];
    if (tissue.borders.at(tissue.region(trace.end), region).holds) {
      if (held_ != region) report(now, EventKind::contact, region, tip_.contact);
      held_ = region;
      return flags;
    }
    report(now, EventKind::crossing, region, tip_.cutting);
    came_from = trace.end.tetrahedron;
    start = trace.next;
  }
  if (held_ >= 0) report(now, EventKind::release, held_, 0);
  held_ = -1;
  return flags;
}

// Sets the vertices that a straight piece of cut has passed, each at its exact distance.
std::uint32_t Insertion::lay_vertices(const Transition& now, Path& path, int start, const Vector3& from,
                                      const Vector3& to) {
  const double cut = (to - from).norm();
  std::uint32_t flags = 0;
  double next = path.spacing - path.tail;  // along the piece
  while (cut > 0 && next <= cut) {
    if (path.vertices.size() == path.vertices.capacity()) {
      flags |= kPathFull;
      break;
    }
    const Vector3 place = from + next / cut * (to - from);
    const double behind_tip = (now.needle.tip().position - place).norm();
    memory_[path.vertices.size()] = Memory{.s = now.needle.model.length - behind_tip};
    path.vertices.push_back(trace_segment(now.tissue.mesh, now.tissue.x, start, from, place).end);
    next += path.spacing;
  }
  path.tail = cut - (next - path.spacing);
  return flags;
}

}  // namespace acus
