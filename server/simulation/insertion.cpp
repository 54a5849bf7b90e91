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

// The parameter s near `guess` where the needle's curve passes through the plane at p across t.
double project_on_curve(const NeedleView& needle, const Vector3& p, const Vector3& t, double guess) {
  constexpr int kIterations = 8;
  constexpr double kStop = 1e-13;  // m
  double s = guess;
  for (int i = 0; i < kIterations; ++i) {
    const CurvePoint c = curve_point(needle.model, needle.shape, s);
    const double slope = std::max(c.tangent.dot(t), 0.1);  // the needle runs along its path, not across it
    const double step = std::clamp(t.dot(p - c.position) / slope, -needle.model.length, needle.model.length);
    s += step;
    if (std::abs(step) < kStop) break;
  }
  return s;
}

// Which of two paths a new one may take the place of: empty ones first, then the one left longest ago.
bool forgotten_before(const Path& a, const Path& b) {
  const auto rank = [](const Path& p) { return p.empty() ? 0 : p.needle < 0 ? 1 : 2; };
  return rank(a) != rank(b) ? rank(a) < rank(b) : a.left < b.left;
}

}  // namespace

int Insertion::max_points(const Needle& p) { return 2 * static_cast<int>(std::ceil(p.length / p.constraint_spacing)) + 4; }

Insertion::Insertion(int needle, const Needle& parameters, int path_capacity)
    : needle_(needle), parameters_(parameters) {
  memory_.resize(static_cast<std::size_t>(path_capacity));
  shaft_.reserve(static_cast<std::size_t>(max_points(parameters)));
}

void Insertion::reset() {
  phase_ = Phase::free;
  path_ = -1;
  depth_ = 0;
  touching_ = reentered_ = puncturing_ = cutting_ = at_end_ = false;
  std::fill(memory_.begin(), memory_.end(), Memory{});
  shaft_.clear();
  tip_ = TipMemory{};
}

// ---------------------------------------------------------------------------------------------------- 4. locate

void Insertion::locate(const NeedleView& needle, const TissueView& tissue, std::vector<Path>& paths) {
  touching_ = reentered_ = left_out_ = false;
  shaft_.clear();
  if (path_ < 0) locate_outside(needle, tissue, paths);
  if (path_ >= 0) locate_inside(needle, tissue, paths[path_]);
}

void Insertion::locate_outside(const NeedleView& needle, const TissueView& tissue, std::vector<Path>& paths) {
  const Vector3 before = curve_point(needle.model, needle.start, needle.model.length).position;
  const CurvePoint tip = needle.tip();
  const double margin = kContactMargin + 2 * (tip.position - before).norm();
  if (!tissue.surface.near(tissue.x, before, margin)) return;
  if (phase_ == Phase::contact) {
    contact_ = tissue.surface.closest(tissue.x, before);
  } else {
    const auto entry = tissue.surface.entry(tissue.x, before, tip.position);
    contact_ = entry ? *entry : tissue.surface.closest(tissue.x, before);
  }
  if (std::abs(contact_.distance) > margin && phase_ != Phase::contact) return;

  // An open mouth under the tip: no surface to push against.
  for (int i = 0; i < static_cast<int>(paths.size()); ++i) {
    const Path& path = paths[i];
    if (path.empty() || path.needle >= 0) continue;
    if ((tissue.position(path.vertices[0]) - contact_.position).norm() > needle.model.diameter) continue;
    if (contact_.normal.dot(tip.position - contact_.position) < 0) {
      enter(i, paths);
      reentered_ = true;
    }
    return;
  }
  contact_material_ = tissue.surface.material(contact_);
  touching_ = true;
}

void Insertion::enter(int path, std::vector<Path>& paths) {
  path_ = path;
  paths[path].needle = needle_;
  phase_ = Phase::inside;
  tip_ = TipMemory{};
  std::fill(memory_.begin(), memory_.end(), Memory{.s = parameters_.length});
  end_s_ = parameters_.length;
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
      shaft_.push_back({i, s, 0, tangent});
    } else {
      left_out_ = true;
    }
  }
  end_s_ = project_on_curve(needle, tissue.position(path.end), end_tangent(tissue, path, tip_tangent), end_s_);
  place_tip(needle, tissue, path);
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

