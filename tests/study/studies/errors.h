// SPDX-License-Identifier: GPL-3.0-or-later
// How far one run is from another of the same motion. The other one, the reference, has the same needles and probes and
// a time step that is not longer; between its ticks it is taken as straight lines, which errs by h²/8 of its second
// derivative where the ticks do not coincide.
#pragma once

#include "tests/study/studies/experiment.h"

namespace acus {

// Of the length of a difference vector, over time and needles or probes: its maximum, its root mean square, and what 95
// of 100 are below. A puncture that comes a tick earlier or later differs by its whole drop of force for that tick: it
// makes the maximum, and a floor of (drop) sqrt(h/duration) under the root mean square; the percentile does not see it.
struct Deviation {
  double max = 0;
  double rms = 0;
  double p95 = 0;
};

struct Errors {
  Deviation tip;     // m, of all needles
  Deviation force;   // N, at the bases
  Deviation tissue;  // m, of the probes
};

Errors errors(const Recording& run, const Recording& reference);

// The same of the reference itself against zero, but for tips against where they started: what errors are a share of.
Errors magnitudes(const Recording& reference);

}  // namespace acus
