// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/state/clearance.h"

#include <cmath>
#include <vector>

#include "server/engine/models/geometry/surface.h"
#include "server/engine/models/needle/needle_distance.h"
#include "server/engine/scene/text/field.h"
#include "server/engine/state/capacities.h"

namespace acus {

namespace {

double rounded_mm(double metres) { return std::round(1e6 * metres) / 1e3; }

}  // namespace

bool tip_is_inside(const TetrahedralMesh& mesh, const Matrix3X& x, const NeedleModel& needle, const Pose& base) {
  const Vector3 tip = make_needle_state(needle, base).x.rightCols<1>();
  return mesh.tetrahedron_count() > 0 && find_tetrahedron(mesh, x, tip) >= 0;
}

std::optional<Overlap> find_overlap(const Scene& scene, std::span<const NeedleModel> models,
                                    std::span<const NeedleState> needles) {
  if (!scene.needle_contact.enabled) return std::nullopt;
  std::vector<NeedleShape> shapes(needles.size());
  std::vector<NeedleCells> cells;
  for (std::size_t i = 0; i < needles.size(); ++i) {
    put_shape(needles[i], shapes[i]);
    put_cells(models[i], shapes[i], cells.emplace_back(needle_cells(scene.needles[i])));
  }
  const auto shaped = [&](std::size_t i) { return ShapedNeedle{models[i], shapes[i], cells[i]}; };
  for (std::size_t j = 1; j < needles.size(); ++j)
    for (std::size_t i = 0; i < j; ++i) {
      Overlap deepest{static_cast<int>(i), static_cast<int>(j)};
      for (int cell = 0; cell < cells[i].count(); ++cell) {
        const auto points = nearest_points(shaped(i), cell, cell, shaped(j), 0);
        if (!points) continue;
        const double depth = cells[i].radius + cells[j].radius - points->apart.norm();
        if (depth > deepest.depth) deepest.depth = depth, deepest.at = points->t;
      }
      if (deepest.depth > 0) return deepest;
    }
  return std::nullopt;
}

std::string sentence(const Scene& scene, const Overlap& overlap) {
  const auto name = [&](int needle) { return '"' + scene.needles[static_cast<std::size_t>(needle)].name + '"'; };
  return "expected needle " + name(overlap.second) + " beside needle " + name(overlap.first) + ", found it " +
         format_number(rounded_mm(overlap.depth)) + " mm inside it at " + format_number(rounded_mm(overlap.at)) +
         " mm from its base";
}

}  // namespace acus
