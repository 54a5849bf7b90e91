// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/export/shapes_export.h"

#include "server/runtime/convert.h"
#include "server/runtime/loaded_scene.h"

namespace acus {

ShapesExport::ShapesExport(const std::string& path, const Rerun& rerun)
    : log_(path),
      world_(rerun.worlds()),
      needle_ticks_(ticks_between(rerun.simulation().scene().rate, rerun.simulation().scene().publish.needle_rate)),
      tissue_ticks_(ticks_between(rerun.simulation().scene().rate, rerun.simulation().scene().publish.tissue_rate)),
      shapes_(rerun) {
  log_.begin(hello_of(rerun), describe_of(rerun));
}

void ShapesExport::take(const Rerun& rerun) {
  if (rerun.worlds() != world_) return;
  const Simulation& simulation = rerun.simulation();
  const std::uint64_t tick = simulation.report().tick;
  for (int i = 0; tick % needle_ticks_ == 0 && i < needle_count(rerun); ++i) log_.write(shapes_.needle(rerun, i));
  if (tick % tissue_ticks_ != 0) return;
  write_guides(simulation);
  log_.write(shapes_.tissue(rerun));
}

// Where they are, as states do not tell it.
void ShapesExport::write_guides(const Simulation& simulation) {
  for (std::size_t i = 0; i < simulation.scene().guides.size(); ++i) {
    const BaseState& motion = simulation.state().guides[i].motion;
    protocol::Pose pose;
    pose.needle = simulation.scene().guides[i].name;
    pose.position = to_wire(motion.pose.position);
    pose.orientation = to_wire(motion.pose.orientation);
    log_.write(pose);
  }
}

}  // namespace acus
