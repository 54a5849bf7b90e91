// SPDX-License-Identifier: GPL-3.0-or-later
// validate(): every range of scene_fields.h, then the rules that tie one field to another.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <map>
#include <numbers>
#include <set>
#include <string_view>
#include <utility>

#include "server/engine/scene/field_error.h"
#include "server/engine/scene/scene_fields.h"
#include "server/engine/scene/text/text_table.h"

namespace acus {
namespace {

// What every pair of points needs, some 10 kB, is set aside at load; ticks of so many points are far from real time.
constexpr double kMostPoissonOfWindow = 0.47;  // -
constexpr int kMaxConstraintPoints = 500;

// Fills a few gigabytes with the tissue's factor.
constexpr std::int64_t kMaxTissueCells = 100'000;

// Thinner walls have no area that rounding leaves over.
constexpr double kLargestBore = 0.999;  // outer diameters

constexpr std::size_t kMaxNamesInMessage = 10;

// Longer ones are no quaternion that was not divided by its length.
constexpr double kLongestQuaternion = 3;

// In which numbers are given by mistake: a unit of scenes, another one, and the first in the second; whether numbers in
// it are larger.
struct OtherUnit {
  std::string_view unit;
  const char* other;
  double factor;
  bool more;
};
constexpr std::array kOtherUnits{OtherUnit{"m", "mm", 1e-3, true},
                                 OtherUnit{"m", "micrometres", 1e-6, true},
                                 OtherUnit{"m/s", "mm/s", 1e-3, true},
                                 OtherUnit{"s", "ms", 1e-3, true},
                                 OtherUnit{"rad", "degrees", std::numbers::pi / 180, true},
                                 OtherUnit{"N", "mN", 1e-3, true},
                                 OtherUnit{"Hz", "kHz", 1e3, false},
                                 OtherUnit{"Pa", "kPa", 1e3, false}};

using NameSet = std::set<std::string>;

std::string list_names(const NameSet& names) {
  std::string text;
  std::size_t count = 0;
  for (const std::string& name : names) {
    if (count++ == kMaxNamesInMessage) return text + ", ...";
    text += (text.empty() ? "\"" : ", \"") + name + "\"";
  }
  return text;
}

// Whether the length is a number to divide by; lengths whose square underflows or overflows are not.
bool has_direction(const Vector3& vector) { return std::isnormal(vector.squaredNorm()); }

class Checker {
 public:
  explicit Checker(const Scene& scene) : scene_(scene) {}

  template <class Struct>
  void check_struct(const Struct& value, const std::string& path) const {
    check_fields(FieldsOf<Struct>::list, value, path);
    check_rules(value, path);
  }

 private:
  // What a number of a field is held against.
  struct Bounds {
    Range range;
    std::string_view name, unit;  // of the field
  };

  template <class Tuple, class Struct>
  void check_fields(const Tuple& fields, const Struct& value, const std::string& path) const {
    for_each_entry(fields, [&]<class Entry>(const Entry& entry) {
      if constexpr (is_choice<Entry>) {
        check_fields(entry.alternatives, value, child_path(path, entry.name));
      } else {
        check_value(value.*(entry.member), child_path(path, entry.name), Bounds{entry.range, entry.name, entry.unit});
      }
    });
  }

  template <class Value>
  void check_value(const Value& value, const std::string& path, const Bounds& bounds) const {
    if constexpr (HasFields<Value>) {
      check_struct(value, path);
    } else if constexpr (is_optional<Value>) {
      if (value) check_value(*value, path, bounds);
    } else if constexpr (is_list<Value>) {
      check_entries(value, path, bounds);
    } else if constexpr (std::is_same_v<Value, bool>) {
      return;
    } else if constexpr (std::is_arithmetic_v<Value>) {
      check_number(static_cast<double>(value), path, bounds, std::is_integral_v<Value>);
    } else if constexpr (!std::is_enum_v<Value>) {
      check_leaf(value, path, bounds);
    }
  }

