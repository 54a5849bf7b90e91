// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/tick/contact/needle_contact.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "server/engine/state/capacities.h"

namespace acus {

namespace {

constexpr double kCrossing = 1e-3;   // rad: needles at a smaller angle are side by side
constexpr int kSteps = 4;            // towards a crossing
constexpr double kGive = 1e-6;       // e (m/N)
constexpr double kOneContact = 0.3;  // of a cell: two contacts that are nearer are one
constexpr double kMargin = 1e-3;     // m, in which two needles have rows before they touch

// How far a node may go in the tick, by its speed or with its base (m).
double most_moved(const NeedleState& state, const NeedleShape& start, const NeedleShape& shape, double h) {
  double most = 0;
  for (Eigen::Index i = 0; i < start.x.cols(); ++i)
    most = std::max(
        {most, (shape.x.col(i) - start.x.col(i)).squaredNorm(), h * h * state.v.col(i).head<3>().squaredNorm()});
  return std::sqrt(most);
}

// Where the needles cross between s = `from` and `to` (m) of the first: the line between their nearest points, which
// are not drawn to a middle; zero where they lie side by side, or are nearest beyond.
Vector3 apart_at_crossing(const ShapedNeedle& a, const ShapedNeedle& b, NearestPoints points, double from, double to) {
  for (int step = 0; step < kSteps; ++step) {
    const CurvePoint on_a = curve_point(a.model, a.shape, points.s), on_b = curve_point(b.model, b.shape, points.t);
    points.apart = on_a.position - on_b.position;
    const double c = on_a.tangent.dot(on_b.tangent), square = 1 - c * c;
    if (square < kCrossing * kCrossing) return Vector3::Zero();
    const double of_a = points.apart.dot(on_a.tangent), of_b = points.apart.dot(on_b.tangent);
    points.s += (c * of_b - of_a) / square;
    points.t += (of_b - c * of_a) / square;
    const bool there = points.s >= from && points.s <= to && points.t >= 0 && points.t <= b.cells.end();
    if (!there) return Vector3::Zero();
  }
  return points.apart;
}

// From the second needle to the first. Across both where they cross, though the points may have been drawn beside the
// crossing; else along the line between the points.
Vector3 direction(const ShapedNeedle& a, const ShapedNeedle& b, const NearestPoints& points, double from, double to) {
  for (const Vector3& apart : {apart_at_crossing(a, b, points, from, to), points.apart})
    if (apart.norm() > 0) return apart.normalized();
  return curve_point(a.model, a.shape, points.s).tangent.unitOrthogonal();
}

// In place of the one with the widest gap where there is no room; false if that is the contact itself.
bool keep(const NeedleContact& contact, NeedleContacts& contacts) {
  if (!contacts.found.full()) {
    contacts.found.push_back(contact);
    return true;
  }
  contacts.left_out = true;
  NeedleContact& widest = *std::ranges::max_element(contacts.found, {}, &NeedleContact::gap);
  if (contact.gap < widest.gap) widest = contact;
  return false;
}

// `contact` is one of the pair. Where those of two cells are near each other it is one contact, of both cells.
void find_contacts_of_pair(const ShapedNeedle& a, const ShapedNeedle& b, double reach, NeedleContact contact,
                           NeedleContacts& contacts) {
  std::optional<NearestPoints> before;  // of the cell before
  bool is_of_cell_before = false;       // the last contact that was kept
  for (int cell = 0; cell < a.cells.count(); ++cell) {
    auto points = nearest_points(a, cell, cell, b, reach);
    const bool same = before && points && points->s - before->s < kOneContact * a.cells.length;
    const auto joint = same ? nearest_points(a, cell - 1, cell, b, reach) : std::nullopt;
    if (joint) points = joint;
    before = points;
    if (!points) continue;
    contact.s = points->s;
    contact.t = points->t;
    const double from = a.cells.length * (joint ? cell - 1 : cell), to = a.cells.length * (cell + 1);
    contact.normal = direction(a, b, *points, from, to);
    contact.gap = contact.normal.dot(points->apart) - a.cells.radius - b.cells.radius;
    if (joint && is_of_cell_before)
      contacts.found.back() = contact;
    else
      is_of_cell_before = keep(contact, contacts);
  }
}

}  // namespace

NeedleContacts::NeedleContacts(const Scene& scene) : found(static_cast<std::size_t>(max_needle_contacts(scene))) {
  if (found.capacity() == 0) return;
  moves.resize(scene.needles.size());
  for (const Needle& needle : scene.needles) cells.emplace_back(needle_cells(needle));
}

void find_needle_contacts(const Model& model, const State& state, std::span<const NeedleShape> start_shapes,
                          std::span<const NeedleScratch> needles, NeedleContacts& contacts) {
  contacts.found.clear();
  contacts.left_out = false;
  for (std::size_t i = 0; i < contacts.cells.size(); ++i) {
    put_cells(model.needles[i], start_shapes[i], contacts.cells[i]);
    contacts.moves[i] = most_moved(state.needles[i], start_shapes[i], needles[i].shape(), model.h);
  }
  const auto shaped = [&](std::size_t i) { return ShapedNeedle{model.needles[i], start_shapes[i], contacts.cells[i]}; };
  for (std::size_t j = 1; j < contacts.cells.size(); ++j)
    for (std::size_t i = 0; i < j; ++i) {
      const double reach = kMargin + 2 * (contacts.moves[i] + contacts.moves[j]);
      if (!may_be_within(contacts.cells[i], contacts.cells[j], reach)) continue;
      find_contacts_of_pair(shaped(i), shaped(j), reach, {.first = static_cast<int>(i), .second = static_cast<int>(j)},
                            contacts);
    }
}

Contact make_contact(const NeedleView& first, const NeedleView& second, double friction, const NeedleContact& found) {
  Contact contact{
      .kind = ContactKind::needles, .needle = found.first, .on_needle = curve_point(first.model, first.shape, found.s)};
  contact.foot.needle = found.second;
  contact.foot.on_needle = curve_point(second.model, second.shape, found.t);
  const Vector3 apart = contact.on_needle.position - contact.foot.on_needle.position;
  Normal hold{.n = found.normal,
              .gap = found.normal.dot(apart) - (first.model.diameter + second.model.diameter) / 2,
              .compliance = kGive};
  const Vector3 before = first.start_position(found.s) - second.start_position(found.t);
  if (friction > 0) hold.friction = {.slip = apart - before, .friction = friction};
  contact.hold = hold;
  return contact;
}

}  // namespace acus
