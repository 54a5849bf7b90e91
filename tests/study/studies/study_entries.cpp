// SPDX-License-Identifier: GPL-3.0-or-later
#include <cmath>
#include <limits>
#include <numbers>

#include "server/engine/scene/scene_fields.h"
#include "tests/study/studies/csv.h"
#include "tests/study/studies/entries.h"
#include "tests/study/studies/study.h"

namespace acus {

namespace {

struct Result {
  const Entry& entry;
  const EntryOutcome& outcome;

  const Material& material() const { return entry.scene.tissue.regions[0].material; }
  const Interaction& laws() const { return entry.scene.tissue.regions[0].interaction; }
};

constexpr double kNear = 0.02;  // of f_p: a puncture there is one at f_p

// ghost; found inside; punctured at f_p; early, below it; pressed: never, as a tip that slides off an edge.
const char* verdict(const Result& result) {
  const EntryOutcome& outcome = result.outcome;
  if (outcome.ghost()) return "ghost";
  if (outcome.found_inside > 0) return "found";
  if (!outcome.punctured) return "pressed";
  return std::abs(outcome.puncture_force - result.laws().puncture_force) <= kNear * result.laws().puncture_force
             ? "punctured"
             : "early";
}

constexpr double kDegree = 180 / std::numbers::pi;

constexpr Column<Result> kColumns[] = {
    {"entry", [](const Result& r) -> Cell { return r.entry.number; }},
    {"body", [](const Result& r) -> Cell { return r.entry.body; }},
    {"rung", [](const Result& r) -> Cell { return name_of(r.entry.scene.tissue.rung); }},
    {"a_mm", [](const Result& r) -> Cell { return 1e3 * r.entry.element; }},
    {"young_modulus_Pa", [](const Result& r) -> Cell { return r.material().young_modulus; }},
    {"poisson_ratio", [](const Result& r) -> Cell { return r.material().poisson_ratio; }},
    {"ratio", [](const Result& r) -> Cell { return r.entry.ratio; }},
    {"support", [](const Result& r) -> Cell { return r.entry.support; }},
    {"tilt_deg", [](const Result& r) -> Cell { return kDegree * r.entry.tilt; }},
    {"speed_mm_s", [](const Result& r) -> Cell { return 1e3 * r.entry.speed; }},
    {"friction_contact", [](const Result& r) -> Cell { return r.laws().friction_contact; }},
    {"verdict", [](const Result& r) -> Cell { return verdict(r); }},
    {"puncture_force_N", [](const Result& r) -> Cell { return r.laws().puncture_force; }},
    {"published_N",
     [](const Result& r) -> Cell {
       return r.outcome.punctured ? r.outcome.puncture_force : std::numeric_limits<double>::quiet_NaN();
     }},
    {"indentation_mm", [](const Result& r) -> Cell { return 1e3 * r.outcome.indentation; }},
    {"deepest_mm", [](const Result& r) -> Cell { return 1e3 * r.outcome.deepest; }},
    {"ghost_ticks", [](const Result& r) -> Cell { return r.outcome.ghost_ticks; }},
    {"found_inside", [](const Result& r) -> Cell { return r.outcome.found_inside; }},
    {"releases", [](const Result& r) -> Cell { return r.outcome.released; }},
    {"inverted_ticks", [](const Result& r) -> Cell { return r.outcome.inverted_ticks; }},
    {"flags", [](const Result& r) -> Cell { return r.outcome.flags; }},
    {"ticks", [](const Result& r) -> Cell { return r.outcome.ticks; }},
    {"ms_per_tick", [](const Result& r) -> Cell { return 1e3 * r.outcome.seconds / r.outcome.ticks; }},
};

constexpr int kEntries = 2000, kQuickEntries = 24;

}  // namespace

void study_entries(const StudyPlan& plan) {
  CsvFile file(plan.out + "/entries.csv", names_of(kColumns));
  const int from = plan.first_entry, of = plan.entries > 0 ? plan.entries : plan.quick ? kQuickEntries : kEntries;
  for (int i = from; i < from + of; ++i) {
    const Entry entry = random_entry(i, plan.meshes);
    if ((i - from) % 20 == 0) plan.progress(i - from, of, entry.scene.name);
    file.row(cells_of(kColumns, Result{entry, run_entry(entry)}));
  }
  plan.progress(of, of, "done");
}

}  // namespace acus