  template <class Value>
  void check_entries(const std::vector<Value>& list, const std::string& path, const Bounds& bounds) const {
    if (!bounds.range.contains(static_cast<double>(list.size()))) {
      fail(path, "expected a list whose length is " + describe(bounds.range) + ", found " +
                     std::to_string(list.size()) + (list.size() == 1 ? " entry" : " entries"));
    }
    for (std::size_t i = 0; i < list.size(); ++i) check_value(list[i], child_path(path, i), bounds);
  }

  void check_number(double value, const std::string& path, const Bounds& bounds, bool whole) const {
    if (bounds.range.contains(value)) return;
    const std::string range = describe(bounds.range);
    fail(path, std::string("expected a ") + (range.empty() ? "finite " : "") + (whole ? "whole " : "") + "number" +
                   (range.empty() ? "" : " ") + range + ", found " + format_number(value) + origin(path) +
                   remedy_of(value, bounds));
  }

  void check_leaf(const std::string& text, const std::string& path, const Bounds& bounds) const {
    if (bounds.range.contains(static_cast<double>(text.size()))) return;
    fail(path, "expected a text whose length is " + describe(bounds.range) +
                   (is_given(path) ? ", found length " + std::to_string(text.size()) : ", found nothing"));
  }

  void check_leaf(const Vector3& vector, const std::string& path, const Bounds& bounds) const {
    for (int i = 0; i < 3; ++i) check_number(vector[i], child_path(path, static_cast<std::size_t>(i)), bounds, false);
  }

  void check_leaf(const std::array<int, 3>& vector, const std::string& path, const Bounds& bounds) const {
    for (std::size_t i = 0; i < 3; ++i) check_number(vector[i], child_path(path, i), bounds, true);
  }

  // The unit in which a number that is out of its range would be in it.
  static std::string remedy_of(double value, const Bounds& bounds) {
    if (bounds.name == "poisson_ratio" && (value < 0 || value > 0.5)) return "; soft tissue has 0.45 to 0.499";
    for (const auto& [unit, other, factor, more] : kOtherUnits)
      if (bounds.unit == unit && bounds.range.contains(value * factor) && more == (value > bounds.range.max))
        return "; it is in " + std::string(unit) + ": " + five_digits(value * factor) + " for " + five_digits(value) +
               " " + other;
    return "";
  }

  void check_leaf(const Quaternion& rotation, const std::string& path, const Bounds&) const {
    const double norm = rotation.norm();
    if (std::abs(norm - 1) <= kUnitTolerance) return;
    std::string remedy;
    if (std::isnormal(norm)) {
      const Quaternion unit = rotation.normalized();
      remedy = norm > kLongestQuaternion
                   ? "; angles are no quaternion"
                   : "; of length 1 it is [" + five_digits(unit.w()) + ", " + five_digits(unit.x()) + ", " +
                         five_digits(unit.y()) + ", " + five_digits(unit.z()) + "]";
    }
    fail(path, "expected a unit quaternion [w, x, y, z], found one of length " + format_number(norm) + remedy);
  }

  // Rules between fields, one overload per struct that has some.
  template <class Struct>
  void check_rules(const Struct&, const std::string&) const {}

  void check_rules(const Interaction& interaction, const std::string& path) const {
    if (interaction.friction_static >= interaction.friction_dynamic) return;
    const std::string field = child_path(path, "friction_static");
    fail(field, "expected a number >= friction_dynamic (" + format_number(interaction.friction_dynamic) + "), found " +
                    format_number(interaction.friction_static) + origin(field));
  }

  void check_rules(const Box& box, const std::string& path) const {
    for (int i = 0; i < 3; ++i) {
      if (box.min[i] <= box.max[i]) continue;
      const std::string field = child_path(child_path(path, "max"), static_cast<std::size_t>(i));
      fail(field, "expected a number >= min (" + format_number(box.min[i]) + "), found " + format_number(box.max[i]));
    }
  }

  void check_rules(const HalfSpace& half_space, const std::string& path) const {
    check_direction(half_space.normal, child_path(path, "normal"));
  }

  void check_rules(const Cylinder& cylinder, const std::string& path) const {
    if (has_direction(cylinder.to - cylinder.from)) return;
    fail(child_path(path, "to"), "expected another point than `from`; the two are the centres of the ends");
  }

