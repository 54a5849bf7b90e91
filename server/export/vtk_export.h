// SPDX-License-Identifier: GPL-3.0-or-later
// Frames of a run for ParaView, in a folder of their own. Four collections, each with a file a frame; lengths in
// metres, world frame:
//
//   tissue.pvd    tetrahedra where they are; vectors of nodes (m): displacement from rest, and dent, what the mesh
//                 lacks of it around needles (models/unresolved/dent.h); region (number in the scene)
//   needles.pvd   a line each, base to tip; depth (m), spin (rad), flags, phase (0 free, 1 contact, 2 inside,
//                 3 through)
//   paths.pvd     the walls of the paths that needles cut, a line each, mouth first
//   forces.pvd    points with a vector each (N), for a glyph filter: on the tip by the tissue (kind 0), on the holder
//                 by the needle (kind 1)
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "server/export/frame_clock.h"
#include "server/export/vtk_file.h"

namespace acus {

class VtkExport {
 public:
  // `rate` (Hz of simulation time) of the frames. Throws std::runtime_error unless the folder is empty or can be made.
  VtkExport(const std::string& folder, double rate);

  // After a tick: writes a frame if one is due.
  void take(const Rerun& rerun);

  // Writes the collections.
  void close() const;

 private:
  static constexpr std::array<const char*, 4> kNames{"tissue", "needles", "paths", "forces"};

  std::string next_file(int collection, double time);

  const std::filesystem::path folder_;
  FrameClock clock_;
  std::array<std::vector<VtkFrame>, kNames.size()> collections_;
};

}  // namespace acus
