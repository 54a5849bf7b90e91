// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/study/studies/locking.h"
#include "tests/study/studies/mesh_dependence.h"
#include "tests/study/studies/study.h"

namespace acus {

void study_refinement(const StudyPlan& plan) {
  study_locking(plan);
  study_mesh_dependence(plan);
}

}  // namespace acus
