// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/runtime/system_check.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>
#include <utility>

#include "server/engine/scene/text/text_table.h"
#include "server/runtime/clock.h"
#include "server/runtime/deadline.h"
#include "server/runtime/privileges.h"

namespace acus {
namespace {

constexpr double kPeriod = 1 / kCheckRate;                           // s
constexpr double kPrompt = 0.1 * kPeriod, kTooLate = 0.5 * kPeriod;  // s, of a turn's beginning
constexpr double kMostOfTurns = 0.999;
constexpr std::uint64_t kLeastTurns = 2000;
constexpr double kLongestWaking = 50;      // us, of a processor that sleeps
constexpr double kMostStolen = 1e-3;       // of the time
constexpr std::size_t kTouched = 1 << 20;  // numbers that each busy thread goes through: more than a cache holds

// Keeps a processor and the memory busy, as an ordinary thread, until it goes.
class BusyThread {
 public:
  BusyThread() : thread_([this](const std::stop_token& stop) { work(stop); }) {}

 private:
  void work(const std::stop_token& stop) {
    lower_priority();
    std::vector<double> numbers(kTouched, 1.0);
    while (!stop.stop_requested())
      for (double& number : numbers) number = std::sqrt(number + 1);
    sum_ = numbers.front();
  }

  std::atomic<double> sum_ = 0;
  std::jthread thread_;
};

void run(double seconds, const std::function<bool()>& stop, DelayHistogram& delays) {
  const std::int64_t period = std::llround(kNanoseconds * kPeriod);
  std::int64_t due = monotonic_now() + period;
  const std::int64_t end = due + std::llround(kNanoseconds * seconds);
  while (due < end && !stop()) {
    sleep_until(due);
    const std::int64_t now = monotonic_now();
    const std::int64_t next = next_deadline(due, period, now).time;
    for (; due < next; due += period)
      delays.add(static_cast<double>(std::max<std::int64_t>(0, now - due)) / kNanoseconds);
  }
}

// The first line of a file; empty if it cannot be read.
std::string line_of(const std::filesystem::path& file) {
  std::string line;
  std::getline(std::ifstream(file), line);
  return line;
}

struct ProcessorTimes {
  double all = 0, stolen = 0;
};

// Since the system's start, in its own unit: user, nice, system, idle, iowait, irq, softirq, steal.
ProcessorTimes processor_times() {
  std::istringstream line(line_of("/proc/stat"));
  std::string name;
  line >> name;
  ProcessorTimes times;
  double value = 0;
  for (int i = 0; i < 8 && line >> value; ++i) {
    times.all += value;
    if (i == 7) times.stolen = value;
  }
  return times;
}

std::vector<std::filesystem::path> folders_like(const std::filesystem::path& parent, const std::string& begin) {
  std::vector<std::filesystem::path> found;
  std::error_code unknown;
  for (const auto& entry : std::filesystem::directory_iterator(parent, unknown)) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with(begin) && name.find_first_not_of("0123456789", begin.size()) == std::string::npos)
      found.push_back(entry.path());
  }
  std::ranges::sort(found);
  return found;
}

SystemSetting governor(const std::filesystem::path& processors) {
  int known = 0, slow = 0;
  std::string other;
  for (const auto& processor : folders_like(processors, "cpu")) {
    const std::string governor = line_of(processor / "cpufreq/scaling_governor");
    if (governor.empty()) continue;
    ++known;
    if (governor == "performance") continue;
    ++slow;
    other = governor;
  }
  if (known == 0) return {"frequency governor", "not told, as in a virtual machine", ""};
  if (slow == 0) return {"frequency governor", "performance", ""};
  return {"frequency governor", other + " on " + std::to_string(slow) + " of " + std::to_string(known) + " processors",
          "cpupower frequency-set -g performance"};
}

SystemSetting sleep_states(const std::filesystem::path& processors) {
  double longest = 0;
  std::string name;
  for (const auto& state : folders_like(processors / "cpu0/cpuidle", "state")) {
    const double latency = std::atof(line_of(state / "latency").c_str());
    if (line_of(state / "disable") == "1" || latency <= longest) continue;
    longest = latency;
    name = line_of(state / "name");
  }
  if (name.empty()) return {"sleep of processors", "not told, as in a virtual machine", ""};
  return {"sleep of processors", "down to " + name + ", " + five_digits(longest) + " us to wake",
          longest > kLongestWaking ? "cpupower idle-set -D " + five_digits(kLongestWaking) : ""};
}

SystemSetting throttling(const std::filesystem::path& kernel) {
  const std::string runtime = line_of(kernel / "sched_rt_runtime_us"), period = line_of(kernel / "sched_rt_period_us");
  if (runtime.empty()) return {"real-time threads", "not told", ""};
  if (runtime == "-1") return {"real-time threads", "not limited", ""};
  const double share = 100 * std::atof(runtime.c_str()) / std::max(1.0, std::atof(period.c_str()));
  return {"real-time threads", "stopped above " + five_digits(share) + " % of a processor",
          share < 90 ? "sysctl kernel.sched_rt_runtime_us=950000" : ""};
}

SystemSetting memory(LockedMemory locked) {
  if (locked == LockedMemory::all) return {"memory", "locked", ""};
  return {"memory", locked == LockedMemory::present ? "locked, but for what comes later" : "not locked",
          "limit memlock unlimited: /etc/security/limits.d, LimitMEMLOCK=infinity"};
}

