// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/models/element/relaxation.h"

#include <cmath>

namespace acus {

RelaxationStep::RelaxationStep(const Material& material, double h) {
  for (std::size_t i = 0; i < material.relaxation.size(); ++i) {
    const Relaxation& branch = material.relaxation[i];
    const auto k = static_cast<Eigen::Index>(i);
    given[k] = branch.ratio * std::exp(-h / branch.time);
    taken[k] = -std::expm1(-h / branch.time);
    stiffening += given[k];
  }
}

}  // namespace acus
