// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/runtime/unusual_values.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "server/engine/scene/text/text_table.h"

namespace acus {
namespace {

constexpr double kNoEnd = kInfinity;

// What a field has in scenes of tissue and needles.
struct Usual {
  const char* field;
  const char* unit;
  double low, high;
  const char* remedy;
};

// ---- Tissue ----
// From the brain (500 Pa) and soft gels to cortical bone (20 GPa); lung to bone; cork has 0, cartilage 0.1, brain 0.5.
constexpr Usual kTissueStiffness{"material.young_modulus", "Pa", 201, 50e9, "it is in Pa: 10e3 for 10 kPa"};
constexpr Usual kPuncturedStiffness{"material.young_modulus", "Pa", 0, 100e6,
                                    "it is in Pa, 10e3 for 10 kPa; what no needle enters has puncture_force: .inf"};
constexpr Usual kTissueDensity{"material.density", "kg/m^3", 20, 5000,
                               "it is in kg/m^3: 1000 for water and soft tissue"};
constexpr Usual kPoisson{"material.poisson_ratio", "", 0.05, 0.5,
                         "soft tissue hardly changes its volume: 0.45 to 0.499"};
constexpr Usual kStiffnessDamping{"material.rayleigh_stiffness", "s", 0, 0.5, "it is in s: 0.01 for 10 ms"};
constexpr Usual kForceOfLaw{"", "N", 0, 50, "it is in N: 0.5 for 500 mN; what no needle enters has puncture_force: .inf"};
constexpr Usual kFriction{"", "", 0, 5, "a coefficient of friction is no percentage: 0.3 for 30 %"};
constexpr Usual kShaftPressure{"interaction.pressure", "Pa", 50, kNoEnd, "it is in Pa: 5e3 for 5 kPa"};
constexpr Usual kFoundation{"interaction.foundation_stiffness", "Pa", 200, kNoEnd, "it is in Pa: 40e3 for 40 kPa"};
constexpr Usual kSurfacePressure{"pressure", "Pa", 10, kNoEnd, "it is in Pa: 2e3 for 2 kPa"};

// ---- Needles and guides ----
// Glass pipettes to trocars; catheters.
constexpr Usual kThickness{"outer_diameter", "m", 20e-6, 20e-3, "it is in metres: 1.2e-3 for 1.2 mm"};
constexpr Usual kHub{"hub_diameter", "m", 0, 50e-3, "it is in metres: 6e-3 for 6 mm"};
constexpr Usual kLength{"length", "m", 2e-3, 3, "it is in metres: 0.15 for 150 mm"};
constexpr Usual kNeedleDensity{"material.density", "kg/m^3", 500, 25e3, "it is in kg/m^3: 7800 for steel"};
constexpr Usual kNeedleStiffness{"material.young_modulus", "Pa", 0, 1.3e12, "it is in Pa: 200e9 for steel"};
constexpr Usual kSmoothing{"smoothing", "s", 0, 0.5, "it is in s, and the base lags by as much: 5e-3 for 5 ms"};
constexpr Usual kSpeed{"max_speed", "m/s", 1e-4, 20, "it is in m/s: 0.1 for 100 mm/s"};
constexpr Usual kPlay{"play", "m", 0, 5e-3, "it is in metres: 1e-4 for 0.1 mm"};

// ---- The world ----
constexpr Usual kGravity{"gravity", "m/s^2", 1, 30, "it is in m/s^2: [0, 0, -9.81]"};
constexpr Usual kRate{"rate", "Hz", 11, kNoEnd, "it is in Hz: 1000 for 1 kHz"};
constexpr Usual kLawTolerance{"laws.tolerance", "N", 0, 0.05, "forces are off by as much; it is in N: 1e-6"};
constexpr Usual kStaleAfter{"clients.stale_after", "s", 0, 30, "it is in s: 0.1 for 100 ms; .inf: never"};
constexpr Usual kRamp{"clients.ramp", "s", 0, 5, "it is in s: 0.05 for 50 ms"};
constexpr Usual kMaxStep{"clients.max_step", "m", 0, 1, "it is in metres: 0.01 for 10 mm"};
constexpr Usual kMaxTurn{"clients.max_turn", "rad", 0, std::numbers::pi, "it is in rad: 0.0873 for 5 degrees"};

class Comparison {
 public:
  Comparison(std::string of, SceneWarnings& found) : of_(std::move(of)), found_(found) {}

  void operator()(const Usual& usual, double value) { (*this)(usual, usual.field, value); }
  void operator()(const Usual& usual, const std::string& field, double value) {
    if (value >= usual.low && value <= usual.high) return;
    const std::string unit = usual.unit[0] == '\0' ? "" : std::string(" ") + usual.unit;
    const bool low = value < usual.low;
    found_.push_back({of_, field + " of " + five_digits(value) + unit + " is " + (low ? "below " : "above ") +
                               five_digits(low ? usual.low : usual.high) + unit + ", as hardly anything has it; " +
                               usual.remedy});
  }