nlohmann::json to_json(const DelayHistogram& delays) {
  const auto ms = [&](double seconds) {
    return delays.count() > 0 ? nlohmann::json(1e3 * seconds) : nlohmann::json(nullptr);
  };
  return {{"turns", delays.count()},
          {"p50_ms", ms(delays.quantile(0.5))},
          {"p99_ms", ms(delays.quantile(0.99))},
          {"p999_ms", ms(delays.quantile(0.999))},
          {"max_ms", ms(delays.max())}};
}

}  // namespace

const char* name_of(SystemVerdict verdict) {
  switch (verdict) {
    case SystemVerdict::fit:
      return "fit";
    case SystemVerdict::usable:
      return "usable";
    case SystemVerdict::unknown:
      return "unknown";
    default:
      return "unfit";
  }
}

SystemVerdict SystemCheck::verdict() const {
  if (beside.count() < kLeastTurns) return SystemVerdict::unknown;
  const double most = beside.quantile(kMostOfTurns);
  if (most <= kPrompt && beside.max() <= kTooLate) return SystemVerdict::fit;
  return most <= kTooLate ? SystemVerdict::usable : SystemVerdict::unfit;
}

std::vector<SystemSetting> system_settings(const std::filesystem::path& root, int priority, LockedMemory locked) {
  const std::filesystem::path processors = root / "sys/devices/system/cpu", kernel = root / "proc/sys/kernel";
  const std::size_t count = folders_like(processors, "cpu").size();
  std::vector<SystemSetting> settings;
  settings.push_back(
      {"priority", priority > 0 ? "real-time, " + std::to_string(priority) : "ordinary",
       priority >= kSimulationPriority ? "" : "limit rtprio of 49: /etc/security/limits.d, LimitRTPRIO=49"});
  settings.push_back(memory(locked));
  settings.push_back({"processors", std::to_string(count), count < 2 ? "two or more" : ""});
  settings.push_back(governor(processors));
  settings.push_back(sleep_states(processors));
  settings.push_back(throttling(kernel));
  return settings;
}

SystemCheck check_system(double alone, double beside, const std::function<bool()>& stop) {
  SystemCheck check;
  const LockedMemory locked = lock_memory();
  raise_priority(RealtimeThread::simulation);
  const ProcessorTimes before = processor_times();
  run(alone, stop, check.alone);
  {
    std::vector<std::unique_ptr<BusyThread>> others(std::max(1u, std::thread::hardware_concurrency()));
    for (auto& other : others) other = std::make_unique<BusyThread>();
    run(beside, stop, check.beside);
  }
  const ProcessorTimes after = processor_times();
  check.settings = system_settings("/", real_time_priority(), locked);
  if (after.all > before.all) check.stolen = (after.stolen - before.stolen) / (after.all - before.all);
  check.settings.push_back({"time taken by the host", five_digits(100 * check.stolen) + " %",
                            check.stolen > kMostStolen ? "processors that no other machine shares" : ""});
  const bool late = check.verdict() == SystemVerdict::usable || check.verdict() == SystemVerdict::unfit;
  if (late && std::ranges::all_of(check.settings, &std::string::empty, &SystemSetting::remedy))
    check.settings.push_back(
        {"other causes", "nothing above explains it",
         "end other programs with real-time priority; firmware and hosts can hold processors, too"});
  return check;
}

std::string describe(const SystemCheck& check) {
  std::string text = "this system at 1000 Hz: " + std::string(name_of(check.verdict()));
  switch (check.verdict()) {
    case SystemVerdict::fit:
      text += ", ticks begin in time\n";
      break;
    case SystemVerdict::usable:
      text += ", few ticks begin late\n";
      break;
    case SystemVerdict::unknown:
      text += ", it was ended before there were enough turns\n";
      break;
    default:
      text += ", ticks begin late again and again\n";
  }
  TextTable delays;
  delays.add({"a turn begins late by (ms)", "p50", "p99", "p99.9", "max"});
  for (const auto& [name, of] : {std::pair{"  alone", &check.alone}, {"  beside busy programs", &check.beside}}) {
    if (of->count() == 0) continue;
    delays.add({name, five_digits(1e3 * of->quantile(0.5)), five_digits(1e3 * of->quantile(0.99)),
                five_digits(1e3 * of->quantile(0.999)), five_digits(1e3 * of->max())});
  }
  TextTable settings;
  settings.add({"what the system permits", "", "better"});
  for (const SystemSetting& setting : check.settings)
    settings.add({"  " + setting.name, setting.found, setting.remedy});
  return text + '\n' + delays.text() + '\n' + settings.text();
}

std::string as_json(const SystemCheck& check) {
  nlohmann::json settings = nlohmann::json::array();
  for (const SystemSetting& setting : check.settings)
    settings.push_back({{"name", setting.name}, {"found", setting.found}, {"remedy", setting.remedy}});
  const nlohmann::json all{
      {"verdict", name_of(check.verdict())}, {"rate", kCheckRate},     {"alone", to_json(check.alone)},
      {"beside", to_json(check.beside)},     {"stolen", check.stolen}, {"settings", settings}};
  return all.dump(2) + '\n';
}

}  // namespace acus
