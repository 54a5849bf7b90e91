// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/study/locking.h"
#include "server/study/mesh_dependence.h"
#include "server/study/study.h"

namespace acus {

void study_refinement(const StudyPlan& plan) {
  study_locking(plan);
  study_mesh_dependence(plan);
}

}  // namespace acus