  void check_rules(const Volume& volume, const std::string& path) const {
    if (volume.unbounded())
      fail(path, "expected a volume with box, sphere, half_space or cylinder, found none of them");
  }

  void check_rules(const Region& region, const std::string& path) const {
    if (!region.colour) return;
    const std::string_view digits = std::string_view(*region.colour).substr(region.colour->starts_with('#') ? 1 : 0);
    if (digits.size() == 6 && digits.find_first_not_of("0123456789abcdefABCDEF") == std::string_view::npos) return;
    fail(child_path(path, "colour"),
         "expected six hexadecimal digits, such as \"#c08060\", found \"" + *region.colour + "\"");
  }

  void check_rules(const Pressure& pressure, const std::string& path) const {
    check_rules(static_cast<const Volume&>(pressure), path);
  }

  void check_rules(const Needle& needle, const std::string& path) const {
    if (!needle.material.relaxation.empty())
      fail(child_path(path, "material.relaxation"), "expected none, as needles do not relax, found some; remove it");
    if (needle.inner_diameter > kLargestBore * needle.outer_diameter) {
      const std::string field = child_path(path, "inner_diameter");
      fail(field, "expected a number <= " + format_number(kLargestBore) + " outer_diameter (" +
                      format_number(kLargestBore * needle.outer_diameter) + "), found " +
                      format_number(needle.inner_diameter) + "; make the bore smaller or the needle thicker");
    }
    if (needle.hub_diameter != 0 && needle.hub_diameter < needle.outer_diameter)
      fail(child_path(path, "hub_diameter"),
           "expected 0 or a number >= outer_diameter (" + format_number(needle.outer_diameter) + "), found " +
               format_number(needle.hub_diameter) + "; a hub is wider than its needle");
    if (needle.constraint_spacing * kMaxConstraintPoints < needle.length) {
      const std::string field = child_path(path, "constraint_spacing");
      fail(field, "expected a number >= length / " + std::to_string(kMaxConstraintPoints) + " (" +
                      format_number(needle.length / kMaxConstraintPoints) + "), found " +
                      format_number(needle.constraint_spacing) + origin(field));
    }
    check_curvature(needle, child_path(path, "curvature"));
    check_curved_length(needle, child_path(path, "curved_length"));
    check_cutting_direction(needle.cutting_direction, child_path(path, "cutting_direction"));
    if (needle.point_side)
      check_point_side(needle, child_path(path, "point_side"));
    else if (needle.point_offset != Needle{}.point_offset)
      fail(child_path(path, "point_offset"),
           "expected none without point_side, which says to which side it is; add it");
  }

  // A beam is measured from the chord of its arc, which half a turn would reverse.
  void check_curvature(const Needle& needle, const std::string& path) const {
    const double most = std::numbers::pi * needle.beams / needle.length;
    if (std::abs(needle.curvature) < most) return;
    fail(path, "expected a number in (" + format_number(-most) + ", " + format_number(most) + "), found " +
                   format_number(needle.curvature) + "; a beam turns by less than half a turn, more beams allow more");
  }

  void check_curved_length(const Needle& needle, const std::string& path) const {
    if (!needle.curved_length || *needle.curved_length <= needle.length) return;
    fail(path, "expected a number <= length (" + format_number(needle.length) + "), found " +
                   format_number(*needle.curved_length) + "; leave it out to bend the whole needle");
  }

  void check_cutting_direction(const Vector3& direction, const std::string& path) const {
    check_direction(direction, path);
    if (direction.x() > 0) return;
    fail(child_path(path, 0),
         "expected a number > 0, found " + format_number(direction.x()) + "; a tip cuts forwards, along +x");
  }

  void check_point_side(const Needle& needle, const std::string& path) const {
    const Vector3& side = *needle.point_side;
    if (needle.tip != TipShape::bevel)
      fail(path, "expected none at a needle whose tip is no bevel; set tip: bevel, or leave point_side out");
    if (needle.cutting_direction != Vector3::UnitX())
      fail(path, "expected none beside cutting_direction, which says where the tip cuts; leave one of them out");
    if (!has_direction(Vector3(0, side.y(), side.z())))
      fail(path, "expected a vector off the needle's axis, as [0, 1, 0]; only its part across x counts");
  }

