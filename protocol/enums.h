// SPDX-License-Identifier: MIT
// What both sides of the wire know alike (protocol/README.md): enums, flags, their names, bounds of commands. An enum
// travels as the enumerator's name, flags as bits of one number.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace acus::protocol {

// What a command may say.
inline constexpr double kMaxPosition = 100;           // m, of a position along each axis of the world
inline constexpr double kMaxSpin = 1e6;               // rad
inline constexpr double kQuaternionTolerance = 1e-3;  // accepted error of a quaternion's length

// Why a message was rejected; travels as the enumerator's name.
enum class ErrorCode : std::uint8_t {
  truncated,            // ends in the middle of a value
  trailing_bytes,       // goes on after its map
  oversized,            // more bytes than a message may have
  too_complex,          // nested deeper, or more elements in one array or map, than any message needs
  invalid_msgpack,      // bytes that msgpack does not define, or a wrong number of frames
  not_a_map,            // a value, but no map
  wrong_version,        // `v` is not the protocol version spoken here
  unknown_type,         // `type` names no message
  missing_field,        // a field that must be there is not
  wrong_field_type,     // a field of another type or shape than the contract says
  not_finite,           // NaN or infinity
  not_unit_quaternion,  // length off 1 by more than kQuaternionTolerance
  bad_value,            // right type, outside the range
  unknown_needle,       // the scene has no needle or guide of that name
  wrong_mode,           // `step` in real time, or `pause` and `resume` in lockstep
  scene_error,          // `load`: the scene cannot be used; the old one goes on
  busy,                 // too many requests are waiting, or a scene is being loaded already; try again
  snapshot_error,       // `restore`: the snapshot cannot be used; nothing has changed
  held,                 // `acquire`: another client holds the needle or guide
  not_holder,           // only a client that holds the needle or guide may do this; `acquire` it first
  record_error,         // `record`: nothing can be recorded, or nothing is
  beyond_limit          // `pose`: farther from the base than the scene allows; it was clamped, or ignored
};
inline constexpr std::array<const char*, 22> kErrorCodeNames{"truncated",
                                                             "trailing_bytes",
                                                             "oversized",
                                                             "too_complex",
                                                             "invalid_msgpack",
                                                             "not_a_map",
                                                             "wrong_version",
                                                             "unknown_type",
                                                             "missing_field",
                                                             "wrong_field_type",
                                                             "not_finite",
                                                             "not_unit_quaternion",
                                                             "bad_value",
                                                             "unknown_needle",
                                                             "wrong_mode",
                                                             "scene_error",
                                                             "busy",
                                                             "snapshot_error",
                                                             "held",
                                                             "not_holder",
                                                             "record_error",
                                                             "beyond_limit"};

// Where a needle's tip is; travels as the enumerator's name.
enum class Phase : std::uint8_t {
  free,     // outside, touching nothing
  contact,  // on the surface, not through it
  inside,   // in the tissue
  through   // out again on another side, the shaft still inside
};
inline constexpr std::array<const char*, 4> kPhaseNames{"free", "contact", "inside", "through"};

// What happened to a needle; travels as the enumerator's name.
enum class EventKind : std::uint8_t {
  contact,     // the tip touched a surface, or inside the tissue a border between regions that holds it
  release,     // the tip left it without having gone through it
  puncture,    // the tip went through a surface and began a new path
  crossing,    // the tip went from one region into another, inside the tissue
  reentry,     // the tip went back into a path that was cut before, by either end
  exit,        // the tip came out on another side
  withdrawal,  // the tip came out backwards, through the mouth of its path
  intrusion,   // the tip was found in the tissue without having punctured it; a path was opened along its way
  tear,        // the shaft, or the tip, began to tear its path sideways
  hub,         // the hub came onto the surface
  slip         // the tip began to slide over a surface faster than its base led it, as off an edge
};
inline constexpr std::array<const char*, 11> kEventKindNames{
    "contact", "release", "puncture", "crossing", "reentry", "exit", "withdrawal", "intrusion", "tear", "hub", "slip"};

