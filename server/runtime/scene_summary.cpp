// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/runtime/scene_summary.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <numbers>

#include "server/engine/math/largest_move.h"
#include "server/engine/models/needle/needle.h"
#include "server/engine/scene/scene_fields.h"
#include "server/engine/scene/text/text_table.h"
#include "server/engine/state/borders.h"
#include "server/runtime/mesh_summary.h"

namespace acus {
namespace {

std::string vector(const Vector3& v) {
  return std::string("[") + five_digits(v.x()) + ", " + five_digits(v.y()) + ", " + five_digits(v.z()) + "]";
}

std::string megabytes(double bytes) {
  std::array<char, 32> buffer{};
  std::snprintf(buffer.data(), buffer.size(), "%.1f MB", bytes / 1e6);
  return buffer.data();
}

// ---------------------------------------------------------------------------------------------- what it contains

std::string describe_mesh(const Simulation& simulation) {
  const TetrahedralMesh& mesh = simulation.mesh();
  if (mesh.node_count() == 0) return "no tissue";
  const Vector3 size = mesh.nodes.rowwise().maxCoeff() - mesh.nodes.rowwise().minCoeff();
  return std::to_string(mesh.node_count()) + " nodes (" +
         std::to_string(mesh.node_count() - simulation.costs().free_nodes) + " fixed), " +
         std::to_string(mesh.tetrahedron_count()) + " tetrahedra, " + std::to_string(mesh.surface.size()) +
         " surface triangles, " + vector(size) + " m along the world's axes";
}

// What equilibrium has moved.
std::string describe_start(const Simulation& simulation) {
  const auto millimetres = [](double way) { return five_digits(std::round(1e6 * way) / 1e3) + " mm"; };
  const State& state = simulation.state();
  double bent = 0;
  for (int i = 0; i < simulation.model().needle_count(); ++i) {
    const Matrix3X unloaded = make_needle_state(simulation.model().needles[i], simulation.scene().needles[i].base).x;
    bent = std::max(bent, largest_move(unloaded, state.needles[i].x));
  }
  return "in equilibrium: tissue has moved by up to " +
         millimetres(largest_move(simulation.mesh().nodes, state.tissue.x)) + ", needles by " + millimetres(bent);
}

std::string opening(const Simulation& simulation, bool warned) {
  const Scene& scene = simulation.scene();
  TextTable table;
  table.add({"scene", scene.name + (warned ? ": can be used, with warnings" : ": sound")});
  table.add({"rate", five_digits(scene.rate) + " Hz, a tick is " + five_digits(1e3 / scene.rate) + " ms"});
  table.add({"gravity", vector(scene.gravity) + " m/s^2"});
  if (scene.start == Start::equilibrium) table.add({"start", describe_start(simulation)});
  table.add({"rung", name_of(scene.tissue.rung)});
  table.add({"solver", acus::name_of(scene.laws.solver)});
  table.add({"mesh", describe_mesh(simulation)});
  return table.text();
}

std::string relaxation(const Material& material) {
  std::string text;
  for (const Relaxation& branch : material.relaxation)
    text += (text.empty() ? "" : ", ") + five_digits(branch.ratio) + " in " + five_digits(branch.time) + " s";
  return text.empty() ? "none" : text;
}

std::string materials(const Simulation& simulation) {
  const std::vector<Region>& regions = simulation.scene().tissue.regions;
  std::vector<int> tetrahedra(regions.size());
  std::vector<double> volume(regions.size());  // m^3
  for (int t = 0; t < simulation.mesh().tetrahedron_count(); ++t) {
    const int region = simulation.regions()[static_cast<std::size_t>(t)];
    ++tetrahedra[region];
    volume[region] += rest_volume(simulation.mesh(), t);
  }
  TextTable table;
  table.add(
      {"regions", "tetrahedra", "volume (cm^3)", "E (Pa)", "nu", "density (kg/m^3)", "damping (1/s, s)", "relaxation"});
  for (std::size_t i = 0; i < regions.size(); ++i) {
    const Material& m = regions[i].material;
    table.add({"  " + regions[i].name, std::to_string(tetrahedra[i]), five_digits(1e6 * volume[i]),
               five_digits(m.young_modulus), five_digits(m.poisson_ratio), five_digits(m.density),
               five_digits(m.rayleigh_mass) + ", " + five_digits(m.rayleigh_stiffness), relaxation(m)});
  }
  return table.text();
}

std::string viscous_friction(const Interaction& law) {
  const std::string b = five_digits(law.friction_viscous);
  if (law.friction_viscous == 0 || !law.friction_thinning_speed) return b;
  return b + ", thins at " + five_digits(*law.friction_thinning_speed) + " m/s (n " +
         five_digits(law.friction_exponent) + ")";
}

std::string laws(const Scene& scene) {
  TextTable table;
  table.add({"laws", "f_p (N)", "beta", "f_c (N)", "t (N/m)", "p (Pa)", "mu_s", "mu_d", "b (N s/m^2)", "back", "k (Pa)",
             "mu of the tip"});
  for (const Region& region : scene.tissue.regions) {
    const Interaction& law = region.interaction;
    table.add({"  " + region.name, five_digits(law.puncture_force), five_digits(law.deep_indentation),
               five_digits(law.cutting_force), five_digits(law.tear_strength),
               five_digits(shaft_pressure(region)) + (law.pressure ? "" : " (estimated)"),
               five_digits(law.friction_static), five_digits(law.friction_dynamic), viscous_friction(law),
               five_digits(law.friction_back),
               law.foundation_stiffness ? five_digits(*law.foundation_stiffness) : "estimated",
               five_digits(law.friction_contact)});
  }
  return table.text();
}

// Every pair of regions that touch, in both directions, since a border may hold in one and not in the other.
std::string borders(const Simulation& simulation) {
  const auto faces = count_border_faces(simulation.mesh(), simulation.regions());
  if (faces.empty()) return "";
  const Tissue& tissue = simulation.scene().tissue;
  const Borders table_of_borders(tissue, simulation.mesh(), simulation.regions());
  TextTable table;
  table.add({"interfaces", "faces", "f_p (N)", "mu of the tip"});
  const auto add = [&](int from, int into, int count) {
    const Border& border = table_of_borders.at(from, into);
    table.add({"  " + tissue.regions[from].name + " -> " + tissue.regions[into].name, std::to_string(count),
               five_digits(border.puncture_force), five_digits(border.friction_contact),
               border.holds ? "holds the tip" : "no obstacle: f_p is not above f_c"});
  };
  for (const auto& [pair, count] : faces) {
    add(pair.first, pair.second, count);
    add(pair.second, pair.first, count);
  }
  return table.text();
}

std::string shape(const Needle& needle) {
  std::string text =
      needle.inner_diameter > 0 ? std::string("bore ") + five_digits(1e3 * needle.inner_diameter) + " mm" : "solid";
  if (needle.curvature != 0) {
    text += ", last " + five_digits(1e3 * needle.curved_length.value_or(needle.length)) + " mm bent to radius " +
            five_digits(1e3 / std::abs(needle.curvature)) + " mm";
  }
  return text;
}

// Stiffness against a force across a free tip, and Euler's load along it, of a straight needle held at its base.
std::string needles(const Scene& scene) {
  TextTable table;
  table.add({"needles", "rung", "beams", "length (mm)", "diameter (mm)", "shape", "cuts along", "EI (N m^2)",
             "3EI/L^3 (N/m)", "buckles unguided at (N)"});
  for (const Needle& needle : scene.needles) {
    const bool rigid = needle.rung == NeedleRung::rigid;
    const double bending = make_needle_model(needle, scene.gravity).stiffness.bending;  // N m^2
    const double length = needle.length;
    const double lateral = 3 * bending / (length * length * length);                                // N/m
    const double buckling = std::numbers::pi * std::numbers::pi * bending / (4 * length * length);  // N
    table.add({"  " + needle.name, name_of(needle.rung), std::to_string(needle.beams), five_digits(1e3 * length),
               five_digits(1e3 * needle.outer_diameter), shape(needle),
               needle.point_side ? "as its bevel steers" : vector(needle.cutting_direction),
               rigid ? "-" : five_digits(bending), rigid ? "-" : five_digits(lateral),
               rigid ? "-" : five_digits(buckling)});
  }
  return table.text();
}

// Arcs through each region, from the geometry of the bevel.
std::string bevels(const Simulation& simulation) {
  constexpr double kDegree = std::numbers::pi / 180;
  const Scene& scene = simulation.scene();
  TextTable table;
  table.add({"bevels", "through", "to", "face (deg)", "radius (mm)", "cuts off its axis by (deg)"});
  bool any = false;
  for (std::size_t i = 0; i < scene.needles.size(); ++i) {
    const Needle& needle = scene.needles[i];
    if (!needle.point_side) continue;
    any = true;
    for (const Region& region : scene.tissue.regions) {
      const BevelPath path = steered_path(needle, simulation.model().needles[i], region);
      table.add({"  " + needle.name, region.name, vector(*needle.point_side),
                 five_digits(*face_angle(needle) / kDegree),
                 path.curvature > 0 ? five_digits(1e3 / path.curvature) : "straight",
                 five_digits(std::atan(path.slope) / kDegree)});
    }
  }
  return any ? table.text() : "";
}

std::string holds(const Scene& scene) {
  if (std::ranges::none_of(scene.needles, [](const Needle& needle) { return needle.hold.has_value(); })) return "";
  TextTable table;
  table.add({"bases held", "k (N/m)", "c (N s/m)", "k_r (N m/rad)", "c_r (N m s/rad)"});
  for (const Needle& needle : scene.needles) {
    if (!needle.hold) continue;
    table.add({"  " + needle.name, five_digits(needle.hold->stiffness), five_digits(needle.hold->damping),
               five_digits(needle.hold->angular_stiffness), five_digits(needle.hold->angular_damping)});
  }
  return table.text();
}

std::string guides(const Scene& scene) {
  if (scene.guides.empty()) return "";
  TextTable table;
  table.add({"guides", "of needle", "at (m)", "play (mm)", "mu"});
  for (const Guide& guide : scene.guides) {
    table.add({"  " + guide.name, guide.needle, vector(guide.pose.position), five_digits(1e3 * guide.play),
               five_digits(guide.friction)});
  }
  return table.text();
}

// ---------------------------------------------------------------------------------------------- what may go wrong

std::string warnings(const std::vector<SceneWarning>& found) {
  if (found.empty()) return "";
  TextTable table;
  table.add({"warnings"});
  for (const SceneWarning& warning : found) table.add({"  " + warning.of, warning.text});
  return table.text();
}

// ---------------------------------------------------------------------------------------------- what it costs

// The large arrays only (bytes); what else there is grows with the mesh alone.
struct Memory {
  double factor = 0;    // L of the tissue
  double corridor = 0;  // columns of L⁻¹ and their Gram matrix
  double rows = 0;      // W, the solver's matrices of its size, the needles' panels
  double total() const { return factor + corridor + rows; }
};

Memory memory(const Scene& scene, const Costs& costs) {
  constexpr double kWord = sizeof(double);
  // rows x rows: W; the matrices of the elimination, of the laws that it leaves, of the base's stiffness
  constexpr double kSquares = 4;
  constexpr double kPanel = 12;  // numbers per row, of each needle: see engine/models/needle/needle_compliance.h
  const double corridor = 3.0 * costs.corridor_nodes;
  const double rows = costs.max_rows;
  const double panels = kPanel * static_cast<double>(scene.needles.size());
  return {static_cast<double>(costs.factor_bytes), kWord * corridor * (costs.corridor_column + corridor),
          kWord * rows * (kSquares * rows + panels)};
}

const char* use_of_factor(TissueRung rung) {
  switch (rung) {
    case TissueRung::none:
    case TissueRung::linear:
    case TissueRung::warped:
      break;
    case TissueRung::refined:
      return " entries, read twice in every iteration of a tick";
    case TissueRung::exact:
      return " entries, made anew in every iteration of a tick";
  }
  return " entries, read twice in every tick";
}

void add_tissue(TextTable& table, const Tissue& tissue, const Costs& costs, const Memory& bytes) {
  table.add({"  unknowns", std::to_string(3 * costs.free_nodes),
             std::string("of ") + std::to_string(costs.free_nodes) + " free nodes"});
  table.add({"  factor", megabytes(bytes.factor),
             std::to_string(costs.factor_entries) +
                 (costs.window > 0 ? " entries, read twice in a window" : use_of_factor(tissue.rung))});
  if (costs.window > 0)
    table.add({"  window", std::to_string(costs.window) + " ticks",
               (tissue.window_thread ? "work of a thread of its own, as much as " +
                                           five_digits(costs.slice * costs.window) + " entries; "
                                     : "work of a tick as much as " + five_digits(costs.slice) + " entries, at most " +
                                           five_digits(costs.largest_slice) + "; ") +
                   std::to_string(costs.modes) + " modes, about the " +
                   (costs.about_equilibrium ? "equilibrium" : "rest shape")});
  table.add({"  corridor", megabytes(bytes.corridor),
             std::string("compliance of up to ") + std::to_string(costs.corridor_nodes) + " nodes around the needles"});
}

std::string expenses(const Simulation& simulation) {
  const Costs costs = simulation.costs();
  const Tissue& tissue = simulation.scene().tissue;
  const Memory bytes = memory(simulation.scene(), costs);
  TextTable table;
  table.add({"costs"});
  if (!tissue.left_out()) add_tissue(table, tissue, costs, bytes);
  table.add({"  rows", std::to_string(costs.max_rows), "of the laws in one tick, at most"});
  const std::string laws_steps = std::to_string(simulation.scene().laws.max_steps);
  table.add({"  solutions", std::to_string(costs.max_tick_steps),
             "in one tick, at most, of up to " + laws_steps + " steps of the laws; a tick that stops there is flagged"});
  table.add({"  row matrices", megabytes(bytes.rows), "at most; what a tick uses goes with its rows"});
  table.add({"  total", megabytes(bytes.total()), "besides the mesh"});
  return table.text();
}

// ---------------------------------------------------------------------------------------------- what it leaves out

// "a, b, c": the names of those that leave something out; empty if none does.
template <class Named>
std::string names_where(const std::vector<Named>& list, const std::function<bool(const Named&)>& leaves_out) {
  std::string names;
  for (const Named& entry : list) {
    if (leaves_out(entry)) names += (names.empty() ? "" : ", ") + entry.name;
  }
  return names;
}

// A line for each thing, with the field that puts it in.
class Omissions {
 public:
  Omissions() { table_.add({"leaves out"}); }