  void check_rules(const BoxMesh& box, const std::string& path) const {
    const auto [x, y, z] = box.cells;
    const std::int64_t count = std::int64_t{x} * y * z;
    if (count <= kMaxTissueCells) return;
    fail(child_path(path, "cells"), "expected at most " + std::to_string(kMaxTissueCells) + " cells in all, found " +
                                        std::to_string(count) + "; make them larger");
  }

  void check_rules(const Tissue& tissue, const std::string& path) const {
    NameSet names;
    check_distinct(tissue.regions, child_path(path, "regions"), names, "region");
    check_interfaces(tissue.interfaces, names, child_path(path, "interfaces"));
    if (tissue.window > 0) check_window(tissue, child_path(path, "window"));
    for (std::size_t i = 0; i < tissue.regions.size(); ++i) {
      const std::string region = child_path(child_path(path, "regions"), i);
      if (!tissue.regions[i].material.relaxation.empty())
        check_relaxation(tissue, child_path(region, "material.relaxation"));
      check_tears(tissue, tissue.regions[i].interaction, child_path(region, "interaction.tear_strength"));
    }
    if (tissue.window_thread && tissue.window == 0)
      fail(child_path(path, "window_thread"),
           "expected false without a window, found true; set window to 16 ms in ticks");
  }

  // A path moves by what gives way beside its shaft (tick/insertion/transitions/tearing.h).
  void check_tears(const Tissue& tissue, const Interaction& law, const std::string& path) const {
    if (std::isinf(law.tear_strength)) return;
    const auto refuse = [&](const std::string& with) {
      fail(path,
           "expected .inf with " + with + ", beside which nothing tears, found " + format_number(law.tear_strength));
    };
    if (law.foundation_stiffness && std::isinf(*law.foundation_stiffness)) refuse("foundation_stiffness: .inf");
    if (!law.foundation_stiffness && tissue.local_compliance == LocalCompliance::none)
      refuse("tissue.local_compliance: none");
  }

  // What the deferred field cannot do, or not stably: near nu = 0.5 its defect would grow from window to window.
  void check_window(const Tissue& tissue, const std::string& path) const {
    const auto refuse = [&](const std::string& with) {
      fail(path, "expected 0 with " + with + ", found " + std::to_string(tissue.window));
    };
    if (tissue.rung != TissueRung::warped) refuse("another rung than warped");
    if (tissue.element != TissueElement::linear) refuse("element nodal_pressure");
    double damping = 0;
    for (const Region& region : tissue.regions) {
      damping = std::max(damping, region.material.rayleigh_stiffness);
      if (region.material.poisson_ratio > kMostPoissonOfWindow)
        refuse("poisson_ratio above " + format_number(kMostPoissonOfWindow) + " in region \"" + region.name + "\"");
    }
    if (damping == 0) refuse("no rayleigh_stiffness in any region");
  }

  void check_relaxation(const Tissue& tissue, const std::string& field) const {
    if (tissue.window > 0) fail(field, "expected none with a tissue.window, found some; set tissue.window to 0");
    if (tissue.rung != TissueRung::warped && tissue.rung != TissueRung::refined && !tissue.left_out())
      fail(field, "expected none in this tissue.rung, found some; rungs warped and refined have it");
  }

  void check_rules(const Scene& scene, const std::string& path) const {
    NameSet names;
    check_distinct(scene.needles, child_path(path, "needles"), names, "needle");
    check_guides(scene, names, child_path(path, "guides"));
    check_distinct(scene.guides, child_path(path, "guides"), names, "needle or guide");
    if (scene.tissue.left_out()) return;
    check_constraint_points(scene.needles, child_path(path, "needles"));
    for (std::size_t i = 0; i < scene.needles.size(); ++i)
      if (scene.needles[i].point_side)
        check_shaft_is_held(scene.tissue, child_path(child_path(path, "needles"), i) + ".point_side");
  }

