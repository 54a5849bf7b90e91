// SPDX-License-Identifier: MIT
// acus-haptic: a haptic device, or a simulated one, on a needle of an acus-server.
#include <CLI/CLI.hpp>
#include <atomic>
#include <charconv>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <exception>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "client/haptics/program/haptic_summary.h"
#include "client/haptics/program/obedient_device.h"
#include "client/haptics/program/opened.h"
#include "client/haptics/program/pupil.h"
#include "client/haptics/program/sample_rows.h"
#include "client/haptics/program/session.h"
#include "client/haptics/program/share_input.h"
#include "client/haptics/program/verification.h"
#include "client/link/command_line.h"
#include "client/link/program.h"
#include "client/replay/log_file.h"
#include "protocol/own_file.h"

namespace {

using namespace acus::haptics;
namespace client = acus::client;

constexpr int kDevice = 4;  // and those of client/link/program.h

constexpr const char* kFooter =
    "Examples:\n"
    "  acus-haptic --duration 10                                  # a simulated device and hand, a server on this "
    "machine\n"
    "  acus-haptic --device inverse3 --verify                     # axes, signs, unit, rate and force of the device\n"
    "  acus-haptic --device gamepad ipc:///run/acus/liver\n"
    "  acus-haptic --grip firm --rate 4000 --record run.csv --summary run.json --duration 20\n"
    "\n"
    "Ctrl+C ends a session well. Exit status: 0 done, 1 bad arguments or files, 2 the server refused, 3 the server, "
    "the\n"
    "teacher or the pupil was not there or vanished, 4 the device is not there, failed, or is not as it should be, 5 "
    "the\n"
    "server speaks another protocol, 6 a check was interrupted.";

struct Arguments {
  SessionOptions session;
  std::string server, grip = "relaxed", axes = "x,y,z", summary, record;
  bool verify = false;
  std::string join;
  std::atomic<double> share{0.5};
  client::KeyFiles keys;
  double timeout_s = 10;
};

std::vector<std::string> grip_names() {
  std::vector<std::string> names;
  for (const Grip& grip : kGrips) names.emplace_back(grip.name);
  return names;
}

void declare_device(CLI::App& app, Arguments& arguments) {
  DeviceChoice& device = arguments.session.device;
  app.add_option("--device", device.name, "which one; this build has those listed")
      ->check(CLI::IsMember(device_names()))
      ->capture_default_str();
  app.add_option("--rate", device.rate, "samples per second (Hz)")
      ->check(client::within(10.0, 20'000.0))
      ->capture_default_str();
  app.add_option("--scale", arguments.session.kit.workspace.scale, "way of the needle over way of the device")
      ->check(client::within(1e-3, 1e3))
      ->capture_default_str();
  app.add_option("--force-scale", arguments.session.kit.workspace.force_scale,
                 "force at the device over force at the needle")
      ->check(client::within(1e-3, 1e3))
      ->capture_default_str();
  app.add_option(
         "--axes", arguments.axes,
         "of the device: those that point ahead, to the left and up, as in y,-x,z (--axes=-y,x,z where the first "
         "is negative)")
      ->capture_default_str();
  app.add_flag("--verify", arguments.verify,
               "check the device, without a server: asks for six motions, then pushes the handle gently; status 4 if "
               "something is wrong");
  TransientShape& transient = arguments.session.kit.transient;
  app.add_option("--transient", transient.height, "N, of a short force at punctures, releases and crossings; 0: none")
      ->check(client::within(0.0, 10.0))
      ->capture_default_str();
  app.add_option("--transient-length", transient.length, "s, that it takes")
      ->check(client::within(1e-3, 0.5))
      ->capture_default_str();
  app.add_option("--fast", arguments.session.kit.fast, "m/s, of the device: while it moves faster,")
      ->check(client::within(1e-3, 100.0))
      ->capture_default_str();
  app.add_option("--fast-force", arguments.session.kit.fast_force, "N, is the most that is felt")
      ->check(client::within(0.0, 1000.0))
      ->capture_default_str();
  app.add_option("--address", device.address, "of Haply's Inverse Service")->capture_default_str();
  app.add_option("--grip", arguments.grip, "of the simulated hand")
      ->check(CLI::IsMember(grip_names()))
      ->capture_default_str();
  app.add_option("--hand-depth", device.motion.depth, "m that the simulated hand goes in")
      ->check(client::within(1e-4, 0.5))
      ->capture_default_str();
  app.add_option("--hand-speed", device.motion.speed, "m/s, of the simulated hand")
      ->check(client::within(1e-4, 1.0))
      ->capture_default_str();
  app.add_option("--mass", device.simulated.axis.mass, "kg, of the simulated device")
      ->check(client::within(0.01, 10.0))
      ->capture_default_str();
  app.add_option("--damping", device.simulated.axis.damping, "N s/m, of the simulated device")
      ->check(client::within(0.01, 100.0))
      ->capture_default_str();
  app.add_option("--device-delay", device.simulated.delay.delay,
                 "s, of the simulated device, from a force to its effect")
      ->check(client::within(0.0, 0.1))
      ->capture_default_str();
  app.add_option("--device-jitter", device.simulated.delay.jitter, "s, up to so much more")
      ->check(client::within(0.0, 0.1))
      ->capture_default_str();
}

void declare_network(CLI::App& app, Arguments& arguments) {
  SessionOptions& session = arguments.session;
  app.add_option("--delay", session.network.delay, "s, of a simulated network, both ways together")
      ->check(client::within(0.0, 0.2))
      ->capture_default_str();
  app.add_option("--jitter", session.network.jitter, "s, up to so much more, both ways together")
      ->check(client::within(0.0, 0.2))
      ->capture_default_str();
  app.add_option("--loss", session.network.loss, "share of messages that it loses, each way")
      ->check(client::within(0.0, 0.9))
      ->capture_default_str();
  app.add_flag("!--no-kit", session.with_kit,
               "render the server's newest force as it is, for comparison; unstable in stiff tissue");
}

void declare_sharing(CLI::App& app, Arguments& arguments) {
  SharingOptions& sharing = arguments.session.sharing;
  const auto share = app.add_option("--share", sharing.endpoint,
                                    "share the needle with a second hand that joins here: ipc://FILE or "
                                    "tcp://127.0.0.1:PORT");
  app.add_option_function<double>(
         "--share-of", [&](double value) { arguments.share = value; },
         "of this hand, 0 to 1; while it runs, each number on standard input is another one")
      ->check(client::within(0.0, 1.0))
      ->needs(share)
      ->default_str("0.5");
  app.add_option("--join", arguments.join, "join the needle that another acus-haptic shares there, without a server")
      ->excludes(share);
  app.add_option("--spring", sharing.hand.stiffness, "N/m, between two hands on a needle")
      ->check(client::within(0.0, 1e5))
      ->capture_default_str();
}

void declare(CLI::App& app, Arguments& arguments) {
  app.footer(kFooter);
  app.set_version_flag("--version", ACUS_VERSION);
  SessionOptions& session = arguments.session;
  const auto server = app.add_option(
      "server", arguments.server,
      "HOST or HOST:PORT, tcp:// before it or not, with the port for commands, the next one being that for "
      "states; or ipc://FOLDER with the sockets commands and states. Without it, the default ports of this "
      "machine");
  app.add_option("--commands", session.commands, "the server's endpoint for commands")
      ->check(client::check_endpoint)
      ->excludes(server)
      ->capture_default_str();
  app.add_option("--states", session.states, "the server's endpoint for states")
      ->check(client::check_endpoint)
      ->excludes(server)
      ->capture_default_str();
  client::declare_keys(app, arguments.keys);
  app.add_option("--needle", session.needle, "by its name; default: the scene's first");
  declare_device(app, arguments);
  declare_network(app, arguments);
  declare_sharing(app, arguments);
  app.add_option("--duration", session.duration, "s; 0: until Ctrl+C")
      ->check(client::within(0, 1e9))
      ->capture_default_str();
  app.add_option("--timeout", arguments.timeout_s, "to wait for the server (s)")
      ->check(client::within(0.001, 86'400.0))
      ->capture_default_str();
  app.add_option("--summary", arguments.summary, "file to write with what is printed at the end, as JSON");
  app.add_option("--record", arguments.record, "CSV to write, a row per sample");
}

// The port for commands, that with the next one fits into 16 bits. Throws std::runtime_error.
int port_of(const std::string& text, const std::string& server) {
  int port = 0;
  const char* end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data(), end, port);
  if (error == std::errc() && rest == end && port >= 1 && port <= 65534) return port;
  throw std::runtime_error("server '" + server + "': expected a port of 1 to 65534 after the last colon, found '" +
                           text + "'");
}

// The endpoints that SERVER names. Throws std::runtime_error.
void take_server(Arguments& arguments) {
  const std::string& server = arguments.server;
  if (server.empty()) return;
  SessionOptions& session = arguments.session;
  if (server.rfind("ipc://", 0) == 0) {
    session.commands = server + "/commands";
    session.states = server + "/states";
  } else {
    const std::string address = server.rfind("tcp://", 0) == 0 ? server.substr(6) : server;
    if (address.find("://") != std::string::npos)
      throw std::runtime_error("server '" + server + "': expected HOST, HOST:PORT, tcp://HOST:PORT or ipc://FOLDER");
    const auto colon = address.rfind(':');
    const std::string host = address.substr(0, colon);
    const int port = colon == std::string::npos ? 5750 : port_of(address.substr(colon + 1), server);
    session.commands = "tcp://" + host + ":" + std::to_string(port);
    session.states = "tcp://" + host + ":" + std::to_string(port + 1);
  }
  for (const std::string& endpoint : {session.commands, session.states})
    if (const std::string problem = client::check_endpoint(endpoint); !problem.empty())
      throw std::runtime_error(problem);
}

// Of a device and of a link; throws others on.
int status_of(const std::exception& error) {
  if (dynamic_cast<const DeviceError*>(&error) != nullptr) return kDevice;
  if (const std::optional<int> status = client::status_of_link(error)) return *status;
  throw;
}

// Checks the device in real time, without a server.
int verify(const Arguments& arguments) {
  using Clock = std::chrono::steady_clock;
  const auto begin = Clock::now();
  DeviceChoice choice = arguments.session.device;
  choice.clock = [begin] { return std::chrono::duration<double>(Clock::now() - begin).count(); };
  std::unique_ptr<Device> device;
  ObedientDevice* obedient = nullptr;
  if (choice.name == "simulated") {
    auto made =
        std::make_unique<ObedientDevice>(choice.simulated, told_of(choice.simulated, choice.rate), choice.clock);
    obedient = made.get();
    device = std::move(made);
  } else {
    device = make_device(choice);
  }
  const auto work = [&] {
    const Opened opened(*device);
    const DeviceProperties properties = device->open();
    Verification verification(
        *device, properties, arguments.session.kit.workspace.world_from_device,
        {choice.clock,
         [begin](double until) { std::this_thread::sleep_until(begin + std::chrono::duration<double>(until)); }},
        std::cout, arguments.session.interrupt);
    if (obedient) verification.on_request = [obedient](const Vector3& way) { obedient->request(way); };
    const std::optional<bool> good = verification.run();
    if (!good) return client::kInterrupted;
    return *good ? client::kDone : kDevice;
  };
  return client::told_status("acus-haptic", work, status_of);
}

// Runs; how it ended, as an exit code.
template <class Session>
int run(Session& session) {
  const auto work = [&] {
    session.run();
    return client::kDone;
  };
  return client::told_status("acus-haptic", work, status_of);
}

// Joins the needle that another acus-haptic shares.
int join(const Arguments& arguments) {
  const SessionOptions& session = arguments.session;
  PupilOptions options;
  options.endpoint = arguments.join;
  options.device = session.device;
  options.turned = session.kit.workspace.world_from_device;
  options.hand = session.sharing.hand;
  options.network = session.network;
  options.duration = session.duration;
  options.timeout = session.timeout;
  options.interrupt = session.interrupt;
  std::optional<client::LogFile> record;
  if (!arguments.record.empty()) record.emplace(arguments.record, kPupilHeader);
  Pupil pupil(options);
  if (record) pupil.on_sample = [&](const PupilSample& sample) { write(record->out(), sample); };
  const int code = run(pupil);
  if (record) record->close();
  if (pupil.samples() > 0)
    std::printf(
        "joined      %llu samples in %.2f s\n"
        "force       %.3f N at most\n"
        "energy      %.6f J kept from the hand by the controller; the force did %.6f J of work on the handle, net\n",
        static_cast<unsigned long long>(pupil.samples()), pupil.duration(), pupil.largest_force(), pupil.withheld(),
        pupil.given());
  return code;
}

// Options that would be without effect. Throws std::runtime_error.
void refuse_mixtures(const Arguments& arguments) {
  const SessionOptions& session = arguments.session;
  const auto refuse = [](bool given, const char* what) {
    if (given) throw std::runtime_error(what);
  };
  const bool shares = !session.sharing.endpoint.empty(), joins = !arguments.join.empty();
  refuse(arguments.verify && (shares || joins), "--verify: checks a device alone; leave out --share and --join");
  refuse((arguments.verify || joins) && !arguments.server.empty(),
         "--verify, --join: need no server; leave out the server");
  refuse((arguments.verify || joins) && !arguments.summary.empty(), "--verify, --join: make no --summary");
  refuse(arguments.verify && !arguments.record.empty(), "--verify: makes no --record");
  refuse((arguments.verify || joins || shares) && !session.with_kit,
         "--verify, --share, --join: work with the kit; leave out --no-kit");
}

int drive(Arguments& arguments) {
  refuse_mixtures(arguments);
  take_server(arguments);
  SessionOptions& options = arguments.session;
  options.timeout = std::chrono::round<client::Timeout>(std::chrono::duration<double>(arguments.timeout_s));
  for (const Grip& grip : kGrips)
    if (arguments.grip == grip.name) options.device.simulated.hand = grip.hand;
  options.kit.workspace.world_from_device = rotation_of_axes(arguments.axes);
  options.interrupt = &client::catch_signals();  // a signal ends the session, not the program
  if (arguments.verify) return verify(arguments);
  if (!arguments.join.empty()) return join(arguments);
  std::optional<ShareInput> input;
  if (!options.sharing.endpoint.empty()) {
    options.sharing.share = &arguments.share;
    input.emplace(arguments.share);
  }
  options.keys = client::read_keys(arguments.keys);
  std::optional<client::LogFile> summary, record;
  if (!arguments.summary.empty()) summary.emplace(arguments.summary, acus::protocol::json_of_acus());
  if (!arguments.record.empty()) record.emplace(arguments.record, kSampleHeader);

  Session session(options);
  if (record) session.on_sample = [&](const SampleRecord& sample) { write(record->out(), sample); };
  session.on_pupil = [](bool there) {
    std::fputs(there ? "acus-haptic: a pupil has joined\n" : "acus-haptic: the pupil is gone; its share comes back\n",
               stderr);
  };
  const int code = run(session);
  if (session.results().samples > 0) {
    std::fputs(readable(session.results(), options.device.name).c_str(), stdout);
    std::fflush(stdout);
    if (session.results().rest.differs())
      std::fputs(
          "acus-haptic: warning: at rest the felt force is not the server's; the tissue is stiffer than the device may "
          "render, the device too weak, or messages come too late\n",
          stderr);
    if (summary) summary->out() << as_json(session.results(), options.device.name);
  }
  if (summary) summary->close();
  if (record) record->close();
  return code;
}

}  // namespace

int main(int argc, char** argv) {
  std::signal(SIGPIPE, SIG_IGN);
  CLI::App app("Puts a haptic device, or a simulated one, on a needle of an acus-server.", "acus-haptic");
  Arguments arguments;
  declare(app, arguments);
  return client::run_program(app, argc, argv, [&] { return drive(arguments); });
}
