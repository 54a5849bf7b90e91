// SPDX-License-Identifier: GPL-3.0-or-later
#include <numbers>

#include "server/engine/scene/scene.h"

namespace acus {

std::optional<double> face_angle(const Needle& needle) {
  constexpr double kDegree = std::numbers::pi / 180;
  if (needle.tip == TipShape::blunt) return std::nullopt;
  if (needle.tip_angle) return needle.tip_angle;
  switch (needle.tip) {
    case TipShape::pencil:
      return 15 * kDegree;
    case TipShape::trocar:
      return 20 * kDegree;
    default:
      return 11 * kDegree;
  }
}

}  // namespace acus
