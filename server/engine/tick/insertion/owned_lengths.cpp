// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/tick/insertion/owned_lengths.h"

#include <algorithm>
#include <cassert>

#include "server/engine/tick/insertion/path_wall.h"

namespace acus {

namespace {

using Part = std::span<ShaftPoint>;

double owned_by(Part part) {
  double length = 0;
  for (const ShaftPoint& point : part) length += point.owned;
  return length;
}

// From wall to wall, or to the tip, whose `end_advance` (m) is 0. All alike: a vertex that owned little beside the tip
// would have to build up its friction as it comes to own more.
void scale_owned(Part part, double end_advance) {
  const double length = owned_by(part), grows = end_advance - (part.front().mouth ? part.front().advance : 0);
  if (length == 0) return;
  for (ShaftPoint& point : part) point.owned *= std::max(0.0, 1 + grows / length);
}

}  // namespace

double share_length(std::span<ShaftPoint> shaft, double end, bool tip_supports) {
  assert(std::ranges::is_sorted(shaft, {}, &ShaftPoint::vertex));
  const auto count = static_cast<int>(shaft.size());
  for (int i = 0; i < count; ++i) {
    const double from = shaft[i].mouth ? shaft[i].s : i > 0 ? 0.5 * (shaft[i - 1].s + shaft[i].s) : 0;
    const double to = shaft[i].exit ? shaft[i].s : i + 1 < count ? 0.5 * (shaft[i].s + shaft[i + 1].s) : end;
    shaft[i].owned = shaft[i].supported = std::max(0.0, to - from);
  }
  if (!tip_supports || shaft.empty() || shaft.back().exit) return 0;
  ShaftPoint& last = shaft.back();
  const double left = (end - last.s) / 2;
  last.supported = std::max(0.0, last.supported - left);
  return left;
}

void share_tearing(std::span<ShaftPoint> shaft, TipPlace& tip, double end) {
  double length = tip.supported;
  for (const ShaftPoint& point : shaft) length += point.supported;
  const double share = length > 0 ? length / (length + end) : 0;
  for (ShaftPoint& point : shaft) point.tearing = share * point.supported;
  tip.tearing = share * (tip.supported + end);
}

void scale_owned_lengths(const InsertionView& at, const Path& path, const Insertion& state, std::span<ShaftPoint> shaft,
                         double end) {
  while (!shaft.empty()) {
    const auto exit = std::ranges::find_if(shaft, &ShaftPoint::exit);
    const Part part = shaft.first(std::min(shaft.size(), static_cast<std::size_t>(exit - shaft.begin()) + 1));
    shaft = shaft.subspan(part.size());
    if (part.back().exit) {
      scale_owned(part, part.back().advance);
    } else if (is_out(at, path, state)) {
      scale_owned(part, std::min(at.needle.model.length, state.end_s + exit_advance(at, path, state)) - end);
    } else {
      scale_owned(part, 0);
    }
  }
}

}  // namespace acus
