// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/export/vtk_export.h"

#include <fmt/format.h>

#include <stdexcept>

#include "server/engine/tick/drawn_tissue.h"

namespace acus {

namespace {

constexpr std::uint8_t kTetrahedron = 10;  // VTK's number

std::span<const double> numbers(const Eigen::Ref<const Matrix3X>& points) {
  return {points.data(), static_cast<std::size_t>(points.size())};
}

// Points and the lines between them, of which `sizes` says how many points each has.
VtkPiece lines(const Matrix3X& points, const std::vector<std::int64_t>& sizes) {
  std::vector<std::int64_t> nodes(static_cast<std::size_t>(points.cols())), ends;
  for (std::size_t i = 0; i < nodes.size(); ++i) nodes[i] = static_cast<std::int64_t>(i);
  std::int64_t end = 0;
  for (const std::int64_t size : sizes) ends.push_back(end += size);
  return {"PolyData",
          fmt::format(R"(NumberOfPoints="{}" NumberOfLines="{}")", points.cols(), sizes.size()),
          {{"Points", {vtk_array("position", numbers(points), 3)}},
           {"Lines", {vtk_array("connectivity", nodes), vtk_array("offsets", ends)}}}};
}

VtkPiece tissue_of(const Simulation& simulation, const DrawnTissue& drawn) {
  const TetrahedralMesh& mesh = simulation.mesh();
  const auto count = static_cast<std::size_t>(mesh.tetrahedron_count());
  std::vector<std::int64_t> nodes, ends, regions;
  for (std::size_t t = 0; t < count; ++t) {
    for (const int node : mesh.tetrahedra[t]) nodes.push_back(node);
    ends.push_back(static_cast<std::int64_t>(nodes.size()));
    regions.push_back(simulation.regions()[t]);
  }
  const Matrix3X displacement_from_rest = simulation.tissue_positions() - mesh.nodes;
  Matrix3X dents(3, mesh.node_count());
  for (int i = 0; i < mesh.node_count(); ++i)
    dents.col(i) = displacement(drawn.dents, simulation.tissue_positions().col(i));
  return {"UnstructuredGrid",
          fmt::format(R"(NumberOfPoints="{}" NumberOfCells="{}")", mesh.node_count(), count),
          {{"PointData",
            {vtk_array("displacement", numbers(displacement_from_rest), 3), vtk_array("dent", numbers(dents), 3)}},
           {"CellData", {vtk_array("region", regions)}},
           {"Points", {vtk_array("position", numbers(simulation.tissue_positions()), 3)}},
           {"Cells",
            {vtk_array("connectivity", nodes), vtk_array("offsets", ends),
             vtk_array("types", std::vector<std::uint8_t>(count, kTetrahedron))}}}};
}

VtkPiece needles_of(const Simulation& simulation) {
  const TickReport& report = simulation.report();
  std::vector<std::int64_t> sizes, phases, flags;
  std::vector<double> depths, spins;
  int total = 0;
  for (int i = 0; i < static_cast<int>(report.needles.size()); ++i) total += simulation.needle_node_count(i);
  Matrix3X points(3, total);
  int next = 0;
  for (int i = 0; i < static_cast<int>(report.needles.size()); ++i) {
    const NeedleReport& needle = report.needles[static_cast<std::size_t>(i)];
    const int size = simulation.needle_node_count(i);
    points.middleCols(next, size) = simulation.needle_positions(i);
    next += size;
    sizes.push_back(size);
    depths.push_back(needle.inserted_depth);
    spins.push_back(needle.spin);
    phases.push_back(static_cast<std::int64_t>(needle.phase));
    flags.push_back(report.flags);
  }
  VtkPiece piece = lines(points, sizes);
  piece.sections.push_back({"CellData",
                            {vtk_array("depth", depths), vtk_array("spin", spins), vtk_array("phase", phases),
                             vtk_array("flags", flags)}});
  return piece;
}

VtkPiece paths_of(const DrawnTissue& drawn) {
  return lines(drawn.path_points.leftCols(drawn.points), {drawn.path_sizes.begin(), drawn.path_sizes.end()});
}

VtkPiece forces_of(const Simulation& simulation) {
  const std::vector<NeedleReport>& needles = simulation.report().needles;
  const auto count = static_cast<Eigen::Index>(2 * needles.size());
  Matrix3X points(3, count), forces(3, count);
  std::vector<std::int64_t> kinds, nodes, ends;
  for (Eigen::Index i = 0; i < count; ++i) {
    const NeedleReport& needle = needles[static_cast<std::size_t>(i / 2)];
    const bool tip = i % 2 == 0;
    points.col(i) = tip ? needle.tip_position : needle.base.position;
    forces.col(i) = tip ? needle.tip_force : needle.base_force;
    kinds.push_back(tip ? 0 : 1);
    nodes.push_back(i);
    ends.push_back(i + 1);
  }
  return {"PolyData",
          fmt::format(R"(NumberOfPoints="{}" NumberOfVerts="{}")", count, count),
          {{"PointData", {vtk_array("force", numbers(forces), 3), vtk_array("kind", kinds)}},
           {"Points", {vtk_array("position", numbers(points), 3)}},
           {"Verts", {vtk_array("connectivity", nodes), vtk_array("offsets", ends)}}}};
}

}  // namespace

VtkExport::VtkExport(const std::string& folder, double rate) : folder_(folder), clock_(rate) {
  std::error_code error;
  std::filesystem::create_directories(folder_, error);
  if (error) throw std::runtime_error(folder + ": the folder cannot be made: " + error.message());
  if (!std::filesystem::is_empty(folder_, error) || error)
    throw std::runtime_error(folder + ": the folder is not empty; give another one for the frames");
}

void VtkExport::take(const Rerun& rerun) {
  if (!clock_.due(rerun)) return;
  const Simulation& simulation = rerun.simulation();
  const double time = rerun.seconds();
  DrawnTissue drawn(simulation.model());
  draw_tissue(simulation.model(), simulation.state(), drawn);
  if (simulation.mesh().node_count() > 0) write_vtk(next_file(0, time), tissue_of(simulation, drawn));
  write_vtk(next_file(1, time), needles_of(simulation));
  write_vtk(next_file(2, time), paths_of(drawn));
  write_vtk(next_file(3, time), forces_of(simulation));
}

std::string VtkExport::next_file(int collection, double time) {
  std::vector<VtkFrame>& frames = collections_[static_cast<std::size_t>(collection)];
  const char* ending = collection == 0 ? "vtu" : "vtp";
  frames.push_back({time, fmt::format("{}_{:06}.{}", kNames[static_cast<std::size_t>(collection)], frames.size(), ending)});
  return (folder_ / frames.back().file).string();
}

void VtkExport::close() const {
  for (std::size_t i = 0; i < kNames.size(); ++i)
    if (!collections_[i].empty()) write_vtk_collection((folder_ / (std::string(kNames[i]) + ".pvd")).string(), collections_[i]);
}

}  // namespace acus