// Where the tip stands in its path: at the end, where it cuts, or back inside, between two vertices.
void Insertion::place_tip(const NeedleView& needle, const TissueView& tissue, const Path& path) {
  const Vector3 tip_tangent = needle.tip().tangent;
  const double length = needle.model.length;
  const int count = holding_vertices(path);
  int next = 0;
  while (next < count && memory_[next].s <= length) ++next;
  const bool tail = next == count;  // between the last vertex and the end
  const double next_s = tail ? end_s_ : memory_[next].s;
  at_end_ = tail && next_s <= length && !path.exited;
  if (at_end_ || next == 0) {
    tip_point_ = {at_end_ ? path.end : path.vertices[0], {}, 0};
    const double spacings = path.tail / parameters_.constraint_spacing +
                            static_cast<double>(path.vertices.size() - static_cast<std::size_t>(count));
    tip_fade_ = at_end_ ? std::max(0.0, 1 - spacings) : 0;  // by the cut since the last vertex that holds
    tip_tangent_ = tip_tangent;
    return;
  }
  const double from_s = memory_[next - 1].s;
  const double u = next_s > from_s ? std::clamp((length - from_s) / (next_s - from_s), 0.0, 1.0) : 1;
  tip_point_ = {path.vertices[next - 1], tail ? path.end : path.vertices[next], u};
  tip_fade_ = 1 - u;
  const Vector3 from = path_tangent(tissue, path, next - 1, tip_tangent);
  const Vector3 to = tail ? end_tangent(tissue, path, tip_tangent) : path_tangent(tissue, path, next, tip_tangent);
  tip_tangent_ = ((1 - u) * from + u * to).normalized();
}

// ------------------------------------------------------------------------------------------------------ 5. rows

bool Insertion::build_rows(const NeedleView& needle, const TissueView& tissue, std::span<const Path> paths,
                           Rows& rows) {
  if (touching_) return add_contact(needle, tissue, rows);
  if (path_ < 0) return true;
  const Path& path = paths[path_];
  bool all = phase_ == Phase::through || add_tip(needle, tissue, path, rows);
  all = all && !left_out_;
  for (const ShaftPoint& point : shaft_) all = add_shaft(needle, tissue, path, point, rows) && all;
  return all;
}

bool Insertion::add_contact(const NeedleView& needle, const TissueView& tissue, Rows& rows) const {
  const Interaction& law = tissue.interaction(contact_material_);
  Row row{needle_, RowRole::contact, -1, needle.tip(), {contact_material_, {}, 0}, contact_.normal, 0};
  const Vector3 apart = row.on_needle.position - tissue.position(contact_material_);
  // A tip that starts the tick below the surface, torn out of its path sideways, is held where it is, not thrown out.
  row.gap = row.n.dot(apart) - std::min(0.0, contact_.distance);
  const int normal_row = rows.count();
  bool all = rows.add(row, {LawKind::unilateral, law.puncture_force}, tip_.normal);
  if (law.friction_contact == 0) return all;

  const Vector3 before = curve_point(needle.model, needle.start, needle.model.length).position -
                         tissue.start_position(contact_material_);
  Vector3 across[2];
  perpendicular_basis(contact_.normal, across[0], across[1]);
  for (int k = 0; k < 2; ++k) {
    row.role = RowRole::contact_friction;
    row.n = across[k];
    row.gap = row.n.dot(apart - before);
    const LawKind kind = k == 0 ? LawKind::disk_first : LawKind::disk_second;
    all = rows.add(row, {kind, law.friction_contact, 0, normal_row}, tip_.lateral.dot(row.n)) && all;
  }
  return all;
}