  // The arc of a bevel follows from how the tissue's own elasticity holds the shaft (models/unresolved/bevel.h).
  void check_shaft_is_held(const Tissue& tissue, const std::string& path) const {
    const auto refuse = [&](const std::string& with) {
      fail(path, "expected none with " + with +
                     ", as the arc follows from how the tissue's elasticity holds the shaft; leave out one of them");
    };
    if (tissue.local_compliance == LocalCompliance::none) refuse("tissue.local_compliance: none");
    for (const Region& region : tissue.regions)
      if (region.interaction.foundation_stiffness) refuse("foundation_stiffness of region \"" + region.name + "\"");
  }

  // What they need grows with the square of their number. Any needle may pick up the path with the smallest spacing.
  void check_constraint_points(const std::vector<Needle>& needles, const std::string& path) const {
    double spacing = kInfinity, count = 0;
    for (const Needle& needle : needles) spacing = std::min(spacing, needle.constraint_spacing);
    for (const Needle& needle : needles) count += std::ceil(needle.length / spacing);
    if (count <= kMaxConstraintPoints) return;
    fail(
        path,
        "expected at most " + std::to_string(kMaxConstraintPoints) +
            " constraint points of all needles together (the sum of length / the smallest constraint_spacing), found " +
            format_number(count) + "; raise constraint_spacing");
  }

  void check_interfaces(const std::vector<Interface>& interfaces, const NameSet& regions,
                        const std::string& path) const {
    std::map<std::pair<std::string, std::string>, std::size_t> pairs;
    for (std::size_t i = 0; i < interfaces.size(); ++i) {
      const auto& [between, and_, force, friction] = interfaces[i];
      const std::string entry = child_path(path, i);
      check_known(between, regions, "region", child_path(entry, "between"));
      check_known(and_, regions, "region", child_path(entry, "and"));
      if (between == and_) {
        fail(child_path(entry, "and"),
             "expected another region than the one in `between`, found \"" + and_ + "\" twice");
      }
      const auto [first, is_new] = pairs.emplace(std::minmax(between, and_), i);
      if (is_new) continue;
      fail(entry, "expected every pair of regions once, found that " + child_path(path, first->second) +
                      " is also between \"" + between + "\" and \"" + and_ + "\"; keep one");
    }
  }

  void check_guides(const Scene& scene, const NameSet& needles, const std::string& path) const {
    for (std::size_t i = 0; i < scene.guides.size(); ++i) {
      const std::string field = child_path(child_path(path, i), "needle");
      check_known(scene.guides[i].needle, needles, "needle", field);
      for (const Needle& needle : scene.needles) {
        if (needle.name != scene.guides[i].needle || needle.rung != NeedleRung::rigid) continue;
        fail(field, "expected a flexible needle, found \"" + needle.name +
                        "\", which is rigid and goes where its base does; leave the guide out" + origin(field));
      }
    }
  }

  // Adds the names of the list to `names`, in which none of them may be yet.
  template <class Named>
  void check_distinct(const std::vector<Named>& list, const std::string& path, NameSet& names,
                      const std::string& kind) const {
    for (std::size_t i = 0; i < list.size(); ++i) {
      if (names.insert(list[i].name).second) continue;
      const std::string field = child_path(child_path(path, i), "name");
      fail(field, "expected a name that no other " + kind + " has, found \"" + list[i].name + "\"" + origin(field));
    }
  }

  void check_known(const std::string& name, const NameSet& known, const std::string& kind,
                   const std::string& path) const {
    if (known.contains(name)) return;
    fail(path,
         "expected the name of a " + kind + " (" + list_names(known) + "), found \"" + name + "\"" + origin(path));
  }

  void check_direction(const Vector3& direction, const std::string& path) const {
    if (!has_direction(direction)) fail(path, "expected a vector that is not zero; only its direction counts");
  }

  bool is_given(const std::string& path) const { return scene_.file.empty() || scene_.places.contains(path); }
  std::string origin(const std::string& path) const { return is_given(path) ? "" : " (the default)"; }

  [[noreturn]] void fail(const std::string& path, const std::string& what) const {
    throw scene_error(scene_, path, what);
  }

  const Scene& scene_;
};

}  // namespace

void validate(const Scene& scene) { Checker(scene).check_struct(scene, ""); }

}  // namespace acus