  void add(bool left_out, const std::string& what, const std::string& field) {
    if (left_out) table_.add({std::string("  ") + what, std::string("set ") + field});
  }
  template <class Named>
  void add_for(const std::vector<Named>& list, const std::function<bool(const Named&)>& leaves_out,
               const std::string& what, const std::string& field) {
    const std::string names = names_where(list, leaves_out);
    add(!names.empty(), what + " " + names, field);
  }
  std::string text() const { return table_.text(); }

 private:
  TextTable table_;
};

bool yields_only_with_mesh(const Region& region) { return region.interaction.foundation_stiffness == kInfinity; }

bool has_no_friction(const Region& region) {
  return shaft_pressure(region) == 0 || region.interaction.friction_static == 0;
}

void add_tissue(Omissions& list, const Scene& scene) {
  const Tissue& tissue = scene.tissue;
  list.add(tissue.fixed.empty(), "supports: no node is fixed, the tissue floats freely", "tissue.fixed");
  list.add(tissue.rung == TissueRung::linear, "rotations: rung linear is right for small deformations alone",
           "tissue.rung: warped");
  list.add(tissue.rung == TissueRung::warped, "the exact tangent: rung warped solves with that of the rest shape",
           "tissue.rung: refined or exact");
  list.add_for<Region>(
      tissue.regions, [](const Region& r) { return r.material.relaxation.empty(); }, "relaxation of the tissue in",
      "material.relaxation");
  list.add_for<Region>(tissue.regions, has_no_friction, "friction on the shaft in",
                       "interaction.pressure, friction_static");
  list.add_for<Region>(tissue.regions, yields_only_with_mesh,
                       "the compliance beside the shaft that the mesh cannot resolve in",
                       "interaction.foundation_stiffness");
  list.add_for<Region>(
      tissue.regions, [](const Region& r) { return r.interaction.friction_viscous == 0; }, "viscous friction in",
      "interaction.friction_viscous");
  list.add_for<Region>(
      tissue.regions, [](const Region& r) { return r.interaction.cutting_force == 0; }, "cutting in",
      "interaction.cutting_force");
  list.add_for<Needle>(
      scene.needles, [](const Needle& n) { return n.torsional_friction == 0; }, "torsional friction on",
      "torsional_friction");
  list.add_for<Needle>(
      scene.needles, [](const Needle& n) { return n.hub_diameter == 0; }, "what stops the base at the skin, of",
      "hub_diameter");
}

std::string left_out(const Scene& scene) {
  Omissions list;
  list.add(scene.gravity.isZero(0), "gravity", "gravity");
  const bool loaded = !scene.gravity.isZero(0) || !scene.tissue.pressures.empty();
  list.add(loaded && scene.start == Start::undeformed,
           "rest at the start: gravity and pressures begin to act at tick 0", "start: equilibrium");
  list.add(scene.tissue.left_out(), "tissue", "tissue.rung");
  if (!scene.tissue.left_out()) add_tissue(list, scene);
  list.add_for<Needle>(
      scene.needles, [](const Needle& n) { return n.rung == NeedleRung::rigid; }, "bending of", "rung: flexible");
  list.add_for<Guide>(
      scene.guides, [](const Guide& g) { return g.friction == 0; }, "friction in", "friction");
  const bool several = scene.needles.size() > 1, apart = scene.needle_contact.enabled;
  list.add(several && !apart, "contact between needles", "needle_contact.enabled");
  list.add(several && apart && scene.needle_contact.friction == 0, "friction between needles",
           "needle_contact.friction");
  return list.text();
}

}  // namespace

std::string summarise(const Simulation& simulation, const std::vector<SceneWarning>& more) {
  const Scene& scene = simulation.scene();
  const bool tissue = !scene.tissue.left_out();
  std::vector<SceneWarning> found = scene_warnings(simulation);
  found.insert(found.end(), more.begin(), more.end());
  const std::string warned = warnings(found);
  std::string text = opening(simulation, !warned.empty());
  const std::array sections{tissue ? summarise_mesh_file(simulation) : "",
                            tissue ? materials(simulation) : "",
                            tissue ? laws(scene) : "",
                            tissue ? borders(simulation) : "",
                            needles(scene),
                            tissue ? bevels(simulation) : "",
                            holds(scene),
                            guides(scene),
                            warned,
                            expenses(simulation),
                            left_out(scene)};
  for (const std::string& section : sections) {
    if (!section.empty()) text += "\n" + section;
  }
  return text;
}

}  // namespace acus
