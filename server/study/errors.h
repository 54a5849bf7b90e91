// SPDX-License-Identifier: GPL-3.0-or-later
// How far one run is from another of the same motion. The other one, the reference, has the same needles and probes and
// a time step that is not longer; between its ticks it is taken as straight lines, which errs by h²/8 of its second
// derivative where the ticks do not coincide.
#pragma once

#include "server/study/experiment.h"

namespace acus {

// Of the length of a difference vector: its maximum, and its root mean square over time and needles or probes.
struct Deviation {
  double max = 0;
  double rms = 0;
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