 private:
  std::string of_;
  SceneWarnings& found_;
};

void compare_tissue(const Region& region, SceneWarnings& found) {
  Comparison compare(region.name, found);
  const Material& material = region.material;
  const Interaction& law = region.interaction;
  compare(kTissueStiffness, material.young_modulus);
  if (std::isfinite(law.puncture_force) && material.young_modulus <= kTissueStiffness.high)
    compare(kPuncturedStiffness, material.young_modulus);
  compare(kTissueDensity, material.density);
  compare(kPoisson, material.poisson_ratio);
  compare(kStiffnessDamping, material.rayleigh_stiffness);
  if (std::isfinite(law.puncture_force)) compare(kForceOfLaw, "interaction.puncture_force", law.puncture_force);
  compare(kForceOfLaw, "interaction.cutting_force", law.cutting_force);
  compare(kFriction, "interaction.friction_static", law.friction_static);
  compare(kFriction, "interaction.friction_dynamic", law.friction_dynamic);
  compare(kFriction, "interaction.friction_contact", law.friction_contact);
  if (law.pressure && *law.pressure > 0) compare(kShaftPressure, *law.pressure);
  if (law.foundation_stiffness) compare(kFoundation, *law.foundation_stiffness);
}

void compare_pressures(const Tissue& tissue, SceneWarnings& found) {
  double stiffest = 0;
  for (const Region& region : tissue.regions) stiffest = std::max(stiffest, region.material.young_modulus);
  for (std::size_t i = 0; i < tissue.pressures.size(); ++i) {
    const double pressure = std::abs(tissue.pressures[i].pressure);
    const std::string field = "pressures[" + std::to_string(i) + "].pressure";
    if (pressure > 0) Comparison("tissue", found)(kSurfacePressure, field, pressure);
    if (pressure > stiffest)
      found.push_back({"tissue", field + " of " + five_digits(pressure) + " Pa presses flat what has E = " +
                                     five_digits(stiffest) + " Pa at most; it is in Pa: 2e3 for 2 kPa"});
  }
}

void compare_needle(const Needle& needle, SceneWarnings& found) {
  Comparison compare(needle.name, found);
  compare(kThickness, needle.outer_diameter);
  compare(kHub, needle.hub_diameter);
  compare(kLength, needle.length);
  compare(kNeedleDensity, needle.material.density);
  compare(kNeedleStiffness, needle.material.young_modulus);
  compare(kStiffnessDamping, needle.material.rayleigh_stiffness);
  compare(kFriction, "torsional_friction", needle.torsional_friction);
  compare(kSmoothing, needle.smoothing.value_or(0));
  compare(kSpeed, needle.max_speed);
  if (needle.constraint_spacing > std::max(needle.length, Needle{}.constraint_spacing))
    found.push_back(
        {needle.name, "constraint_spacing of " + five_digits(needle.constraint_spacing) +
                          " m is longer than the needle, so that one point holds it; it is in metres: 4e-3 for 4 mm"});
  const double turn = std::abs(needle.curvature) * needle.curved_length.value_or(needle.length);
  if (turn > std::numbers::pi)
    found.push_back({needle.name, "curvature of " + five_digits(needle.curvature) + " 1/m bends it by " +
                                      five_digits(turn * 180 / std::numbers::pi) +
                                      " degrees; it is in 1/m: 5 for a radius of 200 mm"});
}

void compare_guide(const Guide& guide, SceneWarnings& found) {
  Comparison compare(guide.name, found);
  compare(kPlay, guide.play);
  compare(kFriction, "friction", guide.friction);
  compare(kSmoothing, guide.smoothing.value_or(0));
  compare(kSpeed, guide.max_speed);
}

void compare_world(const Scene& scene, SceneWarnings& found) {
  Comparison compare("scene", found);
  if (!scene.gravity.isZero(0)) compare(kGravity, scene.gravity.norm());
  compare(kRate, scene.rate);
  compare(kLawTolerance, scene.laws.tolerance);
  if (std::isfinite(scene.clients.stale_after)) compare(kStaleAfter, scene.clients.stale_after);
  compare(kRamp, scene.clients.ramp);
  compare(kMaxStep, scene.clients.max_step.value_or(0));
  compare(kMaxTurn, scene.clients.max_turn.value_or(0));
  compare(kFriction, "needle_contact.friction", scene.needle_contact.friction);
}

}  // namespace

void warn_of_unusual_values(const Scene& scene, SceneWarnings& found) {
  compare_world(scene, found);
  if (!scene.tissue.left_out()) {
    for (const Region& region : scene.tissue.regions) compare_tissue(region, found);
    for (const Interface& each : scene.tissue.interfaces) {
      Comparison compare(each.between + " and " + each.and_, found);
      if (std::isfinite(each.puncture_force)) compare(kForceOfLaw, "puncture_force", each.puncture_force);
      compare(kFriction, "friction_contact", each.friction_contact);
    }
    compare_pressures(scene.tissue, found);
  }
  for (const Needle& needle : scene.needles) compare_needle(needle, found);
  for (const Guide& guide : scene.guides) compare_guide(guide, found);
}

}  // namespace acus
