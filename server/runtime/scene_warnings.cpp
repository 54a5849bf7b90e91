// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/runtime/scene_warnings.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "server/engine/models/geometry/surface.h"
#include "server/engine/models/needle/needle.h"
#include "server/engine/models/unresolved/dimple.h"
#include "server/engine/scene/scene_fields.h"
#include "server/engine/scene/text/text_table.h"
#include "server/runtime/mesh_summary.h"
#include "server/runtime/region_resolution.h"
#include "server/runtime/unusual_values.h"

namespace acus {
namespace {

// A contact acts on 21 points (contact_patch.h). Where they are further apart than nodes, each is a point force, and
// turns elements of size a inside out from about E a² on.
constexpr double kBearable = 10;  // -, of E a²
// A dimple that is wider than this share of the tissue's least extent presses all of it.
constexpr double kWidest = 1.0 / 3;
// Organs are larger, and patients smaller.
constexpr double kLeastTissue = 2e-3, kLargestTissue = 2;  // m
// The softest needles, of silicone, have some 1e6; metals 1e11.
constexpr double kSoftestNeedle = 1e6;  // Pa

// A tip farther from the tissue than this, and than its needle is long, goes a long way through air.
constexpr double kFarTip = 0.1;  // m
// A base farther from the tissue than this, and than so many times what the scene has, was meant elsewhere.
constexpr double kFarBase = 1, kFarTimes = 5;  // m, -
// A needle that begins farther off the axis of its guide is bent by it at once.
constexpr double kOffAxis = 5e-3;  // m

using Warnings = SceneWarnings;

std::string millimetres(double metres) { return five_digits(1e3 * metres) + " mm"; }

Vector3 extents(const TetrahedralMesh& mesh) {
  return mesh.nodes.rowwise().maxCoeff() - mesh.nodes.rowwise().minCoeff();
}

// ---- Tissue ----

void warn_of_size(const Scene& scene, const TetrahedralMesh& mesh, Warnings& found) {
  const double largest = extents(mesh).maxCoeff(), least = extents(mesh).minCoeff();
  const std::string field = scene.tissue.gmsh ? "tissue.mesh.gmsh.metres_per_unit: 0.001 reads millimetres"
                                              : "lengths are in metres: tissue.mesh.box.size: [0.1, 0.1, 0.1]";
  if (largest > kLargestTissue) found.push_back({"tissue", "it is " + five_digits(largest) + " m wide; " + field});
  if (least < kLeastTissue)
    found.push_back({"tissue", "it is " + millimetres(least) + " thin; lengths are in metres" +
                                   (scene.tissue.gmsh ? ": tissue.mesh.gmsh.metres_per_unit is too small?" : "")});
}

bool has_fixed_nodes(const Simulation& simulation) {
  return simulation.costs().free_nodes < simulation.mesh().node_count();
}

// The field that fixes the lower face.
std::string fixed_below(const Scene& scene, const TetrahedralMesh& mesh) {
  const Eigen::Matrix3d to_mesh = scene.tissue.pose.orientation.toRotationMatrix().transpose();
  const double bottom = (to_mesh * (mesh.nodes.colwise() - scene.tissue.pose.position)).row(2).minCoeff();
  return "tissue.fixed: [{box: {max: [.inf, .inf, " + five_digits(bottom) + "]}}]";
}

void warn_of_nothing_fixed(const Simulation& simulation, Warnings& found) {
  const Scene& scene = simulation.scene();
  if (has_fixed_nodes(simulation)) return;
  std::string what = "under a needle";
  if (!simulation.model().tissue.applied.isZero(0))
    what = scene.gravity.isZero(0) ? "under pressures" : "under gravity";
  found.push_back({"tissue", "no node is fixed, so that it goes away " + what + "; " +
                                 fixed_below(scene, simulation.mesh()) + " holds its lower face"});
}

// Gravity along +z in tissue that rests on what is below it.
void warn_of_rising(const Simulation& simulation, Warnings& found) {
  const Vector3& gravity = simulation.scene().gravity;
  if (gravity.z() <= 0.5 * gravity.norm()) return;
  const Matrix3X& nodes = simulation.mesh().nodes;
  const std::vector<int>& fixed = simulation.model().tissue.fixed_nodes;
  double height = 0;
  for (const int node : fixed) height += nodes(2, node) / static_cast<double>(fixed.size());
  if (!fixed.empty() && height >= nodes.row(2).mean()) return;
  found.push_back({"scene", "gravity points up, along +z, away from what holds the tissue; down is [0, 0, -9.81]"});
}

// Per region, the edge of a cube of six tetrahedra of its mean volume (m).
std::vector<double> mean_element_sizes(const Simulation& simulation) {
  const std::size_t regions = simulation.scene().tissue.regions.size();
  std::vector<double> volume(regions), count(regions);
  for (int t = 0; t < simulation.mesh().tetrahedron_count(); ++t) {
    const int region = simulation.regions()[static_cast<std::size_t>(t)];
    volume[region] += rest_volume(simulation.mesh(), t);
    ++count[region];
  }
  std::vector<double> sizes;
  for (std::size_t i = 0; i < regions; ++i) sizes.push_back(std::cbrt(6 * volume[i] / count[i]));
  return sizes;
}

double largest_diameter(const Scene& scene) {
  double diameter = 0;
  for (const Needle& needle : scene.needles) diameter = std::max(diameter, needle.outer_diameter);
  return diameter;
}

// Regions whose elements a tip crushes before it has punctured them.
void warn_of_crushing(const Simulation& simulation, Warnings& found) {
  const std::vector<Region>& regions = simulation.scene().tissue.regions;
  const std::vector<double> sizes = mean_element_sizes(simulation);
  const double extent = extents(simulation.mesh()).minCoeff(), diameter = largest_diameter(simulation.scene());
  for (std::size_t i = 0; i < regions.size(); ++i) {
    const Material& material = regions[i].material;
    const double f = regions[i].interaction.puncture_force, E = material.young_modulus;
    if (!std::isfinite(f)) continue;
    const double bearable = kBearable * E * sizes[i] * sizes[i];
    if (f > bearable)
      found.push_back(
          {regions[i].name, "f_p of " + five_digits(f) + " N is above 10 E a^2 = " + five_digits(bearable) +
                                " N for elements of a = " + millimetres(sizes[i]) +
                                ": the tip may press them flat and puncture earlier; take elements of at least " +
                                millimetres(std::sqrt(f / (kBearable * E))) + ", or a smaller f_p"});
    const double width = 2 * dimple_radius(Indented(material, regions[i].interaction.deep_indentation), diameter, f);
    if (width > kWidest * extent)
      found.push_back(
          {regions[i].name, "f_p of " + five_digits(f) + " N presses a dimple of " + millimetres(width) +
                                " across into tissue that is " + millimetres(extent) +
                                " thick: it may be pressed flat before it is punctured; take a smaller f_p or stiffer "
                                "tissue"});
  }
}

// ---- Needles ----

void warn_of_softness(const Needle& needle, Warnings& found) {
  if (needle.rung == NeedleRung::rigid || needle.material.young_modulus >= kSoftestNeedle) return;
  found.push_back({needle.name, "its material has E = " + five_digits(needle.material.young_modulus) +
                                    " Pa, softer than rubber; material.young_modulus is in Pa: 200e9 for steel"});
}

void warn_of_standing_inside(const Simulation& simulation, int needle, Warnings& found) {
  const Eigen::Ref<const Matrix3X> nodes = simulation.needle_positions(needle);
  const TetrahedralMesh& mesh = simulation.mesh();
  for (Eigen::Index i = 0; i < nodes.cols(); ++i) {
    if (find_tetrahedron(mesh, simulation.state().tissue.x, nodes.col(i)) < 0) continue;
    const Needle& parameters = simulation.scene().needles[static_cast<std::size_t>(needle)];
    const double along = parameters.length * static_cast<double>(i) / static_cast<double>(nodes.cols() - 1);
    found.push_back(
        {parameters.name, std::string(i == 0 ? "its base" : "its shaft, " + millimetres(along) + " from the base,") +
                              " stands inside the tissue, which does not hold it there; move base.position back"});
    return;
  }
}

struct Entry {
  double way = 0;                // m, along the ray
  std::array<int, 3> corners{};  // nodes
};

// Where a ray from p along a unit vector first meets the surface, its nodes at x (m); nothing if it misses.
std::optional<Entry> entry_of(const TetrahedralMesh& mesh, const Matrix3X& x, const Vector3& p, const Vector3& along) {
  std::optional<Entry> nearest;
  for (const auto& triangle : mesh.surface) {
    const Vector3 a = x.col(triangle[0]), u = x.col(triangle[1]) - a, v = x.col(triangle[2]) - a;
    Eigen::Matrix3d system;
    system << -along, u, v;
    const double determinant = system.determinant();
    if (std::abs(determinant) < 1e-12 * u.norm() * v.norm()) continue;
    const Vector3 solution = system.inverse() * (p - a);  // way, and weights of u and v
    const bool within = solution.y() >= 0 && solution.z() >= 0 && solution.y() + solution.z() <= 1 && solution.x() >= 0;
    if (within && (!nearest || solution.x() < nearest->way))
      nearest = {solution.x(), {triangle[0], triangle[1], triangle[2]}};
  }
  return nearest;
}

// How far p is from the box around the tissue (m).
double distance_from(const TetrahedralMesh& mesh, const Vector3& p) {
  const Vector3 min = mesh.nodes.rowwise().minCoeff(), max = mesh.nodes.rowwise().maxCoeff();
  return (p - p.cwiseMax(min).cwiseMin(max)).norm();
}

bool stands_far_away(const Simulation& simulation, const Needle& needle) {
  const double distance = distance_from(simulation.mesh(), needle.base.position);
  return distance > kFarBase && distance > kFarTimes * (needle.length + extents(simulation.mesh()).norm());
}

void warn_of_distance(const Simulation& simulation, const Needle& needle, Warnings& found) {
  const double distance = distance_from(simulation.mesh(), needle.base.position);
  if (stands_far_away(simulation, needle)) {
    found.push_back({needle.name, "its base is " + five_digits(distance) +
                                      " m from the tissue; base.position is in metres: [0, 0, 0.21] for 210 mm"});
    return;
  }
  const auto entry = entry_of(simulation.mesh(), simulation.state().tissue.x, needle.base.position,
                              needle.base.orientation * Vector3::UnitX());
  if (needle.curvature != 0 || !entry) return;
  const double gap = entry->way - needle.length;
  if (gap > kFarTip && gap > needle.length)
    found.push_back({needle.name, "its tip is " + millimetres(gap) +
                                      " from the tissue, farther than the needle is long; " +
                                      "move base.position nearer, or mind length, in metres"});
  const std::vector<int>& free = simulation.model().tissue.free_index;
  const auto is_fixed = [&](int node) { return free[static_cast<std::size_t>(node)] < 0; };
  if (std::all_of(entry->corners.begin(), entry->corners.end(), is_fixed))
    found.push_back(
        {needle.name, "it enters through nodes that are fixed, which do not give way; let tissue.fixed end elsewhere"});
}

// One whose axis leads past the tissue, and what would lead into it. A curved needle's path is no line.
void warn_of_missing(const Simulation& simulation, int index, Warnings& found) {
  const Needle& needle = simulation.scene().needles[static_cast<std::size_t>(index)];
  const Vector3 base = needle.base.position;
  const auto hits = [&](const Quaternion& q) {
    return entry_of(simulation.mesh(), simulation.state().tissue.x, base, q * Vector3::UnitX()).has_value();
  };
  if (needle.curvature != 0 || stands_far_away(simulation, needle) || hits(needle.base.orientation)) return;
  const Quaternion& q = needle.base.orientation;
  const Quaternion reordered(q.z(), q.w(), q.x(), q.y());  // what stands there read as x, y, z, w
  const Quaternion reversed = q * Quaternion(0, 0, 0, 1);
  const bool away = hits(reversed);
  std::string text = away ? "it points away from the tissue" : "its axis leads past the tissue";
  if (hits(reordered) && (!away || std::abs(q.w()) < 1e-6))  // w = 0 is a half turn: more probably it is their x
    text += "; base.orientation is [w, x, y, z], and in the order x, y, z, w it would meet it: [" +
            five_digits(reordered.w()) + ", " + five_digits(reordered.x()) + ", " + five_digits(reordered.y()) + ", " +
            five_digits(reordered.z()) + "]?";
  else
    text +=
        "; base.orientation [w, x, y, z] turns +x to where the needle points: [0.7071, 0, 0.7071, 0] is down, along -z";
  found.push_back({needle.name, text});
}

void warn_of_buckling(const Simulation& simulation, int index, Warnings& found) {
  const Scene& scene = simulation.scene();
  const Needle& needle = scene.needles[static_cast<std::size_t>(index)];
  if (!needle.point_side) return;
  for (const Region& region : scene.tissue.regions) {
    const double thrust =
        steered_path(needle, simulation.model().needles[static_cast<std::size_t>(index)], region).thrust;
    if (thrust <= kBucklingThrust) continue;
    found.push_back({needle.name, "the cutting force of " + region.name + " is " + five_digits(thrust) +
                                      " times (k EI)^(1/2), and from " + five_digits(kBucklingThrust) +
                                      " on a bevel buckles in its path, not arcs; take a smaller cutting_force or a "
                                      "stiffer needle"});
  }
}

// ---- Guides ----

void warn_of_guides_inside(const Simulation& simulation, Warnings& found) {
  const TetrahedralMesh& mesh = simulation.mesh();
  for (const Guide& guide : simulation.scene().guides)
    if (find_tetrahedron(mesh, simulation.state().tissue.x, guide.pose.position) >= 0)
      found.push_back({guide.name,
                       "it stands inside the tissue, and holds the needle there from outside; move "
                       "pose.position out of it"});
}

double distance_from_axis(const Needle& needle, const Vector3& p) {
  const Vector3 axis = needle.base.orientation * Vector3::UnitX(), way = p - needle.base.position;
  return (way - way.dot(axis) * axis).norm();
}

void warn_of_guides_aside(const Scene& scene, Warnings& found) {
  for (const Guide& guide : scene.guides)
    for (const Needle& needle : scene.needles) {
      const double off = distance_from_axis(needle, guide.pose.position);
      if (needle.name != guide.needle || needle.curvature != 0 ||
          off <= guide.play + std::max(kOffAxis, 2 * needle.outer_diameter))
        continue;
      found.push_back({guide.name, "it is " + millimetres(off) + " off the axis of " + needle.name +
                                       ", which it bends from the start; move pose.position onto the axis"});
    }
}

}  // namespace

SceneWarnings scene_warnings(const Simulation& simulation) {
  const Scene& scene = simulation.scene();
  Warnings found;
  warn_of_unusual_values(scene, found);
  for (const Needle& needle : scene.needles) warn_of_softness(needle, found);
  if (scene.tissue.left_out() || simulation.mesh().node_count() == 0) return found;
  warn_of_size(scene, simulation.mesh(), found);
  warn_of_unnamed_groups(simulation, found);
  warn_of_nothing_fixed(simulation, found);
  warn_of_rising(simulation, found);
  for (int needle = 0; needle < static_cast<int>(scene.needles.size()); ++needle) {
    warn_of_standing_inside(simulation, needle, found);
    warn_of_distance(simulation, scene.needles[static_cast<std::size_t>(needle)], found);
    warn_of_missing(simulation, needle, found);
    warn_of_buckling(simulation, needle, found);
  }
  warn_of_guides_inside(simulation, found);
  warn_of_guides_aside(scene, found);
  warn_of_unresolved_regions(simulation, found);
  warn_of_crushing(simulation, found);
  return found;
}

}  // namespace acus
