// SPDX-License-Identifier: GPL-3.0-or-later
#include <numbers>

#include "server/engine/scene/scene_fields.h"
#include "tests/study/studies/csv.h"
#include "tests/study/studies/shafts.h"
#include "tests/study/studies/study.h"

namespace acus {

namespace {

struct Result {
  const Shaft& shaft;
  const ShaftOutcome& outcome;

  const Region& region() const { return shaft.entry.scene.tissue.regions[0]; }
};

constexpr double kDegree = 180 / std::numbers::pi;

constexpr Column<Result> kColumns[] = {
    {"shaft", [](const Result& r) -> Cell { return r.shaft.entry.number; }},
    {"body", [](const Result& r) -> Cell { return r.shaft.entry.body; }},
    {"rung", [](const Result& r) -> Cell { return name_of(r.shaft.entry.scene.tissue.rung); }},
    {"a_mm", [](const Result& r) -> Cell { return 1e3 * r.shaft.entry.element; }},
    {"young_modulus_Pa", [](const Result& r) -> Cell { return r.region().material.young_modulus; }},
    {"diameter_mm", [](const Result& r) -> Cell { return 1e3 * r.shaft.entry.scene.needles[0].outer_diameter; }},
    {"puncture_force_N", [](const Result& r) -> Cell { return r.region().interaction.puncture_force; }},
    {"friction_contact", [](const Result& r) -> Cell { return r.region().interaction.friction_contact; }},
    {"tilt_deg", [](const Result& r) -> Cell { return kDegree * r.shaft.entry.tilt; }},
    {"speed_mm_s", [](const Result& r) -> Cell { return 1e3 * r.shaft.entry.speed; }},
    {"sweep_mm", [](const Result& r) -> Cell { return 1e3 * r.shaft.sweep; }},
    {"unheld_mm", [](const Result& r) -> Cell { return 1e3 * r.outcome.unheld; }},
    {"unheld_at_end_mm", [](const Result& r) -> Cell { return 1e3 * r.outcome.unheld_at_end; }},
    {"borne_ticks", [](const Result& r) -> Cell { return r.outcome.borne_ticks; }},
    {"largest_force_N", [](const Result& r) -> Cell { return r.outcome.largest_force; }},
    {"inverted_ticks", [](const Result& r) -> Cell { return r.outcome.inverted_ticks; }},
    {"flags", [](const Result& r) -> Cell { return r.outcome.flags; }},
    {"ticks", [](const Result& r) -> Cell { return r.outcome.ticks; }},
    {"ms_per_tick", [](const Result& r) -> Cell { return 1e3 * r.outcome.seconds / r.outcome.ticks; }},
};

constexpr int kShafts = 2000, kQuickShafts = 4;

}  // namespace

void study_shafts(const StudyPlan& plan) {
  CsvFile file(plan.out + "/shafts.csv", names_of(kColumns));
  const int from = plan.first_entry, of = plan.entries > 0 ? plan.entries : plan.quick ? kQuickShafts : kShafts;
  for (int i = from; i < from + of; ++i) {
    const Shaft shaft = random_shaft(i, plan.meshes);
    if ((i - from) % 20 == 0) plan.progress(i - from, of, shaft.entry.scene.name);
    file.row(cells_of(kColumns, Result{shaft, run_shaft(shaft)}));
  }
  plan.progress(of, of, "done");
}

}  // namespace acus
