// SPDX-License-Identifier: GPL-3.0-or-later
// The shapes of a run as acus-replay --shapes writes them, for client/picture and the Python package.
#pragma once

#include <string>

#include "client/replay/shape_log.h"
#include "server/export/recorded_states.h"

namespace acus {

class ShapesExport {
 public:
  // Of the scene that the rerun is in.
  ShapesExport(const std::string& path, const Rerun& rerun);

  // After a tick: writes the shapes that the server publishes after it. Those of other scenes, to which the recording
  // goes over by `load`, have no place in the file and are left out.
  void take(const Rerun& rerun);

  void close() { log_.close(); }

 private:
  void write_guides(const Simulation& simulation);

  client::ShapeLog log_;
  const int world_;
  const std::uint64_t needle_ticks_, tissue_ticks_;  // between two shapes
  RecordedShapes shapes_;
};

}  // namespace acus
