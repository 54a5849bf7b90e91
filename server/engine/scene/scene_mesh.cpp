// SPDX-License-Identifier: GPL-3.0-or-later
// From a scene's description of its tissue to tetrahedra, their regions and their fixed nodes.
#include <algorithm>

#include "server/engine/scene/field_error.h"
#include "server/engine/scene/files/mesh_file.h"
#include "server/engine/scene/text/field.h"
#include "server/engine/scene/text/text_table.h"

namespace acus {
namespace {

// A scene that is turned in the world must select the same nodes; volumes reach this fraction of the mesh's diagonal
// further, which is far above rounding and far below an edge.
constexpr double kSelectionTolerance = 1e-9;

Matrix3X in_mesh_frame(const Scene& scene, const Matrix3X& p_world) {
  const Pose& pose = scene.tissue.pose;
  return pose.orientation.toRotationMatrix().transpose() * (p_world.colwise() - pose.position);
}

double selection_margin(const Matrix3X& nodes) {
  return kSelectionTolerance * (nodes.rowwise().maxCoeff() - nodes.rowwise().minCoeff()).norm();
}

Matrix3X centroids(const TetrahedralMesh& mesh) {
  Matrix3X result(3, mesh.tetrahedron_count());
  for (int t = 0; t < mesh.tetrahedron_count(); ++t) {
    const std::array<int, 4>& c = mesh.tetrahedra[t];
    result.col(t) = (mesh.nodes.col(c[0]) + mesh.nodes.col(c[1]) + mesh.nodes.col(c[2]) + mesh.nodes.col(c[3])) / 4;
  }
  return result;
}

// As many as the cells that a box may have: the factor of more would fill the memory.
constexpr int kMaxTetrahedra = 600'000;

void check_size_and_place(const TetrahedralMesh& mesh) {
  if (mesh.tetrahedron_count() > kMaxTetrahedra) {
    throw MeshError("expected at most " + std::to_string(kMaxTetrahedra) + " tetrahedra, found " +
                    std::to_string(mesh.tetrahedron_count()) + "; make them larger");
  }
  for (int i = 0; i < mesh.node_count(); ++i) {
    const Vector3 at = mesh.nodes.col(i);
    if (at.cwiseAbs().maxCoeff() <= kMaxPosition) continue;
    const std::string bound = format_number(kMaxPosition);
    throw MeshError("expected nodes in [-" + bound + ", " + bound + "] m along each axis of the world, found one at [" +
                    format_number(at.x()) + ", " + format_number(at.y()) + ", " + format_number(at.z()) +
                    "] m; mind the pose and metres_per_unit");
  }
}

std::string list(const std::vector<const MeshGroup*>& groups) {
  constexpr std::size_t kShown = 30;
  std::string text;
  for (std::size_t i = 0; i < std::min(groups.size(), kShown); ++i) text += (i > 0 ? ", " : "") + groups[i]->label();
  if (groups.size() > kShown) text += ", and " + std::to_string(groups.size() - kShown) + " more";
  return text.empty() ? "none" : text;
}

std::vector<const MeshGroup*> find_groups(const TetrahedralMesh& mesh, const std::string& text) {
  std::vector<const MeshGroup*> found;
  for (const MeshGroup& group : mesh.groups)
    if (group.answers_to(text)) found.push_back(&group);
  return found;
}

std::vector<const MeshGroup*> all_groups(const TetrahedralMesh& mesh) {
  std::vector<const MeshGroup*> all;
  for (const MeshGroup& group : mesh.groups) all.push_back(&group);
  return all;
}

// Which tetrahedra one region selects.
class Selector {
 public:
  Selector(const Scene& scene, const TetrahedralMesh& mesh, std::size_t region)
      : region_(scene.tissue.regions[region]), margin_(selection_margin(mesh.nodes)) {
    if (!region_.physical_group) return;
    const std::string path = child_path(child_path("tissue.regions", region), "physical_group");
    const std::vector<const MeshGroup*> found = find_groups(mesh, *region_.physical_group);
    if (found.empty())
      throw scene_error(scene, path,
                        "expected a group of the mesh file (" + list(all_groups(mesh)) + "), found \"" +
                            *region_.physical_group + "\"");
    if (found.size() > 1)
      throw scene_error(scene, path, "expected one of the groups " + list(found) + " by its full name, found \"" +
                                         *region_.physical_group + "\", which fits all of them");
    in_group_.assign(mesh.tetrahedra.size(), false);
    for (const int t : found[0]->members) in_group_[static_cast<std::size_t>(t)] = true;
  }

