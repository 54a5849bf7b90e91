// SPDX-License-Identifier: GPL-3.0-or-later
// Whether this system lets a loop run on time: how late one of 1 kHz is woken, with the priority and the locked memory
// that acus-server has, first alone and then beside programs that keep all processors busy; and what could be set
// otherwise.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "server/runtime/delay_histogram.h"
#include "server/runtime/privileges.h"

namespace acus {

inline constexpr double kCheckRate = 1000;  // Hz
inline constexpr double kAloneSeconds = 3;  // s, of each part
inline constexpr double kBesideSeconds = 7;

// Something that the system permits or not.
struct SystemSetting {
  std::string name;
  std::string found;
  std::string remedy;  // empty if it is well
};

enum class SystemVerdict { unknown, fit, usable, unfit };
const char* name_of(SystemVerdict verdict);

struct SystemCheck {
  DelayHistogram alone, beside;  // after a turn was due, it began; one that was left out: until the next one did
  double stolen = 0;             // share of the time that the host took from the processors
  std::vector<SystemSetting> settings;

  // Of the turns beside busy programs; fit: 99.9 % begin within a tenth of the period, and all within the half; usable:
  // 99.9 % within the half; unknown: they are too few.
  SystemVerdict verdict() const;
};

// Takes `alone` and `beside` seconds. `stop` is asked at every turn; what was measured until then is returned.
SystemCheck check_system(double alone, double beside, const std::function<bool()>& stop);

// What is set in the files below `root`, and of the process itself: priority and memory as they were granted.
std::vector<SystemSetting> system_settings(const std::filesystem::path& root, int priority, LockedMemory locked);

std::string describe(const SystemCheck& check);
std::string as_json(const SystemCheck& check);

}  // namespace acus
