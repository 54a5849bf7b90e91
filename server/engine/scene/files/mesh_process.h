// SPDX-License-Identifier: GPL-3.0-or-later
// Mesh files are read by a program of its own, acus-mesh: what a damaged file makes of its reader ends there. The program
// gets the opened file and limits, none of this process's descriptors and signals, and never a real-time priority.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include "server/engine/mesh_files/mesh_answer.h"

namespace acus {

class SceneFolders;

struct MeshReadingLimits {
  std::uint64_t file_bytes = std::uint64_t{1} << 30;    // size of the mesh file
  std::uint64_t memory_bytes = std::uint64_t{8} << 30;  // address space of acus-mesh
  std::uint64_t processor_seconds = 60;
  std::uint64_t answer_bytes = kMaxAnswerBytes;
  std::chrono::milliseconds time{300'000};  // from start to the complete answer, on the wall's clock
};

// acus-mesh stands beside the running program, unless use_mesh_program() has said where it is.
std::string mesh_program_path();
// Before scenes are loaded: for a process whose program is not of Acus, as Python's interpreter.
void use_mesh_program(const std::string& path);

// The answer of `program`, which reads a mesh file, for decode_mesh_answer(). Of TetGen's two files either may be named.
// Safe in a process with several threads. When it returns or throws, the program has ended. With `allowed`, the file
// must lie in these folders. Throws MeshError, or SceneError for a file outside.
std::vector<char> run_mesh_program(const std::string& program, const std::string& mesh_path,
                                   const MeshReadingLimits& limits, const SceneFolders* allowed = nullptr);

}  // namespace acus