// What solved the laws of a tick; travels as the enumerator's name.
enum class LawSolver : std::uint8_t { gauss_seidel, direct };
inline constexpr std::array<const char*, 2> kLawSolverNames{"gauss_seidel", "direct"};

// Whether the server records; travels as the enumerator's name.
enum class RecordingState : std::uint8_t {
  off,
  on,
  failed  // it ended by itself: the file could not be written on, or not fast enough
};
inline constexpr std::array<const char*, 3> kRecordingStateNames{"off", "on", "failed"};

// What ends the motion of a base for which a local model holds; travels as the enumerator's name.
enum class ModelLimit : std::uint8_t {
  none,
  puncture,  // the tip gets through the surface that it presses
  cutting,   // the tip begins to cut, or stops cutting
  slip,      // a point begins to slip, or stops slipping
  contact    // something begins to touch, or ends touching
};
inline constexpr std::array<const char*, 5> kModelLimitNames{"none", "puncture", "cutting", "slip", "contact"};

constexpr const auto& names_of(ErrorCode) { return kErrorCodeNames; }
constexpr const auto& names_of(Phase) { return kPhaseNames; }
constexpr const auto& names_of(EventKind) { return kEventKindNames; }
constexpr const auto& names_of(LawSolver) { return kLawSolverNames; }
constexpr const auto& names_of(RecordingState) { return kRecordingStateNames; }
constexpr const auto& names_of(ModelLimit) { return kModelLimitNames; }

template <class Enum>
constexpr const char* name_of(Enum value) {
  return names_of(value)[static_cast<std::size_t>(value)];
}

// Bits of `flags` in states: trouble that a client should know of.
enum Flag : std::uint32_t {
  kLawsNotConverged = 1u << 0,    // the laws' residual is above the scene's tolerance
  kNewtonNotConverged = 1u << 1,  // the last change of tissue and needles is above the scene's tolerance
  kTangentProjected = 1u << 2,    // a needle is near buckling: a positive definite tangent stood in for its own
  kRowsDropped = 1u << 3,         // more constraint points than the capacity fixed at load
  kPathFull = 1u << 4,            // a path reached its capacity and stopped recording, or cannot go on behind air
  kNotFinite = 1u << 5,           // a number stopped being finite; the state was held at the last good tick
  kSolverFellBack = 1u << 6,      // the direct solver of the laws found no answer; Gauss-Seidel gave this one
  kStepsCapped = 1u << 7,         // ticks came late: the laws' solver stopped at the scene's overrun.max_steps
  kIterationsCapped = 1u << 8,    // likewise, iterations or repeats at overrun.max_iterations
  kPublishingReduced = 1u << 9,   // likewise, a shape that was due was left out, as overrun.publish_every says
  kStepLimited = 1u << 10,        // the tick's last step was cut, or still turned a needle far
  kElementsInverted = 1u << 11,   // the tissue is crushed: a tetrahedron is turned inside out
  kTipFoundInside = 1u << 12,     // a tip stood in the tissue without a path; one was opened along its way
  kForcesUnbalanced = 1u << 13,   // the forces of the tick before miss their balance by more than kMaxImbalance
  kShaftUnheld = 1u << 14,        // a shaft crosses tissue beside its path, which does not hold it
  kEnergyGained = 1u << 15,       // a needle holds more energy than was put into it: ticks cannot follow its motion
  kNeedleOverstrained =
      1u << 16,            // a needle is stretched or bent by more than 5 %, or another one pressed as far into it
  kBaseLimited = 1u << 17  // a base, or guide, goes at its speed limit, behind what it was told
};
inline constexpr std::array<const char*, 18> kFlagNames{
    "laws_not_converged", "newton_not_converged", "tangent_projected", "rows_dropped",      "path_full",
    "not_finite",         "solver_fell_back",     "steps_capped",      "iterations_capped", "publishing_reduced",
    "step_limited",       "elements_inverted",    "tip_found_inside",  "forces_unbalanced", "shaft_unheld",
    "energy_gained",      "needle_overstrained",  "base_limited"};

}  // namespace acus::protocol
