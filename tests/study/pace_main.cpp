// SPDX-License-Identifier: GPL-3.0-or-later
// acus-pace: a bare control loop at a rate, with a load but without Acus, under the priority that acus-server gives its
// simulation. What is late here, too, is the system's doing. For tests/study/soak, which runs it beside a server.
#include <poll.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "server/runtime/clock.h"
#include "server/runtime/deadline.h"
#include "server/runtime/delay_histogram.h"
#include "server/runtime/privileges.h"
#include "server/runtime/termination.h"

namespace {

using namespace acus;

constexpr std::size_t kNumbers = 400'000;  // read again and again: 3.2 MB, as large as the factor of 1,000 nodes
constexpr std::size_t kBetweenLooks = 2'000;

struct Arguments {
  double rate = 1000;    // Hz
  double work = 0.5;     // ms of processor time in each turn
  double duration = 60;  // s
  std::string summary;
};

struct Punctuality {
  std::uint64_t turns = 0, late = 0;
  DelayHistogram began, ended;  // after a turn was due
};

double seconds(std::int64_t nanoseconds) { return static_cast<double>(nanoseconds) / kNanoseconds; }

bool readable(int file) {
  pollfd item{file, POLLIN, 0};
  return poll(&item, 1, 0) == 1;
}

// Reads memory until the thread has worked for so long (ns of processor time).
class Load {
 public:
  void work(std::int64_t time) {
    const std::int64_t until = processor_now() + time;
    while (processor_now() < until) {
      for (std::size_t i = 0; i < kBetweenLooks; ++i) sum_ += numbers_[at_ + i];
      at_ = (at_ + kBetweenLooks) % kNumbers;
    }
  }
  double sum() const { return sum_; }  // so that nothing is left out

 private:
  std::vector<double> numbers_ = std::vector<double>(kNumbers, 1.0);
  std::size_t at_ = 0;
  double sum_ = 0;
};

// Until the duration is over or a signal has come. Late is a turn that ends after the next one is due, which is left
// out then, as a tick is.
Punctuality run(const Arguments& arguments, const Termination& termination, Load& load) {
  const std::int64_t period = std::llround(kNanoseconds / arguments.rate), work = std::llround(1e6 * arguments.work);
  Punctuality punctuality;
  std::int64_t due = monotonic_now();
  const std::int64_t end = due + std::llround(kNanoseconds * arguments.duration);
  while (due < end && !readable(termination.file())) {
    sleep_until(due);
    punctuality.began.add(seconds(monotonic_now() - due));
    load.work(work);
    const std::int64_t ended = monotonic_now();
    punctuality.ended.add(seconds(ended - due));
    const Deadline next = next_deadline(due, period, ended);
    ++punctuality.turns;
    punctuality.late += next.skipped > 0 ? 1 : 0;
    due = next.time;
  }
  return punctuality;
}

double late_per_1000(const Punctuality& punctuality) {
  return punctuality.turns > 0 ? 1e3 * static_cast<double>(punctuality.late) / static_cast<double>(punctuality.turns)
                               : 0;
}

void print(const char* what, const DelayHistogram& delays) {
  std::printf("a turn %s after it was due: p50 %.3f ms, p99 %.3f, p99.99 %.3f, max %.3f ms\n", what,
              1e3 * delays.quantile(0.5), 1e3 * delays.quantile(0.99), 1e3 * delays.quantile(0.9999),
              1e3 * delays.max());
}

nlohmann::json to_json(const DelayHistogram& delays) {
  return {{"p50_ms", 1e3 * delays.quantile(0.5)},
          {"p99_ms", 1e3 * delays.quantile(0.99)},
          {"p9999_ms", 1e3 * delays.quantile(0.9999)},
          {"max_ms", 1e3 * delays.max()}};
}

void write_summary(const std::string& path, const Arguments& arguments, const Punctuality& punctuality) {
  const nlohmann::json summary{{"rate", arguments.rate},
                               {"work_ms", arguments.work},
                               {"turns", punctuality.turns},
                               {"late_per_1000", late_per_1000(punctuality)},
                               {"began", to_json(punctuality.began)},
                               {"ended", to_json(punctuality.ended)}};
  std::ofstream file(path);
  file << summary.dump(2) << '\n';
  if (!file.flush()) throw std::runtime_error("cannot write '" + path + "'");
}

void declare(CLI::App& app, Arguments& arguments) {
  app.add_option("--rate", arguments.rate, "turns a second (Hz)")->check(CLI::Range(1.0, 1e5))->capture_default_str();
  app.add_option("--work", arguments.work, "processor time of each turn (ms)")
      ->check(CLI::Range(0.0, 1e3))
      ->capture_default_str();
  app.add_option("--duration", arguments.duration, "(s); SIGINT and SIGTERM end it sooner")
      ->check(CLI::Range(0.1, 1e6))
      ->capture_default_str();
  app.add_option("--summary", arguments.summary, "write the results to this file as JSON, too");
}

}  // namespace

int main(int argc, char** argv) try {
  Arguments arguments;
  CLI::App app("A control loop with a load and nothing else: tells how punctual this system lets one be.", "acus-pace");
  declare(app, arguments);
  CLI11_PARSE(app, argc, argv);
  const Termination termination;
  Load load;
  lock_memory();
  raise_priority(RealtimeThread::simulation);
  const Punctuality punctuality = run(arguments, termination, load);
  print("began", punctuality.began);
  print("ended", punctuality.ended);
  std::printf("%llu of %llu turns were late, %.3f in 1,000\n", static_cast<unsigned long long>(punctuality.late),
              static_cast<unsigned long long>(punctuality.turns), late_per_1000(punctuality));
  if (!arguments.summary.empty()) write_summary(arguments.summary, arguments, punctuality);
  return load.sum() < 0 ? 3 : 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "acus-pace: %s\n", error.what());
  return 3;
}