  bool selects(int t, const Vector3& centroid) const {
    return (in_group_.empty() || in_group_[static_cast<std::size_t>(t)]) && region_.contains(centroid, margin_);
  }

 private:
  const Region& region_;
  double margin_;                // m
  std::vector<bool> in_group_;  // empty where the region names no group
};

// Gives the tetrahedra that a region selects to it; returns how many.
int take(std::vector<int>& regions, const Selector& selector, const Matrix3X& places, std::size_t region) {
  int count = 0;
  for (int t = 0; t < static_cast<int>(regions.size()); ++t) {
    if (!selector.selects(t, places.col(t))) continue;
    regions[t] = static_cast<int>(region);
    ++count;
  }
  return count;
}

void check_every_tetrahedron_has_one(const Scene& scene, const std::vector<int>& regions, const Matrix3X& places) {
  const auto without = std::find(regions.begin(), regions.end(), -1);
  if (without == regions.end()) return;
  const Vector3 at = places.col(without - regions.begin());
  throw scene_error(scene, "tissue.regions",
                    std::to_string(std::count(regions.begin(), regions.end(), -1)) +
                        " tetrahedra belong to no region, one of them at [" + std::to_string(at.x()) + ", " +
                        std::to_string(at.y()) + ", " + std::to_string(at.z()) +
                        "] m in the mesh frame; begin the list with a region that has no selector");
}

void check_every_region_has_some(const Scene& scene, const std::vector<int>& regions) {
  for (std::size_t i = 0; i < scene.tissue.regions.size(); ++i) {
    if (std::find(regions.begin(), regions.end(), static_cast<int>(i)) != regions.end()) continue;
    throw scene_error(scene, child_path("tissue.regions", i),
                      "regions further down the list take every tetrahedron that \"" + scene.tissue.regions[i].name +
                          "\" selects; put larger regions first");
  }
}

int region_index(const Tissue& tissue, const std::string& name) {
  const auto has_name = [&name](const Region& region) { return region.name == name; };
  const auto found = std::find_if(tissue.regions.begin(), tissue.regions.end(), has_name);
  return static_cast<int>(found - tissue.regions.begin());
}

void check_interfaces_have_faces(const Scene& scene, const TetrahedralMesh& mesh, const std::vector<int>& regions) {
  const std::map<std::pair<int, int>, int> faces = count_border_faces(mesh, regions);
  for (std::size_t i = 0; i < scene.tissue.interfaces.size(); ++i) {
    const Interface& interface = scene.tissue.interfaces[i];
    const int a = region_index(scene.tissue, interface.between);
    const int b = region_index(scene.tissue, interface.and_);
    if (faces.contains(std::minmax(a, b))) continue;
    throw scene_error(scene, child_path("tissue.interfaces", i),
                      "expected two regions that share a face of the mesh, found that \"" + interface.between +
                          "\" and \"" + interface.and_ + "\" do not touch; leave the entry out or move the regions");
  }
}

// From where to where points (3 x n, m) of the mesh lie.
std::string told_extent(const Matrix3X& points) {
  const Vector3 min = points.rowwise().minCoeff(), max = points.rowwise().maxCoeff();
  const auto corner = [](const Vector3& p) {
    return "[" + five_digits(p.x()) + ", " + five_digits(p.y()) + ", " + five_digits(p.z()) + "]";
  };
  return ", where the mesh has these from " + corner(min) + " to " + corner(max);
}

// Numbers of the points (3 x n, m, mesh frame) in the volume of a field; throws SceneError where it holds none of
// `what`.
std::vector<int> held_by(const Scene& scene, const std::string& field, const Volume& volume, const Matrix3X& points,
                         double margin, const std::string& what) {
  std::vector<int> held;
  for (int i = 0; i < static_cast<int>(points.cols()); ++i)
    if (volume.contains(points.col(i), margin)) held.push_back(i);
  if (!held.empty()) return held;
  throw scene_error(scene, field,
                    "expected a volume that holds " + what + ", found none inside; it is in the mesh frame, in metres" +
                        told_extent(points));
}

}  // namespace

TetrahedralMesh read_mesh(const Scene& scene, const SceneFolders* allowed) {
  const Tissue& tissue = scene.tissue;
  if (tissue.left_out()) return {};
  try {
    return tissue.gmsh ? read_mesh_file(tissue.gmsh->file, tissue.gmsh->metres_per_unit, allowed)
                       : make_box_mesh(tissue.box.size, tissue.box.cells);
  } catch (const MeshError& error) {
    throw scene_error(scene, "tissue.mesh", error.what());
  }
}

TetrahedralMesh placed(const Scene& scene, TetrahedralMesh mesh) {
  if (scene.tissue.left_out()) return {};
  const Pose& pose = scene.tissue.pose;
  mesh.nodes = ((pose.orientation.toRotationMatrix() * mesh.nodes).colwise() + pose.position).eval();
  try {
    check_size_and_place(mesh);
  } catch (const MeshError& error) {
    throw scene_error(scene, "tissue.mesh", error.what());
  }
  return mesh;
}

TetrahedralMesh load_mesh(const Scene& scene) { return placed(scene, read_mesh(scene)); }

std::vector<int> assign_regions(const Scene& scene, const TetrahedralMesh& mesh) {
  if (scene.tissue.left_out()) return {};
  const Matrix3X places = in_mesh_frame(scene, centroids(mesh));
  std::vector<int> regions(mesh.tetrahedra.size(), -1);
  for (std::size_t i = 0; i < scene.tissue.regions.size(); ++i) {
    if (take(regions, Selector(scene, mesh, i), places, i) > 0) continue;
    throw scene_error(scene, child_path("tissue.regions", i),
                      "expected a region with tetrahedra, found that \"" + scene.tissue.regions[i].name +
                          "\" selects none; volumes are in the mesh frame, in metres" + told_extent(places));
  }
  check_every_tetrahedron_has_one(scene, regions, places);
  check_every_region_has_some(scene, regions);
  check_interfaces_have_faces(scene, mesh, regions);
  return regions;
}

std::map<std::pair<int, int>, int> count_border_faces(const TetrahedralMesh& mesh, std::span<const int> regions) {
  std::map<std::pair<int, int>, int> faces;
  for (int t = 0; t < mesh.tetrahedron_count(); ++t) {
    for (const int neighbour : mesh.neighbours[t]) {
      if (neighbour > t && regions[neighbour] != regions[t]) ++faces[std::minmax(regions[t], regions[neighbour])];
    }
  }
  return faces;
}

Matrix3X pressure_forces(const Scene& scene, const TetrahedralMesh& mesh) {
  Matrix3X forces = Matrix3X::Zero(3, mesh.nodes.cols());
  if (scene.tissue.left_out() || scene.tissue.pressures.empty()) return forces;
  const Matrix3X nodes = in_mesh_frame(scene, mesh.nodes);
  const double margin = selection_margin(nodes);
  Matrix3X centroids(3, mesh.surface.size());
  for (Eigen::Index face = 0; face < centroids.cols(); ++face) {
    const auto& [a, b, c] = mesh.surface[face];
    centroids.col(face) = (nodes.col(a) + nodes.col(b) + nodes.col(c)) / 3;
  }
  for (std::size_t i = 0; i < scene.tissue.pressures.size(); ++i) {
    const Pressure& pressure = scene.tissue.pressures[i];
    for (const int face : held_by(scene, child_path("tissue.pressures", i), pressure, centroids, margin,
                                  "faces of the mesh's surface by their centroids")) {
      const auto& [a, b, c] = mesh.surface[face];
      const Vector3 ab = mesh.nodes.col(b) - mesh.nodes.col(a), ac = mesh.nodes.col(c) - mesh.nodes.col(a);
      const Vector3 share = -pressure.pressure / 6 * ab.cross(ac);
      for (const int node : {a, b, c}) forces.col(node) += share;
    }
  }
  return forces;
}

std::vector<bool> find_fixed_nodes(const Scene& scene, const TetrahedralMesh& mesh) {
  if (scene.tissue.left_out()) return {};
  const Matrix3X nodes = in_mesh_frame(scene, mesh.nodes);
  const double margin = selection_margin(nodes);
  std::vector<bool> fixed(static_cast<std::size_t>(mesh.node_count()), false);
  for (std::size_t i = 0; i < scene.tissue.fixed.size(); ++i) {
    for (const int node :
         held_by(scene, child_path("tissue.fixed", i), scene.tissue.fixed[i], nodes, margin, "nodes of the mesh"))
      fixed[node] = true;
  }
  if (std::find(fixed.begin(), fixed.end(), false) == fixed.end())
    throw scene_error(scene, "tissue.fixed", "expected volumes that leave some node free, found every node fixed");
  return fixed;
}

}  // namespace acus
