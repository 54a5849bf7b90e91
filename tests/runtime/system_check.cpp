// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/runtime/system_check.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "server/runtime/privileges.h"
#include "tests/support/temporary_folder.h"

namespace acus {
namespace {

// Files of a machine's settings.
class Machine {
 public:
  void set(const std::string& file, const std::string& text) {
    std::filesystem::create_directories(std::filesystem::path(folder_ / file).parent_path());
    folder_.write(file, text + "\n");
  }
  SystemSetting setting(const std::string& name, int priority = 49, LockedMemory locked = LockedMemory::all) const {
    const auto all = system_settings(folder_.path(), priority, locked);
    const auto found = std::ranges::find(all, name, &SystemSetting::name);
    REQUIRE(found != all.end());
    return *found;
  }

 private:
  TemporaryFolder folder_;
};

constexpr const char* kProcessors = "sys/devices/system/cpu/";

DelayHistogram delays(int prompt, int late, double by) {
  DelayHistogram histogram;
  for (int i = 0; i < prompt; ++i) histogram.add(20e-6);
  for (int i = 0; i < late; ++i) histogram.add(by);
  return histogram;
}

}  // namespace

TEST_CASE("what a system permits is told with what would be better") {
  Machine machine;
  CHECK(machine.setting("processors").remedy == "two or more");
  CHECK(machine.setting("frequency governor").found == "not told, as in a virtual machine");
  for (const std::string cpu : {"cpu0", "cpu1", "cpu10"})
    machine.set(kProcessors + cpu + "/cpufreq/scaling_governor", cpu == "cpu10" ? "powersave" : "performance");
  machine.set(std::string(kProcessors) + "cpufreq/policy0", "no processor");
  CHECK(machine.setting("processors").found == "3");
  CHECK(machine.setting("processors").remedy == "");
  CHECK(machine.setting("frequency governor").found == "powersave on 1 of 3 processors");
  CHECK(machine.setting("frequency governor").remedy == "cpupower frequency-set -g performance");
  machine.set(std::string(kProcessors) + "cpu10/cpufreq/scaling_governor", "performance");
  CHECK(machine.setting("frequency governor").remedy == "");

  const std::string idle = std::string(kProcessors) + "cpu0/cpuidle/state";
  for (const auto& [state, name, latency] : {std::tuple{"1", "C1", "2"}, {"2", "C6", "133"}}) {
    machine.set(idle + state + "/name", name);
    machine.set(idle + state + "/latency", latency);
    machine.set(idle + state + "/disable", "0");
  }
  CHECK(machine.setting("sleep of processors").found == "down to C6, 133 us to wake");
  CHECK(machine.setting("sleep of processors").remedy == "cpupower idle-set -D 50");
  machine.set(idle + "2/disable", "1");
  CHECK(machine.setting("sleep of processors").found == "down to C1, 2 us to wake");
  CHECK(machine.setting("sleep of processors").remedy == "");

  machine.set("proc/sys/kernel/sched_rt_runtime_us", "950000");
  machine.set("proc/sys/kernel/sched_rt_period_us", "1000000");
  CHECK(machine.setting("real-time threads").found == "stopped above 95 % of a processor");
  CHECK(machine.setting("real-time threads").remedy == "");
  machine.set("proc/sys/kernel/sched_rt_runtime_us", "500000");
  CHECK(machine.setting("real-time threads").remedy == "sysctl kernel.sched_rt_runtime_us=950000");

  CHECK(machine.setting("priority").found == "real-time, 49");
  CHECK(machine.setting("priority", 0).found == "ordinary");
  CHECK(machine.setting("priority", 20).remedy.find("rtprio") != std::string::npos);
  CHECK(machine.setting("memory", 49, LockedMemory::none).remedy.find("memlock") != std::string::npos);
}

TEST_CASE("the verdict on a system is that of its turns beside busy programs") {
  SystemCheck check;
  const auto verdict = [&](const DelayHistogram& beside) {
    check.beside = beside;
    return check.verdict();
  };
  CHECK(verdict(delays(9995, 5, 0.3e-3)) == SystemVerdict::fit);
  CHECK(verdict(delays(9995, 5, 0.6e-3)) == SystemVerdict::usable);
  CHECK(verdict(delays(9950, 50, 0.3e-3)) == SystemVerdict::usable);
  CHECK(verdict(delays(9950, 50, 2e-3)) == SystemVerdict::unfit);
}

TEST_CASE("a check of the system measures turns, can be stopped, and says the same in words and as JSON") {
  const SystemCheck stopped = check_system(10, 10, [] { return true; });
  CHECK(stopped.alone.count() == 0);
  CHECK(stopped.verdict() == SystemVerdict::unknown);
  CHECK(describe(stopped).starts_with("this system at 1000 Hz: unknown"));
  CHECK(describe(stopped).find("alone") == std::string::npos);
  CHECK(nlohmann::json::parse(as_json(stopped)).at("beside").at("max_ms").is_null());
  const SystemCheck check = check_system(0.05, 0.05, [] { return false; });
  lower_priority();
  CHECK(check.alone.count() > 0);
  CHECK(check.alone.count() <= 51);
  CHECK(check.beside.count() > 0);
  const std::string text = describe(check);
  CHECK(text.starts_with("this system at 1000 Hz: " + std::string(name_of(check.verdict()))));
  CHECK(text.find("  beside busy programs") != std::string::npos);
  const auto json = nlohmann::json::parse(as_json(check));
  CHECK(json.at("verdict") == name_of(check.verdict()));
  CHECK(json.at("alone").at("turns") == check.alone.count());
  CHECK(json.at("settings").size() == check.settings.size());
  CHECK(json.at("settings")[0].at("name") == "priority");
}

}  // namespace acus