bool Insertion::add_tip(const NeedleView& needle, const TissueView& tissue, const Path& path, Rows& rows) const {
  const CurvePoint tip = needle.tip();
  bool all = true;
  if (!path.exited) {
    Row row{needle_, RowRole::cutting, -1, tip, {path.end, {}, 0}, -tip.tangent, 0};
    row.gap = row.n.dot(tip.position - tissue.position(path.end));
    all = rows.add(row, {LawKind::unilateral, tissue.interaction(path.end).cutting_force}, tip_.normal);
  }
  Vector3 across[2];
  perpendicular_basis(tip_tangent_, across[0], across[1]);
  const Vector3 apart = tip.position - tissue.position(tip_point_);
  for (const Vector3& n : across) {
    const Row row{needle_, RowRole::tip_lateral, -1, tip, tip_point_, n, n.dot(apart), tip_fade_ * tip_fade_};
    all = rows.add(row, {}, tip_.lateral.dot(n)) && all;
  }
  return all;
}

bool Insertion::add_shaft(const NeedleView& needle, const TissueView& tissue, const Path& path,
                          const ShaftPoint& point, Rows& rows) const {
  const MaterialPoint& material = path.vertices[point.vertex];
  const Memory& memory = memory_[point.vertex];
  const CurvePoint on_needle = curve_point(needle.model, needle.shape, point.s);
  const Vector3 apart = on_needle.position - tissue.position(material);
  Row row{needle_, RowRole::lateral, point.vertex, on_needle, {material, {}, 0}, Vector3::Zero(), 0};
  Vector3 across[2];
  perpendicular_basis(point.tangent, across[0], across[1]);
  bool all = true;
  for (const Vector3& n : across) {
    row.n = n;
    row.gap = n.dot(apart);
    all = rows.add(row, {}, memory.lateral.dot(n)) && all;
  }

  const Interaction& law = tissue.interaction(material);
  const double mu = memory.sliding ? law.friction_dynamic : law.friction_static;
  const double threshold = point.owned * std::numbers::pi * needle.model.diameter * mu * law.pressure;
  const double viscosity = point.owned * law.friction_viscous / needle.h;
  if (threshold == 0 && viscosity == 0) return all;
  const Vector3 before =
      curve_point(needle.model, needle.start, point.s).position - tissue.start_position(material);
  row.role = RowRole::friction;
  row.n = point.tangent;
  row.gap = row.n.dot(apart - before);
  return rows.add(row, {LawKind::friction, threshold, viscosity}, memory.friction) && all;
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
        tip_.normal = lambda;
        puncturing_ = lambda >= kAtCap * rows.law(i).limit && rows.delta()[i] < 0;
        report.cutting_force += force;
        break;
      case RowRole::contact_friction:
        tip_.lateral += force;
        report.cutting_force += force;
        break;
      case RowRole::cutting:
        tip_.normal = lambda;
        cutting_ = lambda >= kAtCap * rows.law(i).limit;
        report.cutting_force += force;
        break;
      case RowRole::tip_lateral:
        tip_.lateral += force;
        report.lateral_force += force;
        break;
      case RowRole::lateral:
        memory_[row.vertex].lateral += force;
        report.lateral_force += force;
        break;
      case RowRole::friction:
        memory_[row.vertex].friction = lambda;
        memory_[row.vertex].sliding = std::abs(lambda) >= kAtCap * rows.law(i).limit;
        report.friction_force += force;
        break;
    }
    if (row.vertex < 0) report.tip_force += force;
  }
}

// ----------------------------------------------------------------------------------------------- 9. transitions

