// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/tick/insertion/finding/shaft_contact.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "server/engine/math/rotation.h"
#include "server/engine/state/capacities.h"
#include "server/engine/tick/insertion/finding/obstacle.h"
#include "server/engine/tick/insertion/held_stretch.h"
#include "server/engine/tick/insertion/spring_memory.h"

namespace acus {

namespace {

constexpr int kSamples = 4;  // of a cell
// At which a contact's normal turns, at most.
constexpr double kTurningSpeed = 1;    // rad/s
constexpr double kTurning = 1e3;       // rad/m of the cell's way, besides
constexpr double kLeastLength = 1e-3;  // of a cell
constexpr double kDeepest = 10e-3;     // m, at which a contact begins

// A length of shaft at the start of the tick.
struct Cell {
  double from, length;  // m, along the needle
  Vector3 middle;       // m, world
  double moves;         // m, its middle in the tick
  double reach;         // r (m)
};

Cell cell_at(const InsertionView& at, double from, double length) {
  const NeedleView& needle = at.needle;
  const double s = from + length / 2;
  const Vector3 middle = needle.start_position(s);
  const double moves = (curve_point(needle.model, needle.shape, s).position - middle).norm();
  return {from, length, middle, moves, kContactMargin + 2 * moves};
}

// Whether a cell cannot be nearer than its reach.
bool surely_clear(const InsertionView& at, const Cell& cell, const ShaftCell& state) {
  const double since = (cell.middle - state.looked_from).norm() + at.tissue.surface_moved - state.moved;
  return state.distance - since - cell.length / 2 > cell.reach;
}

// 0 near the stretch that other rows hold, then 1.
double free_share(const HeldStretch& held, double s) {
  return std::clamp(2 * held.apart(s) / kHeldBeside - 1, 0.0, 1.0);
}

// 1 where the needle lies within 40 degrees of the surface, 0 where it stands within 18 of its normal.
double flat_share(const Vector3& tangent, const Vector3& normal) {
  const double upright = tangent.dot(normal);
  return std::clamp(2 * (0.9 - upright * upright), 0.0, 1.0);
}

// Of p from the surface (m), negative inside. Beside an edge of the body SurfacePoint::distance is that along the
// normal of either face: small, and negative past its plane.
double signed_distance(const SurfacePoint& nearest, const Vector3& p) {
  constexpr double kAcross = 0.3;  // cosine of the way to p with the normal
  const double distance = (p - nearest.position).norm();
  return nearest.distance < -kAcross * distance ? -distance : distance;
}

// What the samples of a cell come to.
struct Gathered {
  double weight = 0;
  double s = 0;                      // m, weighted
  double length = 0;                 // m
  Vector3 normal = Vector3::Zero();  // weighted, across the needle
};

Gathered gather(const InsertionView& at, const Cell& cell, const HeldStretch& held) {
  Gathered sum;
  const double step = cell.length / kSamples;
  for (int i = 0; i < kSamples; ++i) {
    const double s = cell.from + (i + 0.5) * step;
    const double share = free_share(held, s);
    if (share == 0) continue;
    const CurvePoint point = curve_point(at.needle.model, at.needle.start, s);
    const SurfacePoint nearest = at.tissue.surface.closest(at.tissue.x_start, point.position);
    const double flat = share * flat_share(point.tangent, nearest.normal);
    const double within = std::max(0.0, cell.reach - signed_distance(nearest, point.position));
    const double weight = flat * within * within;
    sum.length += flat * step * std::min(1.0, within / cell.reach);
    sum.weight += weight;
    sum.s += weight * s;
    sum.normal += weight * (nearest.normal - nearest.normal.dot(point.tangent) * point.tangent).stableNormalized();
  }
  return sum;
}

// Puts the points of `contact`. Returns how far the needle is over them in the mean (m).
double put_points(const InsertionView& at, const Cell& cell, ShaftContact& contact) {
  double over = 0;
  for (int i = 0; i < kContactPoints; ++i) {
    const Vector3 p = at.needle.start_position(contact_place(contact.s, contact.length, i, at.needle.model.length));
    const SurfacePoint under = surface_under(at.tissue, p, contact.normal, cell.reach);
    contact.points[i] = at.tissue.surface.material(under);
    contact.points[i].weights /= kContactPoints;
    over += contact.normal.dot(p - under.position) / kContactPoints;
  }
  return over;
}

// A unit vector `from`, turned towards another one by an angle (rad) at most.
Vector3 turned_towards(const Vector3& from, const Vector3& to, double angle) {
  const Vector3 across = (to - to.dot(from) * from).stableNormalized();
  if (to.isZero(0)) return from;
  if (std::atan2(to.dot(across), to.dot(from)) <= angle) return to;
  return std::cos(angle) * from + std::sin(angle) * across;
}

// Whether the cell may be near the surface; remembers how far away that is.
bool is_near(const InsertionView& at, const Cell& cell, ShaftCell& state) {
  const SurfacePoint nearest = at.tissue.surface.closest(at.tissue.x_start, cell.middle);
  state.looked_from = cell.middle;
  state.distance = std::max(0.0, signed_distance(nearest, cell.middle));
  state.moved = at.tissue.surface_moved;
  if (state.distance - cell.length / 2 > cell.reach) return false;
  const Vector3 along = curve_point(at.needle.model, at.needle.start, cell.from + cell.length / 2).tangent;
  return state.length > 0 || flat_share(along, nearest.normal) > 0;
}

GrooveSpring groove_under(const InsertionView& at, const ShaftContact& contact, const Creep& creep) {
  const MaterialPoint& middle = contact.points[kContactPoints / 2];
  GrooveSpring groove = at.tissue.groove_spring(middle, at.needle.model.diameter, contact.length);
  groove.relax(at.tissue.relaxation_of(middle), creep.along);
  return groove;
}

// Of a contact that stands for a part of its cell: nothing where that is the whole, without bound where it is nothing.
// So a contact comes and goes smoothly on any mesh. m/N.
double partial_compliance(const InsertionView& at, const ShaftContact& contact) {
  constexpr double kPartial = 0.01;  // small next to a groove
  const MaterialPoint& middle = contact.points[kContactPoints / 2];
  const double stiffness = at.tissue.moduli(middle).young * contact.length;
  const double cell = at.needle.model.length / shaft_cells(at.parameters);
  return kPartial * std::max(0.0, cell / contact.length - 1) / stiffness;
}

// Of a cell whose point is `over` (m) the surface, and sunk into it (m) by its springs: what is more of that than these
// and the last offset explain, and than the cell can have moved, is taken up by the offset, which is closed slowly.
double next_offset(const ShaftCell& state, double sunk, double over, double moves, double h) {
  const double unexplained = over + sunk - state.offset;
  if (state.contact.along == 0 && unexplained > 0) return std::min(0.0, over);  // it comes out
  const double most = moves + kSettlingSpeed * h;
  const double explained =
      state.contact.along > 0 ? std::clamp(unexplained, -most, most) : std::max(unexplained, -most);
  return shrunk(state.offset + unexplained - explained, kSettlingSpeed * h);
}

// The contact of a cell, if it has one.
std::optional<ShaftContact> look_for_contact(const InsertionView& at, const Cell& cell, const HeldStretch& held,
                                             int index, std::vector<ShaftCell>& cells) {
  ShaftCell& state = cells[static_cast<std::size_t>(index)];
  if (!is_near(at, cell, state)) return std::nullopt;
  const Gathered found = gather(at, cell, held);
  if (found.weight == 0 || found.length < kLeastLength * cell.length) return std::nullopt;
  ShaftContact contact;
  contact.cell = index;
  contact.s = found.s / found.weight;
  contact.length = found.length;
  const bool begins = state.length == 0;
  const CurvePoint point = curve_point(at.needle.model, at.needle.start, contact.s);
  const double angle = kTurningSpeed * at.needle.h + kTurning * cell.moves;
  const Vector3 normal = begins ? found.normal : turned_towards(state.normal, found.normal.stableNormalized(), angle);
  contact.normal = (normal - normal.dot(point.tangent) * point.tangent).stableNormalized();
  if (!(contact.normal.squaredNorm() > 0.5)) return std::nullopt;  // the sides of a thin sheet cancel
  const double over = put_points(at, cell, contact);
  if (begins) {
    if (-over > kDeepest) return std::nullopt;
    state.offset = std::min(0.0, over) * contact.length / cell.length;
    state.contact.creep = {};
  } else {
    const double longer = contact.length / state.length;
    state.contact.along *= longer;
    state.contact.across *= longer;
    state.contact.creep.along *= longer;
    const double f = state.contact.along;
    const GrooveSpring groove = groove_under(at, contact, state.contact.creep);
    state.offset =
        next_offset(state, groove.depth(f) + partial_compliance(at, contact) * f, over, cell.moves, at.needle.h);
    creep_to(at.tissue.relaxation_of(contact.points[kContactPoints / 2]), groove.at_rest(f), state.contact.creep.along);
  }
  state.normal = contact.normal;
  return contact;
}

}  // namespace

double contact_place(double s, double length, int point, double needle_length) {
  return std::clamp(s + (point - (kContactPoints - 1) / 2.0) * length / kContactPoints, 0.0, needle_length);
}

SurfacePoint surface_under(const TissueView& tissue, const Vector3& p, const Vector3& n, double reach) {
  const SurfacePoint nearest = tissue.surface.closest(tissue.x_start, p);
  const double above = kContactMargin + 2 * std::max(0.0, -signed_distance(nearest, p));
  return tissue.surface.entry(tissue.x_start, p + above * n, p - reach * n).value_or(nearest);
}

void find_shaft_contacts(const InsertionView& at, InsertionScratch& scratch) {
  if (at.tissue.surface.empty()) return;
  std::vector<ShaftCell>& cells = scratch.next.cells;
  const HeldStretch held = held_stretch(at, scratch.located, scratch.next);
  const double length = at.needle.model.length / static_cast<double>(cells.size());
  for (std::size_t i = 0; i < cells.size(); ++i) {
    std::optional<ShaftContact> contact;
    const double from = length * static_cast<double>(i);
    if (free_share(held, from) > 0 || free_share(held, from + length) > 0) {
      const Cell cell = cell_at(at, from, length);
      if (!surely_clear(at, cell, cells[i])) contact = look_for_contact(at, cell, held, static_cast<int>(i), cells);
    }
    cells[i].s = contact ? contact->s : 0;
    cells[i].length = contact ? contact->length : 0;
    if (contact) scratch.located.contacts.push_back(*contact);
  }
}

Contact make_contact(const InsertionView& at, InsertionScratch& scratch, const ShaftContact& found) {
  const TissueView& tissue = at.tissue;
  const NeedleView& needle = at.needle;
  ShaftCell& state = scratch.next.cells[static_cast<std::size_t>(found.cell)];
  Contact contact{.kind = ContactKind::shaft,
                  .needle = at.needle_index,
                  .on_needle = curve_point(needle.model, needle.shape, found.s),
                  .state = &state.contact};
  contact.foot.patch = found.points;
  const Vector3 apart_now = contact.on_needle.position - mean_position(tissue.mesh, tissue.x, found.points);
  const Vector3 apart_before =
      needle.start_position(found.s) - mean_position(tissue.mesh, tissue.x_start, found.points);
  const GrooveSpring groove = groove_under(at, found, state.contact.creep);
  const double f = state.contact.along, e = groove.compliance(f);
  Normal hold{.n = found.normal,
              .gap = found.normal.dot(apart_now) - state.offset,
              .most = is_crushed(tissue.mesh, tissue.x_start, found.points) ? f : kInfinity,
              .before = f,
              .compliance = partial_compliance(at, found),
              .spring = {groove.depth(f), e, groove.energy(f) - e * f * f / 2}};
  const double friction = tissue.interaction(found.points[kContactPoints / 2]).friction_contact;
  if (friction > 0) hold.friction = {.slip = apart_now - apart_before, .friction = friction};
  contact.hold = hold;
  return contact;
}

}  // namespace acus
