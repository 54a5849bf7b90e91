// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/state/model.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <span>

#include "server/engine/models/tissue/unfit_tissue.h"
#include "server/engine/scene/field_error.h"
#include "server/engine/scene/fingerprint.h"
#include "server/engine/scene/text/text_table.h"
#include "server/engine/state/capacities.h"
#include "server/engine/state/clearance.h"

namespace acus {

namespace {

// The scene itself, if its values are in range: one built in code has not been through the reader.
const Scene& checked(const Scene& scene) {
  validate(scene);
  return scene;
}

std::vector<Interaction> interactions_of(const Scene& scene) {
  std::vector<Interaction> all;
  for (const Region& region : scene.tissue.regions) {
    all.push_back(region.interaction);
    all.back().pressure = shaft_pressure(region);
  }
  return all;
}

std::vector<Material> materials_of(const Scene& scene) {
  std::vector<Material> all;
  for (const Region& region : scene.tissue.regions) all.push_back(region.material);
  return all;
}

std::vector<RelaxationStep> relaxation_of(const Scene& scene, double h) {
  std::vector<RelaxationStep> all;
  const auto relaxes = [](const Region& region) { return !region.material.relaxation.empty(); };
  if (std::ranges::none_of(scene.tissue.regions, relaxes)) return all;
  for (const Region& region : scene.tissue.regions) all.emplace_back(region.material, h);
  return all;
}

std::vector<double> element_sizes_of(const TetrahedralMesh& mesh) {
  std::vector<double> sizes;
  for (int t = 0; t < mesh.tetrahedron_count(); ++t) sizes.push_back(element_size(mesh, t));
  return sizes;
}

TissueMatrix matrix_of(TissueRung rung) {
  switch (rung) {
    case TissueRung::linear:
      return TissueMatrix::constant;
    case TissueRung::exact:
      return TissueMatrix::refactorized;
    default:
      return TissueMatrix::turned;
  }
}

TissueSystem tissue_system_of(const Scene& scene, const TissueModel& tissue, double h, const TissueState* equilibrium) {
  try {
    return TissueSystem(tissue, h, matrix_of(scene.tissue.rung), scene.tissue.window, scene.tissue.window_thread,
                        equilibrium);
  } catch (const UnfitTissue& unfit) {
    throw scene_error(scene, unfit.field, unfit.what());
  }
}

std::vector<NeedleModel> needles_of(const Scene& scene) {
  std::vector<NeedleModel> models;
  for (const Needle& needle : scene.needles)
    models.push_back(make_needle_model(needle, scene.gravity, needle.rung == NeedleRung::rigid, needle.hold));
  return models;
}

// In the tip's frame, unit, through tissue of the region.
Vector3 cutting_direction(const Needle& needle, const NeedleModel& model, const Region& region) {
  if (!needle.point_side) return needle.cutting_direction.normalized();
  const Vector3 side = Vector3(0, needle.point_side->y(), needle.point_side->z()).normalized();
  return (Vector3::UnitX() + steered_path(needle, model, region).slope * side).normalized();
}

std::vector<std::vector<Vector3>> cutting_directions_of(const Scene& scene, std::span<const NeedleModel> models) {
  std::vector<std::vector<Vector3>> cuts(models.size());
  for (std::size_t i = 0; i < models.size(); ++i)
    for (const Region& region : scene.tissue.regions)
      cuts[i].push_back(cutting_direction(scene.needles[i], models[i], region));
  return cuts;
}

template <class Body>
std::vector<BaseLimits> limits_of(const std::vector<Body>& bodies) {
  std::vector<BaseLimits> limits;
  for (const Body& body : bodies) limits.push_back(base_limits(body));
  return limits;
}

std::vector<int> needles_in_guides(const Scene& scene) {
  std::vector<int> needles;
  for (const Guide& guide : scene.guides) {
    const auto same = [&](const Needle& needle) { return needle.name == guide.needle; };
    const auto found = std::find_if(scene.needles.begin(), scene.needles.end(), same);
    needles.push_back(static_cast<int>(found - scene.needles.begin()));
  }
  return needles;
}

int vertices_per_path(const Scene& scene) {
  if (scene.tissue.left_out()) return 0;
  const double spacing = least_spacing(scene.needles);
  int most = 0;
  for (const Needle& needle : scene.needles) most = std::max(most, 2 * max_shaft_points(needle, spacing));
  return most;
}

int count_rows(const Scene& scene) {
  return max_rows_of_needles_alone(scene) + (scene.tissue.left_out() ? 0 : max_insertion_rows(scene));
}

// An element's force comes from differences of coordinates, which are rounded to their share of the largest one: E a
// times that, and a few digits for the sum.
double force_rounding_of(const Scene& scene, const TetrahedralMesh& mesh, std::span<const int> regions,
                         std::span<const double> sizes) {
  constexpr double kRounding = 100 * std::numeric_limits<double>::epsilon();
  double stiffest = 0;  // N/m
  for (int t = 0; t < mesh.tetrahedron_count(); ++t)
    stiffest = std::max(stiffest, Moduli(scene.tissue.regions[regions[t]].material).young * sizes[t]);
  return mesh.nodes.size() == 0 ? 0 : kRounding * stiffest * mesh.nodes.cwiseAbs().maxCoeff();
}

// Tells what a step of loading is about to make, and makes it.
template <class Make>
auto announced(const Progress& progress, const char* what, Make make) {
  if (progress) progress(what);
  return make();
}

// Wider tissue was meant in millimetres.
constexpr double kLargestOrgan = 2;  // m

// A tip in the middle of the tissue has no path that it came by.
void refuse_tip_inside(const Model& model, int needle) {
  if (!tip_is_inside(model.mesh, model.mesh.nodes, model.needles[needle], model.scene.needles[needle].base)) return;
  const double width = (model.mesh.nodes.rowwise().maxCoeff() - model.mesh.nodes.rowwise().minCoeff()).maxCoeff();
  throw scene_error(
      model.scene, child_path("needles", static_cast<std::size_t>(needle)) + ".base",
      "expected the needle's tip outside the tissue, found it inside; " +
          (width > kLargestOrgan ? "the tissue is " + five_digits(width) + " m wide: lengths are in metres"
                                 : std::string("move the base back")));
}

// Between needles that are one in the other there is no direction in which they could push each other apart.
void refuse_overlap(const Model& model) {
  std::vector<NeedleState> states;
  for (int i = 0; i < model.needle_count(); ++i)
    states.push_back(make_needle_state(model.needles[i], model.scene.needles[i].base));
  const std::optional<Overlap> found = find_overlap(model.scene, model.needles, states);
  if (!found) return;
  throw scene_error(model.scene, child_path("needles", static_cast<std::size_t>(found->second)) + ".base",
                    sentence(model.scene, *found) +
                        "; move the base, or set needle_contact.enabled: false where one lies in the other");
}

}  // namespace

const Vector3& Model::cutting_direction(int needle) const {
  const auto& of_regions = cutting_directions[static_cast<std::size_t>(needle)];
  return *std::ranges::min_element(of_regions, {}, [](const Vector3& direction) { return direction.x(); });
}

BevelPath steered_path(const Needle& needle, const NeedleModel& model, const Region& region) {
  if (model.rigid) return {};
  const Interaction& law = region.interaction;
  const double d = needle.outer_diameter;
  return bevel_path({d, model.stiffness.bending, *face_angle(needle), needle.point_offset * d / 2},
                    {Moduli(region.material), law.cutting_force, law.tear_strength});
}

int max_tissue_rows(const Scene& scene, const Needle& needle) {
  const bool borders = scene.tissue.regions.size() > 1;
  return scene.tissue.left_out() ? 0 : max_insertion_rows(needle, least_spacing(scene.needles), borders);
}

int max_rows_of_needles_alone(const Scene& scene) {
  return kMaxGuideRows * static_cast<int>(scene.guides.size()) + kRowsOfNeedleContact * max_needle_contacts(scene);
}

Model::Model(const Scene& s, const Progress& progress, std::optional<TetrahedralMesh> own_mesh,
             const TissueState* equilibrium)
    : scene(checked(s)),
      h(1 / s.rate),
      mesh(placed(s, own_mesh ? *std::move(own_mesh) : announced(progress, "mesh", [&] { return read_mesh(s); }))),
      regions(announced(progress, "regions", [&] { return assign_regions(s, mesh); })),
      interactions(interactions_of(s)),
      relaxation(relaxation_of(s, h)),
      element_sizes(element_sizes_of(mesh)),
      fingerprint(acus::fingerprint(s, mesh, regions)),
      force_rounding(force_rounding_of(s, mesh, regions, element_sizes)),
      tissue(announced(progress, "elements",
                       [&] {
                         TissueModel made = make_tissue_model(mesh, regions, materials_of(s), find_fixed_nodes(s, mesh),
                                                              s.gravity, s.tissue.element);
                         made.applied += pressure_forces(s, mesh);
                         return made;
                       })),
      surface(announced(progress, "surfaces", [&] { return Surface(mesh); })),
      borders(s.tissue, mesh, regions),
      tissue_system(announced(progress, "factor", [&] { return tissue_system_of(s, tissue, h, equilibrium); })),
      needles(announced(progress, "needles", [&] { return needles_of(s); })),
      cutting_directions(cutting_directions_of(s, needles)),
      needle_limits(limits_of(s.needles)),
      guide_limits(limits_of(s.guides)),
      guide_needles(needles_in_guides(s)),
      path_vertices(vertices_per_path(s)),
      max_rows(count_rows(s)) {
  for (int i = 0; i < needle_count(); ++i) refuse_tip_inside(*this, i);
  refuse_overlap(*this);
}

}  // namespace acus