std::uint32_t Insertion::transitions(const NeedleView& needle, const TissueView& tissue, std::uint64_t tick,
                                     std::vector<Path>& paths, std::vector<Event>& events) {
  const CurvePoint tip = needle.tip();
  const auto report = [&](EventKind kind) {
    if (events.size() < events.capacity()) events.push_back({tick, needle_, kind, tip.position, tip_.normal});
  };
  if (path_ < 0) {
    leave_contact_or_puncture(needle, tissue, tick, paths, events);
    return 0;
  }
  if (reentered_) report(EventKind::reentry);
  Path& path = paths[path_];

  const Vector3 mouth_tangent = path_tangent(tissue, path, 0, tip.tangent);
  if (mouth_tangent.dot(tip.position - tissue.position(path.vertices[0])) < 0 &&
      tip.tangent.dot(tip.position - tissue.position(path.vertices[0])) < 0) {
    report(EventKind::withdrawal);
    path.needle = -1;
    path.left = tick;
    reset();
    return 0;
  }

  std::uint32_t flags = 0;
  const bool beyond = tip.tangent.dot(tip.position - tissue.position(path.end)) > 0;
  if (!path.exited && beyond && cutting_) {
    flags = grow(needle, tissue, path);
    if (path.exited) report(EventKind::exit);
  }
  if (path.exited) phase_ = beyond ? Phase::through : Phase::inside;
  return flags;
}

void Insertion::leave_contact_or_puncture(const NeedleView& needle, const TissueView& tissue, std::uint64_t tick,
                                          std::vector<Path>& paths, std::vector<Event>& events) {
  const auto report = [&](EventKind kind, double force) {
    if (events.size() < events.capacity()) events.push_back({tick, needle_, kind, needle.tip().position, force});
  };
  depth_ = 0;
  const bool pressed = touching_ && tip_.normal > 0;
  if (pressed && phase_ == Phase::free) report(EventKind::contact, tip_.normal);
  if (!pressed && phase_ == Phase::contact) report(EventKind::release, 0);
  phase_ = pressed ? Phase::contact : Phase::free;
  if (!touching_ || !puncturing_) return;

  const auto vacant = std::min_element(paths.begin(), paths.end(), forgotten_before);
  if (vacant->needle >= 0) return;  // a needle in every path: the surface keeps its cap
  report(EventKind::puncture, tip_.normal);
  place_mouth(needle.tip(), tissue);
  vacant->vertices.clear();
  vacant->vertices.push_back(contact_material_);
  vacant->end = contact_material_;
  vacant->tail = 0;
  vacant->spacing = parameters_.constraint_spacing;
  vacant->exited = false;
  enter(static_cast<int>(vacant - paths.begin()), paths);
  grow(needle, tissue, *vacant);
  if (vacant->exited) {  // grazing an edge: the tip is not inside yet
    vacant->vertices.resize(1);
    vacant->exited = false;
    vacant->end = contact_material_;
    vacant->tail = 0;
  }
}

// The mouth is where the needle crosses the surface; the point of contact is where the tip was a tick ago.
void Insertion::place_mouth(const CurvePoint& tip, const TissueView& tissue) {
  const auto crossing = tissue.surface.entry(tissue.x, tip.position - kContactMargin * tip.tangent, tip.position);
  if (crossing) contact_material_ = tissue.surface.material(*crossing);
}

// Moves the path's end to the tip and sets the vertices that the cut has passed, each at its exact distance.
std::uint32_t Insertion::grow(const NeedleView& needle, const TissueView& tissue, Path& path) {
  const Vector3 from = tissue.position(path.end);
  const Vector3 to = needle.tip().position;
  const int start = path.end.tetrahedron;
  const Trace trace = trace_segment(tissue.mesh, tissue.x, start, from, to);
  const Vector3 reached = tissue.position(trace.end);
  const double cut = (reached - from).norm();

  const double spacing = path.spacing;
  std::uint32_t flags = 0;
  double next = spacing - path.tail;  // along the segment
  while (cut > 0 && next <= cut) {
    if (path.vertices.size() == path.vertices.capacity()) {
      flags |= kPathFull;
      break;
    }
    const Vector3 place = from + next / cut * (reached - from);
    memory_[path.vertices.size()] = Memory{.s = needle.model.length - (cut - next)};
    path.vertices.push_back(trace_segment(tissue.mesh, tissue.x, start, from, place).end);
    next += spacing;
  }
  path.tail = cut - (next - spacing);
  path.end = trace.end;
  path.exited = trace.left && trace.end.weights.minCoeff() > -1e-6;
  return flags;
}

}  // namespace acus
