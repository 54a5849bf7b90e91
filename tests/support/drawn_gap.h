// SPDX-License-Identifier: GPL-3.0-or-later
// The invariant that every lay person takes for granted of a picture: a tip that presses on the skin is on the drawn
// skin, and one that cuts or presses on a border is at the end of the drawn path; a shaft that the skin bears lies on it.
#pragma once

#include <algorithm>

#include "server/engine/models/geometry/surface.h"
#include "server/engine/tick/drawn_tissue.h"
#include "server/engine/tick/simulation.h"

namespace acus::test {

// m, that are not seen.
inline constexpr double kMostDrawnGap = 2e-4;

class DrawnGap {
 public:
  explicit DrawnGap(const Simulation& simulation) : simulation_(simulation), drawn_(simulation.model()) {}

  // Largest distance (m) of a tip in contact from the drawn skin near it, and of one that cuts from its path's end,
  // or presses on a border, after a tick; infinite if anything that is drawn is not finite.
  double largest(const Surface& surface) {
    const State& state = simulation_.state();
    draw_tissue(simulation_.model(), state, drawn_);
    double gap = 0;
    for (std::size_t i = 0; i < state.insertions.size(); ++i) {
      const Insertion& insertion = state.insertions[i];
      const Vector3 tip = simulation_.report().needles[i].tip_position;
      if (touches(insertion)) gap = std::max(gap, from_skin(surface, tip));
      const bool on_border = insertion.border >= 0 && insertion.tip.contact.along > 0;
      if (insertion.phase == Phase::inside && (insertion.tip.cut.along > 0 || on_border))
        gap = std::max(gap, from_end(insertion.path, tip));
      for (const ShaftCell& cell : insertion.cells)
        if (cell.contact.along > 0) gap = std::max(gap, from_skin(surface, place_on(state.needles[i], i, cell.s)));
    }
    return finite() ? gap : kInfinity;
  }

 private:
  bool finite() const {
    const bool dents = std::ranges::all_of(
        drawn_.dents, [](const Dent& dent) { return dent.centre.allFinite() && dent.move.allFinite(); });
    return dents && drawn_.path_points.leftCols(drawn_.points).allFinite();
  }

  Vector3 place_on(const NeedleState& needle, std::size_t index, double s) const {
    NeedleShape shape;
    put_shape(needle, shape);
    return curve_point(simulation_.model().needles[index], shape, s).position;
  }

  // From the mesh's point that is drawn nearest to the tip: from the closest one and from where dents are.
  double from_skin(const Surface& surface, const Vector3& tip) const {
    double nearest = from_skin(surface, tip, tip);
    for (const Dent& dent : drawn_.dents) nearest = std::min(nearest, from_skin(surface, tip, dent.centre));
    return nearest;
  }

  // By fixed-point iterations.
  double from_skin(const Surface& surface, const Vector3& tip, Vector3 place) const {
    constexpr int kIterations = 20;
    const Matrix3X& x = simulation_.state().tissue.x;
    double nearest = kInfinity;
    for (int i = 0; i < kIterations; ++i) {
      place = surface.closest(x, place).position;
      const Vector3 apart = tip - place - displacement(drawn_.dents, place);
      nearest = std::min(nearest, apart.norm());
      place += apart / 2;
    }
    return nearest;
  }

  double from_end(int path, const Vector3& tip) const {
    int last = -1;
    for (std::size_t i = 0, count = 0; i < simulation_.state().paths.size(); ++i) {
      if (simulation_.state().paths[i].empty()) continue;
      last += drawn_.path_sizes[count++];
      if (static_cast<int>(i) == path) break;
    }
    return (drawn_.path_points.col(last) - tip).norm();
  }

  const Simulation& simulation_;
  DrawnTissue drawn_;
};

}  // namespace acus::test
