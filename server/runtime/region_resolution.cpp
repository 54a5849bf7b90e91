// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/runtime/region_resolution.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "server/engine/scene/text/text_table.h"

namespace acus {
namespace {

constexpr double kVolumeError = 0.3;  // of a shape's volume, from which its mesh is another thing
constexpr double kCellsAcross = 3;    // of a shape, that resolve it
constexpr int kLooks = 40;            // at places along each edge of a box around a shape

// Of a volume with an end, in the mesh frame.
struct Extent {
  Vector3 min = Vector3::Constant(-kInfinity), max = Vector3::Constant(kInfinity);  // m
  double thickness = kInfinity;                                                     // m, the least one
};

void narrow(Extent& extent, const Vector3& min, const Vector3& max, double thickness) {
  extent.min = extent.min.cwiseMax(min);
  extent.max = extent.max.cwiseMin(max);
  extent.thickness = std::min(extent.thickness, thickness);
}

Extent extent_of(const Volume& volume) {
  Extent extent;
  if (volume.box) narrow(extent, volume.box->min, volume.box->max, (volume.box->max - volume.box->min).minCoeff());
  if (volume.sphere) {
    const Vector3 reach = Vector3::Constant(volume.sphere->radius);
    narrow(extent, volume.sphere->center - reach, volume.sphere->center + reach, 2 * volume.sphere->radius);
  }
  if (volume.cylinder) {
    const auto& [from, to, radius] = *volume.cylinder;
    const Vector3 reach = Vector3::Constant(radius);
    narrow(extent, from.cwiseMin(to) - reach, from.cwiseMax(to) + reach, std::min(2 * radius, (to - from).norm()));
  }
  return extent;
}

// The closed form of a single shape (m^3).
std::optional<double> whole_volume(const Volume& volume) {
  const int shapes =
      volume.box.has_value() + volume.sphere.has_value() + volume.cylinder.has_value() + volume.half_space.has_value();
  if (shapes != 1 || volume.half_space) return std::nullopt;
  if (volume.sphere) return 4.0 / 3 * std::numbers::pi * std::pow(volume.sphere->radius, 3);
  if (volume.box) return (volume.box->max - volume.box->min).prod();
  const auto& [from, to, radius] = *volume.cylinder;
  return std::numbers::pi * radius * radius * (to - from).norm();
}

// The part of a volume in the box of the mesh (m^3), by points in its own box.
double volume_within(const Volume& volume, const Extent& extent, const Vector3& half_size) {
  const Vector3 low = extent.min.cwiseMax(-half_size), size = extent.max.cwiseMin(half_size) - low;
  if (size.minCoeff() <= 0) return 0;
  int inside = 0;
  for (int i = 0; i < kLooks; ++i)
    for (int j = 0; j < kLooks; ++j)
      for (int k = 0; k < kLooks; ++k)
        inside += volume.contains(low + size.cwiseProduct((Vector3(i, j, k).array() + 0.5).matrix() / kLooks));
  return size.prod() * inside / (kLooks * kLooks * kLooks);
}

// ---- The mesh's part ----

struct Selected {
  std::vector<int> tetrahedra;
  double volume = 0;  // m^3
  int pieces = 0;     // that share no face

  // The edge of a cube of six tetrahedra (m).
  double cell() const { return std::cbrt(6 * volume / static_cast<double>(tetrahedra.size())); }
};

int count_pieces(const TetrahedralMesh& mesh, const std::vector<int>& tetrahedra) {
  std::vector<bool> left(mesh.tetrahedra.size());
  for (const int t : tetrahedra) left[t] = true;
  int pieces = 0;
  std::vector<int> reached;
  const auto reach = [&](int t) {
    if (t < 0 || !left[t]) return;
    left[t] = false;
    reached.push_back(t);
  };
  for (const int t : tetrahedra) {
    pieces += left[t];
    for (reach(t); !reached.empty();) {
      const int at = reached.back();
      reached.pop_back();
      for (const int neighbour : mesh.neighbours[at]) reach(neighbour);
    }
  }
  return pieces;
}

// What a volume selects, whatever regions further down the list then take of it.
Selected selected_by(const Volume& volume, const Simulation& simulation) {
  const TetrahedralMesh& mesh = simulation.mesh();
  const Pose& pose = simulation.scene().tissue.pose;
  Selected selected;
  for (int t = 0; t < mesh.tetrahedron_count(); ++t) {
    Vector3 centroid = Vector3::Zero();
    for (const int node : mesh.tetrahedra[t]) centroid += mesh.nodes.col(node) / 4;
    if (!volume.contains(pose.orientation.inverse() * (centroid - pose.position))) continue;
    selected.tetrahedra.push_back(t);
    selected.volume += rest_volume(mesh, t);
  }
  selected.pieces = count_pieces(mesh, selected.tetrahedra);
  return selected;
}

std::string cubic_centimetres(double volume) { return five_digits(std::round(1e8 * volume) / 100); }

std::string told(const Selected& selected, double shape) {
  std::string text = "the mesh makes it of " + std::to_string(selected.tetrahedra.size()) + " tetrahedra";
  if (selected.pieces > 1) text += " in " + std::to_string(selected.pieces) + " pieces that share no face";
  if (shape > 0)
    text += ", " + cubic_centimetres(selected.volume) + " of " + cubic_centimetres(shape) + " cm^3 of its shape";
  return text;
}

void warn_of(const Region& region, const Simulation& simulation, SceneWarnings& found) {
  const Extent extent = extent_of(region);
  const Selected selected = selected_by(region, simulation);
  const Scene& scene = simulation.scene();
  const bool box_mesh = !scene.tissue.gmsh;
  const Vector3& size = scene.tissue.box.size;
  const double within = box_mesh ? volume_within(region, extent, size / 2) : 0;
  const double layer = within * size.minCoeff() / size.prod();  // the thickness of one as wide as the mesh
  const double thickness = std::isfinite(extent.thickness) ? extent.thickness : layer;
  if (!(thickness > 0) || selected.tetrahedra.empty()) return;
  const double cell = selected.cell(), needed = std::min(thickness / kCellsAcross, cell / 2);
  const double whole = whole_volume(region).value_or(within);
  const bool in_pieces =
      selected.pieces > 1 && (box_mesh || cell > thickness / kCellsAcross);  // an organ's mesh may have two lobes
  const bool off = within > 0 && std::abs(selected.volume / within - 1) > kVolumeError;
  if (!in_pieces && !off) return;
  const double shape = within > 0.7 * whole ? whole : within;
  found.push_back({region.name, told(selected, shape) + "; cells of " + five_digits(1e3 * needed) +
                                    " mm resolve it, where they are " + five_digits(1e3 * cell) +
                                    " mm: " + (box_mesh ? "raise tissue.mesh.box.cells" : "take a finer mesh") +
                                    ", or make it thicker"});
}

}  // namespace

void warn_of_unresolved_regions(const Simulation& simulation, SceneWarnings& found) {
  for (const Region& region : simulation.scene().tissue.regions)
    if (!region.physical_group && !region.unbounded()) warn_of(region, simulation, found);
}

}  // namespace acus
