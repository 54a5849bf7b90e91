// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/state/capacities.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace acus {

double least_spacing(std::span<const Needle> needles) {
  double least = kInfinity;
  for (const Needle& needle : needles) least = std::min(least, needle.constraint_spacing);
  return least;
}

namespace {

constexpr int kMoreVertices = 4;  // at the ends of the shaft

int vertices_along(const Needle& parameters, double spacing) {
  assert(spacing > 0 && spacing < kInfinity);
  return static_cast<int>(std::ceil(parameters.length / spacing));
}

int rows_of_vertex(const Needle& parameters, bool borders) {
  return 3 + (parameters.torsional_friction > 0 ? 1 : 0) + (borders ? 1 : 0);  // two across, friction; torsion; support
}

constexpr int kRowsOfTip = 5;  // cutting, border, two across, support
constexpr int kRowsOfHub = 3;

bool has_hub(const Needle& parameters) { return parameters.hub_diameter > 0; }

}  // namespace

int max_shaft_points(const Needle& parameters, double spacing) {
  return 2 * vertices_along(parameters, spacing) + kMoreVertices;
}

int shaft_cells(const Needle& parameters) {
  constexpr double kLeastCell = 8e-3;  // m
  const double cell = std::max(kLeastCell, 1.5 * parameters.constraint_spacing);
  return std::max(1, static_cast<int>(parameters.length / cell));
}

int needle_cells(const Needle& parameters) {
  constexpr double kLeastCell = 8e-3;  // m
  return std::clamp(static_cast<int>(parameters.length / kLeastCell), 1, 8);
}

int max_needle_contacts(const Scene& scene) {
  constexpr int kMost = 64;
  if (!scene.needle_contact.enabled) return 0;
  int contacts = 0;
  for (std::size_t later = 1; later < scene.needles.size(); ++later)
    for (std::size_t i = 0; i < later; ++i) contacts += needle_cells(scene.needles[i]);
  return std::min(contacts, kMost);
}

int max_material_points(const Needle& parameters, double spacing) {
  return max_shaft_points(parameters, spacing) + 3 + kPatchPoints * (has_hub(parameters) ? 2 : 1);
}

int max_touched_nodes(const Scene& scene, double shortest_edge) {
  constexpr int kOfEdge = 24;
  const double spacing = least_spacing(scene.needles);
  double nodes = 0;
  for (const Needle& needle : scene.needles) {
    const double of_points = 4.0 * max_material_points(needle, spacing);
    const double edges = needle.length / shortest_edge + 2;  // and those around both ends
    nodes += std::min(of_points, std::ceil(kOfEdge * edges) + (has_hub(needle) ? 4.0 * kPatchPoints : 0));
  }
  return static_cast<int>(nodes);
}

int max_held_nodes(const Scene& scene) {
  constexpr int kOfNeedle = 100;
  return max_touched_nodes(scene) + kOfNeedle * static_cast<int>(scene.needles.size());
}

int max_insertion_rows(const Needle& parameters, double spacing, bool borders) {
  return rows_of_vertex(parameters, borders) * max_shaft_points(parameters, spacing) + kRowsOfTip +
         (has_hub(parameters) ? kRowsOfHub : 0);
}

int max_insertion_rows(const Scene& scene) {
  const double spacing = least_spacing(scene.needles);
  const bool borders = scene.tissue.regions.size() > 1;
  int rows = 0, squeezed = 0;
  for (const Needle& needle : scene.needles) {
    const int more = rows_of_vertex(needle, borders) * vertices_along(needle, spacing);
    rows += max_insertion_rows(needle, spacing, borders) - more;
    squeezed = std::max(squeezed, more);
  }
  return rows + squeezed / 2;
}

}  // namespace acus
