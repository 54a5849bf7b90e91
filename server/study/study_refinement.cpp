// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/study/locking.h"
#include "server/study/study.h"

namespace acus {

void study_refinement(const StudyPlan& plan) { study_locking(plan); }

}  // namespace acus
