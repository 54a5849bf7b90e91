// SPDX-License-Identifier: GPL-3.0-or-later
// What Acus finds out about itself: studies that run many simulations in process and write tables. acus-evidence runs
// them, scripts/report draws what they write.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "server/engine/scene/scene.h"

namespace acus {

struct StudyPlan {
  std::string scenes = "scenes";  // folder with the project's scenes and, below it, trajectories/
  std::string out = ".";          // folder that the tables go to; must exist
  std::string scene;              // of the study of errors: this one only; empty: all
  std::string stability_run;      // of the study of stability: this one only, by its name in the table; empty: all
  bool quick = false;             // a short form that still goes through every kind of run
  int entries = 0;                // of the studies of entries and shafts: how many; 0: their own number
  int first_entry = 0;            // and which one comes first
  std::vector<GmshMesh> meshes;   // and into which meshes besides blocks
  std::string haptics_table = "stability.csv";  // of the study of haptics: its table,
  int part = 0, parts = 1;        // and which runs: every `parts`th from number `part` on
  // Told what has been done of what, in runs, and what comes next.
  std::function<void(int done, int of, const std::string& next)> progress = [](int, int, const std::string&) {};
};

// errors_SCENE.csv: how far scenes of the project are from a converged reference, and how long they take, over every
// knob (errors.h).
void study_errors(const StudyPlan& plan);

// locking.csv, mesh_dependence.csv: what elements and meshes do to forces and shapes (locking.h, mesh_dependence.h).
void study_refinement(const StudyPlan& plan);

// entries.csv: needles that go in at random places, and whether any of them is a ghost (entries.h).
void study_entries(const StudyPlan& plan);

// shafts.csv: thin needles that bend, slide and are swept over tissue, and whether it bears their shafts (shafts.h).
void study_shafts(const StudyPlan& plan);

// holds.csv: the largest jump of force after bases have stopped at random moments of the scenes' motions (force_jumps.h).
void study_holds(const StudyPlan& plan);

// windows.csv: what deferred fields of several lengths do to forces and run time, in every scene of the project.
void study_windows(const StudyPlan& plan);

// stability.csv: extreme cases and pairs of them, with a verdict each (stability_cases.h, stability_criteria.h).
void study_stability(const StudyPlan& plan);

// stability.csv, or what plan.haptics_table says: haptic loops, with the kit and without it (haptic_run.h).
void study_haptics(const StudyPlan& plan);

}  // namespace acus
