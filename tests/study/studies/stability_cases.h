// SPDX-License-Identifier: GPL-3.0-or-later
// The extreme cases of the table of stability: each changes one thing of a small base trial, two together make a pair.
//
// The base trial is a block of 60 mm of soft tissue (10 kPa) in 5 x 5 x 5 cells, held at its bottom, and a steel needle
// above it that goes in by 35 mm at 0.1 m/s, holds, comes out again and rests in the air. World frame, z up, SI units.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tests/study/studies/experiment.h"
#include "tests/study/studies/stability_criteria.h"

namespace acus {

// Where a needle comes to the tissue.
struct Approach {
  Vector3 at{3.1e-3, 1.7e-3, 30e-3};  // m, world: on its line, `gap` ahead of its tip at the start
  Vector3 along = -Vector3::UnitZ();  // its axis; any length
};

// How every needle is moved: along its own axis until its tip is `depth` behind Approach::at, aside, back again, out.
// Then it rests.
struct Manoeuvre {
  double before = 0.05;             // s, of rest at the start
  double gap = 5e-3;                // m
  double depth = 35e-3;             // m
  double speed = 0.1;               // m/s, of the base; 0: it stays where it is
  Vector3 aside = Vector3::Zero();  // m, world: way of the base while the tip is deep
  double spin_speed = 0;            // rad/s, on the way in and at depth
  double hold = 0.15;               // s, at depth
  bool jumps = false;               // every way in one tick
};

// A scene, what its mesh is to become, and what its needles do; changed by cases, then made into an experiment.
struct Trial {
  Scene scene;
  std::vector<Approach> approaches{Approach{}};  // per needle
  Manoeuvre manoeuvre;
  double smallest_dihedral = 0;  // rad, of the distorted mesh; 0: the box as it is
};

struct StabilityCase {
  std::string name;
  std::vector<std::string> knobs;  // what is changed: two cases with one in common are no pair
  std::function<void(Trial&)> change;
  bool nasty = false;     // is paired with all the other nasty ones
  bool refuse = false;    // loading it must end in an error
  bool may_miss = false;  // the needle need not touch the tissue
  bool may_stay = false;  // it need not come out again
};

// A run of the table: a case, alone or with a partner.
struct StabilityRun {
  const StabilityCase* first = nullptr;
  const StabilityCase* partner = nullptr;  // may be missing
};

Trial base_trial();
const std::vector<StabilityCase>& stability_cases();
const StabilityCase& stability_case(const std::string& name);  // throws std::out_of_range
std::vector<StabilityRun> stability_runs();
// Some of them, of every kind: cases alone and pairs, rungs, elements, solvers, one that is refused. All of these pass, so
// that a change which breaks one is seen at once; the full table says which do not.
std::vector<StabilityRun> quick_stability_runs();
bool is_refused(const StabilityRun& run);
Expected expected_of(const StabilityRun& run);
Trial make_trial(const StabilityRun& run);

// The trial's scene with its needles in their places, and their motion until the last command. A mesh that is no box
// goes to a file in `folder`, which must outlive the experiment.
Experiment make_experiment(const Trial& trial, const std::string& folder);

}  // namespace acus
