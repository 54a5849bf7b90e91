// SPDX-License-Identifier: GPL-3.0-or-later
// acus-server: loads a scene, simulates it on one thread and serves it on another.
#include <fcntl.h>
#include <pthread.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <optional>
#include <system_error>
#include <thread>

#include "protocol/endpoint_address.h"
#include "protocol/key_file.h"
#include "protocol/printable.h"
#include "server/engine/math/kernel_set.h"
#include "server/engine/recording/recording_file.h"
#include "server/engine/scene/files/installed_scenes.h"
#include "server/engine/scene/scene_fields.h"
#include "server/engine/scene/scene_json.h"
#include "server/engine/scene/scene_reference.h"
#include "server/engine/state/bytes/snapshot.h"
#include "server/runtime/log.h"
#include "server/runtime/privileges.h"
#include "server/runtime/realtime_loop.h"
#include "server/runtime/recorded_start.h"
#include "server/runtime/rehearsal.h"
#include "server/runtime/scene_summary.h"
#include "server/runtime/service_manager.h"
#include "server/runtime/system_check.h"
#include "server/runtime/termination.h"
#include "server/transport/endpoint.h"
#include "server/transport/listening.h"
#include "server/transport/snapshot_file.h"

namespace {

using namespace acus;

enum ExitCode : int {
  kEnded = 0,
  kBadCommandLine = 1,
  kBadScene = 2,
  kCannotListen = 3,
  kFailed = 4,
  kCannotRecord = 5,
  kUnfitSystem = 6,
};

constexpr const char* kDescription =
    "Simulates needles in soft tissue in real time and serves them over ZeroMQ.\n"
    "Clients send needle poses to one socket and subscribe to forces and shapes on another; protocol/README.md is the "
    "contract. Both sockets listen on this machine only unless told otherwise; elsewhere only with keys or --insecure.";
constexpr const char* kFooter =
    "Examples:\n"
    "  acus-server scenes/insertion_pullback.yaml            run until Ctrl-C\n"
    "  acus-server insertion_pullback                        likewise, the installed scene of that name\n"
    "  acus-server SCENE --check                             see whether the scene can be used, what it costs and "
    "leaves out\n"
    "  acus-server SCENE --lockstep                          ticks run when a client asks: for replays and tests\n"
    "  acus-server --schema                                  the JSON Schema of scene files, for editors\n"
    "  acus-server --check-system                            see whether this system lets ticks run on time\n"
    "  acus-server RUN --at 12.5                             go on from there in what --record RUN wrote\n"
    "  acus-server SCENE --commands ipc:///run/acus/commands --states ipc:///run/acus/states\n"
    "\nExit status: 0 ended by SIGINT, SIGTERM, SIGHUP, a client's shutdown, or --ticks; 1 bad command line; 2 the "
    "scene, "
    "recording or snapshot cannot be used;\n3 an endpoint cannot be listened on; 4 anything else, as what is printed "
    "cannot be written; 5 the recording or snapshots cannot be written; 6 --check-system found that ticks would be late, "
    "or was ended. Log lines go to standard error.";

struct Arguments {
  std::string scene;
  EndpointOptions endpoint;
  LoopOptions loop;
  LogOptions log;
  std::string restore;
  std::optional<double> at;                     // s
  std::string curve_server_key, curve_clients;  // files
  bool check = false;
  bool json = false;
  bool check_system = false;
};

// The status of a program all of whose result is what it prints: `status`, unless that went nowhere.
int printed(int status) {
  errno = 0;
  if (std::cout.flush() && std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return status;
  spdlog::error("standard output cannot be written to{}{}; what is printed is not whole", errno == 0 ? "" : ": ",
                errno == 0 ? "" : std::strerror(errno));
  return kFailed;
}

// A file that is opened later would take the number of a standard output that is closed, and what is printed.
void keep_closed_output() {
  if (fcntl(STDOUT_FILENO, F_GETFD) != -1) return;
  const int full = open("/dev/full", O_WRONLY);
  if (full > STDOUT_FILENO) dup2(full, STDOUT_FILENO), close(full);
}

void print_schema() {
  std::cout << scene_schema();
  throw CLI::Success();
}

void print_tables() {
  for (const FieldTable& table : scene_tables()) std::cout << "### " << table.title << "\n\n" << table.markdown << '\n';
  throw CLI::Success();
}

int print_json(const std::string& scene) {
  try {
    std::cout << scene_as_json(read_scene(scene)) << std::endl;
    return printed(kEnded);
  } catch (const SceneError& error) {
    std::cerr << protocol::printable(error.what()) << std::endl;
    return kBadScene;
  }
}

int print_system_check(bool json) {
  const Termination termination;
  if (!json)
    std::cout << "measures for " << kAloneSeconds + kBesideSeconds << " s; Ctrl-C ends it sooner\n" << std::flush;
  const SystemCheck check = check_system(kAloneSeconds, kBesideSeconds, [&] { return termination.asked(); });
  std::cout << (json ? as_json(check) : describe(check)) << std::flush;
  const SystemVerdict verdict = check.verdict();
  return printed(verdict == SystemVerdict::fit || verdict == SystemVerdict::usable ? kEnded : kUnfitSystem);
}

// The same as of a scene's field.
CLI::Validator rate_in_range() {
  const auto check = [](const std::string& text) {
    double rate = 0;
    if (CLI::detail::lexical_cast(text, rate) && kRate.contains(rate)) return std::string();
    return "expected a number " + describe(kRate) + " (Hz), found " + text;
  };
  return {check, "[" + format_number(kRate.min) + " - " + format_number(kRate.max) + "]", "rate"};
}

std::string check_moment(const std::string& text) {
  double seconds = 0;
  if (CLI::detail::lexical_cast(text, seconds) && seconds >= 0 && std::isfinite(seconds)) return "";
  return "expected a number of seconds, at least 0, found " + text;
}

std::string check_named(const std::string& file) { return file.empty() ? "expected the name of a file" : ""; }

std::string check_endpoint(const std::string& endpoint) {
  const std::string problem = protocol::problem_with_endpoint(endpoint, protocol::EndpointUse::listen);
  return problem.empty() ? problem : "endpoint '" + endpoint + "': " + problem;
}

void check_distinct(const EndpointOptions& endpoint) {
  if (endpoint.commands != endpoint.states || protocol::is_wildcard_endpoint(endpoint.commands)) return;
  throw CLI::ValidationError("--commands and --states", "both are '" + endpoint.commands + "'; give each its own");
}

void declare(CLI::App& app, Arguments& arguments) {
  app.footer(kFooter);
  app.set_version_flag("--version", ACUS_VERSION);
  CLI::Option* scene = app.add_option(
      "SCENE", arguments.scene,
      "Scene file (YAML; scenes/README.md describes the format), or the name of a scene in /etc/acus or of an "
      "installed one; or a recording, to run it again and go on from its end");
  scene->required();
  app.add_option("--commands", arguments.endpoint.commands, "ZeroMQ endpoint for commands (ROUTER)")
      ->check(check_endpoint)
      ->capture_default_str();
  app.add_option("--states", arguments.endpoint.states, "ZeroMQ endpoint for states (XPUB)")
      ->check(check_endpoint)
      ->capture_default_str();
  app.callback([&arguments] { check_distinct(arguments.endpoint); });
  CLI::Option* key = app.add_option("--curve-server-key", arguments.curve_server_key,
                                    "The server's key pair: admit only clients of --curve-clients, and encrypt (CURVE)")
                         ->type_name("FILE");
  CLI::Option* clients = app.add_option("--curve-clients", arguments.curve_clients,
                                        "Public keys of the clients to admit, their files one after the other")
                             ->type_name("FILE");
  key->needs(clients);
  clients->needs(key);
  app.add_flag("--insecure", arguments.endpoint.admission.insecure,
               "Listen where other machines can connect, without keys: whoever does can command the needles")
      ->excludes(key);
  app.add_option("--rate", arguments.endpoint.rate, "Ticks per second instead of every scene's own (Hz)")
      ->check(rate_in_range());
  app.add_option("--ticks", arguments.loop.max_ticks, "End after so many ticks")
      ->check(CLI::PositiveNumber)
      ->default_str("unlimited");
  app.add_flag("--lockstep", arguments.loop.lockstep, "Run ticks only when a client's 'step' asks for them");
  app.add_flag("--paused", arguments.loop.paused, "Begin paused: no tick runs until a client's 'resume'")
      ->excludes("--lockstep");
  app.add_option("--scenes", arguments.endpoint.folders,
                 "Folder that clients may load scenes and meshes from, with all below it; may be given again")
      ->type_name("FOLDER")
      ->check(CLI::ExistingDirectory)
      ->default_str("that of SCENE");
  app.add_option("--restore", arguments.restore,
                 "Go on from a snapshot of this scene, in a file: the bytes of a client's 'snapshot'")
      ->type_name("FILE")
      ->check(check_named);
  app.add_option("--at", arguments.at,
                 "Go on from so many seconds of simulation time after the beginning of the recording that SCENE is")
      ->type_name("SECONDS")
      ->check(check_moment)
      ->default_str("its end");
  app.add_option(
         "--snapshot", arguments.endpoint.snapshot,
         "File for the snapshots that a scene asks for (publish.snapshot_every), the newest in place of the one "
         "before; --restore goes on from it")
      ->type_name("FILE")
      ->check(check_named);
  app.add_option("--record", arguments.endpoint.record,
                 "Record the run from its first tick into a new file, which acus-export runs again")
      ->type_name("FILE")
      ->check(check_named);
  app.add_option("--recordings", arguments.endpoint.recordings,
                 "Folder that clients may record into; without it they may not")
      ->type_name("FOLDER")
      ->check(CLI::ExistingDirectory);
  app.add_option("--log-level", arguments.log.level, "Least level of the lines in the log")
      ->type_name("LEVEL")
      ->transform(CLI::CheckedTransformer(kLogLevels).description("trace, debug, info, warn, error or off"))
      ->default_str("info");
  app.add_option("--log-format", arguments.log.format, "Lines for people, or a JSON object a line")
      ->type_name("FORMAT")
      ->transform(CLI::CheckedTransformer(kLogFormats).description("text or json"))
      ->default_str("text");
  CLI::Option* check =
      app.add_flag("--check", arguments.check,
                   "Load the scene, print what it contains, what it costs and what it leaves out, push its needles in "
                   "to print how long ticks take on this machine, and exit");
  app.add_flag("--json", arguments.json,
               "Check the scene file, but for its mesh, print what it says as JSON, and exit; with --check-system, its "
               "results as JSON")
      ->excludes(check);
  const auto check_system_alone = [&arguments, scene] {
    arguments.check_system = true;
    scene->required(false);
  };
  app.add_flag_callback("--check-system", check_system_alone,
                        "Measure for 10 s whether this system lets a loop of 1 kHz run on time, alone and beside busy "
                        "programs, print what could be set otherwise, and exit; needs no SCENE")
      ->trigger_on_parse()
      ->excludes(check);
  app.add_flag_callback("--schema", print_schema, "Print the JSON Schema of scene files, and exit")->trigger_on_parse();
  app.add_flag_callback("--tables", print_tables, "Print the tables of their fields in Markdown, and exit")
      ->trigger_on_parse();
}

// Runs the loop on its own thread, and ends it when it goes out of scope.
class SimulationThread {
 public:
  SimulationThread(RealtimeLoop& loop, Link& link, bool real_time)
      : link_(link), thread_([&loop, real_time] {
          pthread_setname_np(pthread_self(), "acus-simulation");
          if (real_time) raise_priority(RealtimeThread::simulation);
          loop.run();
        }) {}
  ~SimulationThread() {
    link_.stop.store(true, std::memory_order_relaxed);
    link_.to_simulation.signal();
    thread_.join();
  }

 private:
  Link& link_;
  std::thread thread_;
};

void report(const char* what, const DelayHistogram& delays) {
  spdlog::info("{} after it was due: p50 {:.3f} ms, p90 {:.3f}, p99 {:.3f}, p99.9 {:.3f}, p99.99 {:.3f}, max {:.3f} ms",
               what, 1e3 * delays.quantile(0.5), 1e3 * delays.quantile(0.9), 1e3 * delays.quantile(0.99),
               1e3 * delays.quantile(0.999), 1e3 * delays.quantile(0.9999), 1e3 * delays.max());
}

void report(const Punctuality& punctuality) {
  const std::uint64_t ticks = punctuality.ended.count();
  if (ticks == 0) return;
  report("a tick began", punctuality.woke);
  report("a tick ended", punctuality.ended);
  spdlog::info("{} ticks were late, {:.3f} in 1,000; in {} something gave way under `overrun`", punctuality.late,
               1e3 * static_cast<double>(punctuality.late) / static_cast<double>(ticks), punctuality.economized);
}

// Signs of life come from the socket thread, on behalf of the simulation thread: neither can hang unnoticed.
void serve_and_tell(Endpoint& endpoint, const Link& link, const Termination& termination) {
  ServiceManager manager(ServiceManager::address_from_environment());
  manager.ready(endpoint.standing());
  endpoint.run(termination.file(), manager.period(), [&] {
    const auto now = ServiceManager::Clock::now();
    if (manager.due(now)) manager.keep_informed(now, link.turns.load(std::memory_order_relaxed), endpoint.standing());
  });
  manager.stopping();
}

void serve(Endpoint& endpoint, std::unique_ptr<LoadedScene> world, const Arguments& arguments, Link& link,
           const Termination& termination) {
  const LoopOptions& options = arguments.loop;
  const Admission& admission = arguments.endpoint.admission;
  spdlog::info("{}", endpoint.standing());
  spdlog::info("commands on {}", endpoint.commands_endpoint());
  spdlog::info("states on {}", endpoint.states_endpoint());
  if (admission.curve) spdlog::info("admits {} clients by their keys, and encrypts", admission.curve->clients.size());
  if (admission.insecure) spdlog::warn("--insecure: whoever can connect is admitted, and nothing is encrypted");
  if (world->simulation.scene().publish.snapshot_every && arguments.endpoint.snapshot.empty())
    spdlog::warn("the scene asks for snapshots (publish.snapshot_every), but there is no --snapshot FILE for them");
  RealtimeLoop loop(std::move(world), options, link);
  {
    const SimulationThread thread(loop, link, !options.lockstep);
    serve_and_tell(endpoint, link, termination);
  }
  spdlog::info("ended after {} ticks, {} deadlines skipped, {} states dropped, {} messages rejected", loop.ticks(),
               link.overruns.load(), endpoint.dropped(), endpoint.rejected());
  if (!options.lockstep) report(loop.punctuality());
}

// Throws std::runtime_error that names the file.
void restore(const std::string& file, Simulation& simulation) {
  if (std::filesystem::exists(file) && !std::filesystem::is_regular_file(file))
    throw std::runtime_error("--restore " + file + ": it is no file; give one that --snapshot has written");
  std::ifstream stream(file, std::ios::binary);
  std::vector<char> bytes{std::istreambuf_iterator<char>(stream), {}};
  if (!stream) throw std::runtime_error("--restore " + file + ": the file cannot be read");
  try {
    simulation.restore(read_snapshot(simulation.model(), std::as_bytes(std::span(bytes))));
  } catch (const SnapshotError& error) {
    throw std::runtime_error("--restore " + file + ": " + error.what());
  }
  spdlog::info("goes on from tick {}, {} s", simulation.report().tick, simulation.report().time);
}

// Throws KeyError.
void read_keys(Arguments& arguments) {
  if (arguments.curve_server_key.empty()) return;
  arguments.endpoint.admission.curve = CurveServer{protocol::read_key_pair(arguments.curve_server_key),
                                                   protocol::read_public_keys(arguments.curve_clients)};
}

// Why there can be no snapshots in the file; empty if there can.
std::string problem_with_snapshots(const std::string& file, const std::string& record) {
  std::error_code error;
  const std::filesystem::path path = std::filesystem::absolute(file, error).lexically_normal();
  const std::string option = "--snapshot " + file + ": ";
  if (!record.empty() && path == std::filesystem::absolute(record, error).lexically_normal())
    return option + "--record names the same file; give each its own";
  if (access(path.parent_path().c_str(), W_OK) != 0)
    return option + "no file can be made in its folder (" + std::strerror(errno) + ")";
  const std::string problem = SnapshotFile::problem_with(file);
  return problem.empty() ? "" : "--snapshot " + problem;
}

// What does not go together, depending on what SCENE is; empty if all does.
std::string problem_with(const Arguments& arguments) {
  const std::string& scene = arguments.scene;
  if (arguments.check_system)
    return scene.empty() ? "" : "--check-system measures the system, and needs no SCENE; leave " + scene + " out";
  if (const std::string& snapshot = arguments.endpoint.snapshot; !snapshot.empty()) {
    if (const std::string problem = problem_with_snapshots(snapshot, arguments.endpoint.record); !problem.empty())
      return problem;
  }
  const bool recording = is_recording(scene);
  if (arguments.at && !recording)
    return "--at is for recordings, and " + scene + " is none; give one as SCENE, or leave --at out";
  if (!recording) return "";
  if (arguments.json) return "--json is for scene files, and " + scene + " is a recording";
  if (!arguments.restore.empty())
    return "--restore is for scene files, and " + scene +
           " is a recording; leave --restore out, and give the moment with --at";
  if (arguments.endpoint.rate)
    return "--rate is for scene files, and " + scene + " is a recording, which runs at its own rate; leave --rate out";
  return "";
}

// Beside threads that nothing can stop: without destroying what they use.
[[noreturn]] void exit_at_once(int status) {
  spdlog::shutdown();
  std::fflush(nullptr);
  std::_Exit(status);
}

// Null if it was interrupted. Throws std::runtime_error.
std::unique_ptr<LoadedScene> load(const Arguments& arguments, const Termination& termination) {
  if (is_recording(arguments.scene))
    return load_recorded({arguments.scene, arguments.at}, [&] { return termination.asked(); });
  const SignalWatch watch(termination, [] {
    spdlog::info("ended while the scene was loaded");
    exit_at_once(kEnded);
  });
  std::unique_ptr<LoadedScene> world = load_scene(read_scene(arguments.scene), arguments.endpoint.rate);
  if (!arguments.restore.empty()) restore(arguments.restore, world->simulation);
  return world;
}

int run(const Arguments& arguments) {
  const Termination termination;
  try {
    spdlog::info("kernels for {}", name_of(kernel_set()));
  } catch (const std::runtime_error& error) {
    spdlog::error("{}", error.what());
    return kBadCommandLine;
  }
  std::unique_ptr<LoadedScene> world;
  try {
    world = load(arguments, termination);
  } catch (const std::runtime_error& error) {
    spdlog::error("{}", error.what());
    return kBadScene;
  }
  if (!world) {
    spdlog::info("ended while the recording was run again");
    return kEnded;
  }
  if (arguments.check) {
    const Rehearsal rehearsal = rehearse(world->simulation);
    const double time_step = world->hello.time_step;
    const auto warnings = rehearsal_warnings(rehearsal, time_step, window_to_try(world->simulation));
    const std::string told = summarise(world->simulation, warnings) + "\n" + describe(rehearsal, time_step);
    std::cout << protocol::printable(told, protocol::Newlines::kept);
    return printed(kEnded);
  }
  if (!arguments.loop.lockstep) {
    lock_memory();
    raise_priority(RealtimeThread::sockets);  // before ZeroMQ starts its own thread
  }
  raise_connection_limit();  // before the endpoint looks how many there may be
  Link link;
  std::optional<Endpoint> endpoint;
  try {
    endpoint.emplace(*world, arguments.endpoint, link);
  } catch (const CannotListen& error) {
    spdlog::error("{}", error.what());
    return kCannotListen;
  } catch (const RecordingError& error) {
    spdlog::error("--record {}", error.what());
    return kCannotRecord;
  } catch (const NotLocked& error) {
    spdlog::error("--snapshot {}", error.what());
    return kCannotRecord;
  }
  serve(*endpoint, std::move(world), arguments, link, termination);
  const bool failed = !endpoint->finish_recording() && !arguments.endpoint.record.empty();
  const ExitCode status = failed ? kCannotRecord : kEnded;
  const bool leaves_thread = endpoint->leaves_thread();
  endpoint.reset();
  if (leaves_thread) exit_at_once(status);
  return status;
}

}  // namespace

int main(int argc, char** argv) {
  keep_closed_output();
  begin_log({});  // for what goes wrong before the options are known
  Arguments arguments;
  CLI::App app(kDescription, "acus-server");
  declare(app, arguments);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? printed(kEnded) : kBadCommandLine;
  }
  begin_log(arguments.log);
  arguments.scene = find_scene(arguments.scene, installed_scene_folders());
  if (const std::string problem = problem_with(arguments); !problem.empty()) {
    spdlog::error("{}", problem);
    return kBadCommandLine;
  }
  if (arguments.check_system) return print_system_check(arguments.json);
  if (arguments.json) return print_json(arguments.scene);
  arguments.endpoint.lockstep = arguments.loop.lockstep;
  arguments.endpoint.paused = arguments.loop.paused;
  if (arguments.endpoint.folders.empty())
    arguments.endpoint.folders = {std::filesystem::path(arguments.scene).parent_path().string()};
  try {
    read_keys(arguments);
    return run(arguments);
  } catch (const protocol::KeyError& error) {
    spdlog::error("{}", error.what());
    return kBadCommandLine;
  } catch (const std::exception& error) {
    spdlog::error("{}", error.what());
    return kFailed;
  }
}
