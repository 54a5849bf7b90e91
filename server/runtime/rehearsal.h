// SPDX-License-Identifier: GPL-3.0-or-later
// How long the ticks of a loaded scene take on this machine. What a tick costs depends on how much of the needles is
// inside, which no count of nodes and rows tells: so the needles are pushed in, along their own axes, and the ticks are
// timed on the way. Times are processor time of this thread: what other programs take of the machine does not count.
#pragma once

#include <string>
#include <vector>

#include "server/engine/tick/simulation.h"
#include "server/runtime/scene_warnings.h"

namespace acus {

struct RehearsalLimits {
  double processor_time = 4;  // s of all ticks together
  double duration = 20;       // s of simulation time
};

// Ticks that follow each other, summed up.
struct RehearsedTicks {
  int ticks = 0;
  double depth = 0;   // m, median of the deepest needle's
  double rows = 0;    // median
  double median = 0;  // s
  double p99 = 0;     // s
};

// What ended a rehearsal.
enum class RehearsalEnd { needles_are_through, processor_time, duration };

struct Rehearsal {
  RehearsedTicks outside;              // no needle touches tissue; no ticks if one always does
  std::vector<RehearsedTicks> inside;  // deeper and deeper; none if no needle got to the tissue before the end
  RehearsalEnd end = RehearsalEnd::needles_are_through;
  RehearsalLimits limits;
  int window = 0;             // ticks, that tissue.window_thread has for a window; 0: there is no such thread
  double window_seconds = 0;  // that it takes, in 99 of 100 windows
};

// Begins at the state after loading, and leaves the simulation there.
Rehearsal rehearse(Simulation& simulation, const RehearsalLimits& limits = {});

// tissue.window of 16 ms, which hands on haptic devices do not notice, where it would make the scene's ticks shorter; 0
// where it would not, or the scene cannot have one.
int window_to_try(const Simulation& simulation);

// Of ticks, and of a window's thread, that take longer than they may with ticks of this length (s). `window`: one that
// would make them shorter, if there is any.
std::vector<SceneWarning> rehearsal_warnings(const Rehearsal& rehearsal, double time_step, int window = 0);

// For a person to read, with the share of a tick of this length (s).
std::string describe(const Rehearsal& rehearsal, double time_step);

}  // namespace acus
