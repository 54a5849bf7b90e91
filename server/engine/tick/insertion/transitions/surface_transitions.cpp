// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/tick/insertion/transitions/surface_transitions.h"

#include <algorithm>

#include "server/engine/state/needle/phase.h"
#include "server/engine/tick/insertion/finding/obstacle.h"
#include "server/engine/tick/insertion/tip_laws.h"
#include "server/engine/tick/insertion/transitions/path_growth.h"

namespace acus {

namespace {

// Slip below which a tip sticks to the surface: rounding.
constexpr double kLeastSlip = 1e-9;  // m
// A tip slips where it slides by more than twice what its base leads it, and this speed, besides.
constexpr double kSlipSpeed = 0.02;  // m/s

// The order in which new paths replace old ones: empty ones first, then the one left longest ago.
bool forgotten_before(const Path& a, const Path& b) {
  const auto rank = [](const Path& p) { return p.empty() ? 0 : p.needle < 0 ? 1 : 2; };
  return rank(a) != rank(b) ? rank(a) < rank(b) : a.left < b.left;
}

// The path to be replaced by a new one, or nullptr where a needle is in every one.
Path* find_vacant(std::vector<Path>& paths) {
  const auto vacant = std::min_element(paths.begin(), paths.end(), forgotten_before);
  return vacant->needle >= 0 ? nullptr : &*vacant;
}

void open_path(const Transition& now, Path& path, const MaterialPoint& mouth) {
  path.begin(mouth, now.at.parameters.constraint_spacing);
  enter(now.state, static_cast<int>(&path - now.paths.data()), now.at.parameters.length);
  path.needle = now.at.needle_index;
}

// Where the needle crosses the surface, searched as far behind the tip as its dimple lets it be, along a needle that
// may be tilted; else the contact point of the last tick.
MaterialPoint new_mouth(const Transition& now, const Obstacle& obstacle, double contact) {
  const TissueView& tissue = now.at.tissue;
  const CurvePoint tip = now.at.needle.tip();
  constexpr double kFlattest = 0.2;  // sine of the angle to the surface
  const double inwards = std::max(kFlattest, -obstacle.at.normal.dot(tip.tangent));
  const double behind = (kContactMargin + obstacle.dimple.depth(contact)) / inwards;
  const auto crossing = tissue.surface.entry(tissue.x, tip.position - behind * tip.tangent, tip.position);
  return crossing ? tissue.surface.material(*crossing) : obstacle.material;
}

// Of the tip over an obstacle in this tick (m).
Vector3 slid(const InsertionView& at, const Obstacle& obstacle) {
  const Vector3 moved = slip(at.tissue, obstacle, tip_of(at));
  const Vector3& n = obstacle.at.normal;
  return moved - n.dot(moved) * n;
}

// How far a straight needle's tip would have moved in this tick (m).
double led(const NeedleView& needle) {
  const CurvePoint before = curve_point(needle.model, needle.start, 0),
                   now = curve_point(needle.model, needle.shape, 0);
  return (now.position + needle.model.length * now.tangent - before.position - needle.model.length * before.tangent)
      .norm();
}

// The contact point after the slip of this tick.
MaterialPoint slid_point(const Transition& now, const Obstacle& obstacle, const Vector3& slid) {
  const TissueView& tissue = now.at.tissue;
  if (slid.norm() < kLeastSlip) return obstacle.material;
  return tissue.surface.material(tissue.surface.closest(tissue.x, tissue.position(obstacle.material) + slid));
}

// Contact and release of a tip outside, or through. Returns whether it punctures.
bool press_on_surface(const Transition& now) {
  Insertion& state = now.state;
  const auto& obstacle = now.scratch.located.obstacle;
  const double contact = state.tip.contact.along;
  const bool loaded = obstacle && contact > 0;
  // A fast tip may slide past its patch to where the surface is higher: no force on the patch, and yet no release.
  const bool pressed =
      loaded || (obstacle && touches(state) && noticed_inside(now.at.tissue, now.at.needle.tip().position));
  const int region = obstacle ? obstacle->region : 0;
  if (pressed && !touches(state)) now.report(EventKind::contact, region, contact);
  if (!pressed && touches(state)) now.report(EventKind::release, region, 0);
  const Vector3 slides = pressed ? slid(now.at, *obstacle) : Vector3(Vector3::Zero());
  const NeedleView& needle = now.at.needle;
  const bool slips = touches(state) && slides.norm() > 2 * led(needle) + kSlipSpeed * needle.h;
  if (slips && !state.slipping) now.report(EventKind::slip, region, contact);
  state.slipping = slips;
  state.touched = pressed ? slid_point(now, *obstacle, slides) : MaterialPoint{};
  return obstacle && obstacle->yields &&
         (now.scratch.puncturing ||
          (loaded && is_crushed(now.at.tissue.mesh, now.at.tissue.x, obstacle->patch.points)));
}

// The first piece of the cut behind the last mouth of a path.
void begin_cut(const Transition& now, Path& path, double contact) {
  grow(now, path, path.end.tetrahedron, -1);
  if (path.exited) path.shorten_to_mouth();  // grazing an edge
  // The cutting force begins with the contact force.
  now.state.tip.cut.along = std::min(contact, now.at.tissue.interaction(path.end).cutting_force);
}

// Adds a part, behind air, to the path of a needle that is through.
void add_part(const Transition& now, Path& path, const MaterialPoint& mouth) {
  Insertion& state = now.state;
  const CurvePoint tip = now.at.needle.tip();
  const double behind_tip = (tip.position - now.at.tissue.position(mouth)).norm();
  state.vertices[path.vertices.size()] = VertexState{.s = state.end_s};
  state.vertices[path.vertices.size() + 1] = VertexState{.s = now.at.needle.model.length - behind_tip};
  path.add_part(mouth);
  change_phase(state, Phase::inside);
  state.tip = TipState{};
  state.touched = MaterialPoint{};
  state.slipping = false;
  state.end_s = now.at.needle.model.length;
}

// The last crossing of the shaft into the tissue, and the place along the needle after it.
struct WayIn {
  SurfacePoint crossing;
  double s;  // m
};

std::optional<WayIn> way_in(const InsertionView& at, double from_s) {
  const auto position = [&](double s) { return curve_point(at.needle.model, at.needle.shape, s).position; };
  const double step = at.parameters.constraint_spacing;
  for (double s = at.needle.model.length; s > from_s; s -= step) {
    const auto crossing = at.tissue.surface.entry(at.tissue.x, position(std::max(from_s, s - step)), position(s));
    if (crossing) return WayIn{*crossing, s};
  }
  return std::nullopt;
}

// Lays vertices from the mouth to the needle's place s, and from there along the shaft to the tip. A path along the
// shaft has no forces yet, however the needle is bent.
std::uint32_t lay_along_shaft(const Transition& now, Path& path, const MaterialPoint& mouth, double s) {
  const TissueView& tissue = now.at.tissue;
  const NeedleView& needle = now.at.needle;
  std::uint32_t flags = 0;
  Vector3 from = tissue.position(mouth);
  int start = mouth.tetrahedron;
  std::size_t placed =
      path.vertices.size() - 1;  // vertices whose place along the needle is set; the mouth's is not yet
  while (true) {
    const Vector3 to = curve_point(needle.model, needle.shape, s).position;
    flags |= lay_vertices(now, path, start, from, to);
    for (; placed < path.vertices.size(); ++placed)
      now.state.vertices[placed].s = s - (to - tissue.position(path.vertices[placed])).norm();
    if (s >= needle.model.length) return flags;
    start = trace_segment(tissue.mesh, tissue.x, start, from, to).end.tetrahedron;
    from = to;
    s = std::min(s + path.spacing, needle.model.length);
  }
}

}  // namespace

void leave_contact_or_puncture(const Transition& now) {
  Insertion& state = now.state;
  const double contact = state.tip.contact.along;
  const bool punctured = press_on_surface(now);
  change_phase(state, touches(state) ? Phase::contact : Phase::free);
  if (!punctured) return;
  Path* const path = find_vacant(now.paths);
  if (!path) return;  // the contact force stays at its cap
  const Obstacle& obstacle = *now.scratch.located.obstacle;
  const double puncture_force = now.at.tissue.interaction(obstacle.material).puncture_force;
  now.report(EventKind::puncture, obstacle.region, force_along_needle(now.at, obstacle, puncture_force, contact));
  open_path(now, *path, new_mouth(now, obstacle, contact));
  begin_cut(now, *path, contact);
}

std::uint32_t go_through(const Transition& now, Path& path, bool beyond) {
  const auto& obstacle = now.scratch.located.obstacle;
  const double contact = now.state.tip.contact.along;
  const bool punctured = press_on_surface(now);
  if (!beyond) {
    change_phase(now.state, Phase::inside);
    now.state.touched = MaterialPoint{};
    now.report(EventKind::reentry, now.at.tissue.region(path.end), 0);
    return 0;
  }
  if (!punctured) return 0;
  if (!path.has_room_for_part()) return kPathFull;  // the contact force stays at its cap
  const double puncture_force = now.at.tissue.interaction(obstacle->material).puncture_force;
  now.report(EventKind::puncture, obstacle->region, force_along_needle(now.at, *obstacle, puncture_force, contact));
  add_part(now, path, new_mouth(now, *obstacle, contact));
  begin_cut(now, path, contact);
  return 0;
}

std::optional<MaterialPoint> noticed_inside(const TissueView& tissue, const Vector3& tip) {
  if (!tissue.surface.near(tissue.x, tip, 0)) return std::nullopt;
  const int inside = find_tetrahedron(tissue.mesh, tissue.x, tip);
  if (inside < 0 || (tip - tissue.surface.closest(tissue.x, tip).position).norm() < kUnnoticedDepth)
    return std::nullopt;
  return MaterialPoint{inside, barycentric(tissue.mesh, tissue.x, inside, tip)};
}

std::uint32_t open_where_found(const Transition& now) {
  const TissueView& tissue = now.at.tissue;
  const Insertion& state = now.state;
  if ((state.phase != Phase::free && state.phase != Phase::through) || touches(state)) return 0;
  const CurvePoint tip = now.at.needle.tip();
  const auto end = noticed_inside(tissue, tip.position);
  if (!end) return 0;
  const bool through = state.path >= 0;
  Path* const path = through ? &now.paths[state.path] : find_vacant(now.paths);
  if (!path || (through && !path->has_room_for_part())) return kTipFoundInside;

  now.report(EventKind::intrusion, tissue.region(*end), 0);
  const auto way = way_in(now.at, through ? state.end_s : 0);
  const MaterialPoint mouth =
      tissue.surface.material(way ? way->crossing : tissue.surface.closest(tissue.x, tip.position));
  if (through) {
    add_part(now, *path, mouth);
  } else {
    open_path(now, *path, mouth);
  }
  const std::uint32_t flags = lay_along_shaft(now, *path, mouth, way ? way->s : now.at.needle.model.length);
  path->end = *end;
  return flags | kTipFoundInside;
}

}  // namespace acus
