// SPDX-License-Identifier: GPL-3.0-or-later
// The scratch of a tick, sized when the scene is loaded. A tick that starts from a fresh one gives the same bytes; what
// is kept between ticks are caches, on whose content no result depends.
#pragma once

#include <array>
#include <chrono>
#include <optional>
#include <vector>

#include "server/engine/laws/rows.h"
#include "server/engine/models/needle/needle_scratch.h"
#include "server/engine/models/tissue/tissue_scratch.h"
#include "server/engine/state/model.h"
#include "server/engine/state/report.h"
#include "server/engine/state/state.h"
#include "server/engine/tick/contact/contact.h"
#include "server/engine/tick/contact/guides.h"
#include "server/engine/tick/contact/needle_contact.h"
#include "server/engine/tick/insertion/insertion.h"

namespace acus {

// Commands that came in since the last tick, needles first, then guides.
using Commands = std::vector<std::optional<Command>>;

// How the iterations of a tick went; its flags are derived from this alone (stages/write_report.cpp).
struct Outcome {
  int iterations = 0;              // made
  int limit = 0;                   // of iterations or repeats in this tick
  bool tangents_exact = true;      // of all needles: none was near buckling
  bool rows_fit = true;            // none was left out
  SolverResult laws;               // of the last iteration
  LawSteps law_steps;              // of all iterations
  double change = 0;               // m, largest of a position in the last iteration
  double share = 1;                // of the last step, that bodies went
  bool turned_far = false;         // a needle, in the last step
  bool finite = true;              // all numbers are
  bool energy_gained = false;      // a needle holds more than was put into it, see limits.h
  bool overstrained = false;       // likewise, is strained or pressed in more than beams are good for
  std::uint32_t transitions = 0;   // flags of stage 9

  // Whether the last step was more than its linearisation is good for.
  bool went_too_far() const { return share < 1 || turned_far; }
};

// Seconds per stage, if they are wanted.
struct StageTimes {
  bool wanted = false;
  std::array<double, kStageCount> seconds{};
};

// Adds the time until its end to a stage.
class StageTimer {
 public:
  StageTimer(StageTimes& times, Stage stage) : times_(times), stage_(stage) {
    if (times_.wanted) begun_ = Clock::now();
  }
  ~StageTimer() {
    if (times_.wanted)
      times_.seconds[static_cast<std::size_t>(stage_)] += std::chrono::duration<double>(Clock::now() - begun_).count();
  }
  StageTimer(const StageTimer&) = delete;
  StageTimer& operator=(const StageTimer&) = delete;

 private:
  using Clock = std::chrono::steady_clock;
  StageTimes& times_;
  Stage stage_;
  Clock::time_point begun_;
};

struct Scratch {
  explicit Scratch(const Model& model, const Progress& progress = {});
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;

  std::vector<BaseState> bases;               // per needle, at the end of the tick
  std::vector<GuideScratch> guides;
  std::vector<NeedleShape> start_shapes;      // per needle, at the start of the tick
  std::vector<NeedleScratch> needles;
  TissueScratch tissue;
  std::vector<InsertionScratch> insertions;   // per needle
  std::vector<char> paths_taken;              // per path, whether a needle has entered it in this tick
  NeedleContacts needle_contacts;
  Rows rows;
  Contacts contacts;
  std::vector<NeedleForces> forces;           // per needle
  NeedleBalance balance;                      // of the tick before
  Outcome outcome;
  std::vector<Event> events;                  // of this tick, never beyond the capacity reserved at load
  std::vector<std::uint64_t> next_look;       // per needle, the tick of its next look ahead: a cache is filled there
  StageTimes times;
};

// What the laws see of a needle and of the tissue at the current iterate.
NeedleView needle_view(const Model& model, const Scratch& scratch, int needle);
TissueView tissue_view(const Model& model, const Matrix3X& x_start, const Matrix3X& x);
// In the tip's frame, unit: where the path of the needle ends, or without a path in the first region.
const Vector3& tip_cutting(const Model& model, const State& state, int needle);
InsertionView insertion_view(const Model& model, const State& state, const Scratch& scratch, int needle);

}  // namespace acus
