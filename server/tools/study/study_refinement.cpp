// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/tools/study/locking.h"
#include "server/tools/study/mesh_dependence.h"
#include "server/tools/study/study.h"

namespace acus {

void study_refinement(const StudyPlan& plan) {
  study_locking(plan);
  study_mesh_dependence(plan);
}

}  // namespace acus
