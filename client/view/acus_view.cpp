// SPDX-License-Identifier: MIT
// acus-view: shows a server in a browser, and lets a mouse hold its needle.
#include <sys/resource.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <boost/asio/signal_set.hpp>
#include <charconv>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "client/link/command_line.h"
#include "client/link/program.h"
#include "client/view/door.h"
#include "client/view/film.h"
#include "client/view/redirecting_file.h"
#include "client/view/started_server.h"
#include "protocol/messages.h"

namespace {

namespace asio = boost::asio;
using namespace acus;

enum ExitCode : int { kEnded = 0, kBadCommandLine = 1, kNoServer = 2, kCannotListen = 3, kFailed = 4 };

constexpr const char* kDescription =
    "Shows a running simulation in a browser: tissue, needles, forces; whoever opens the page may take a needle in "
    "hand. "
    "With SCENE it starts a server of its own, which ends with it; without, it shows one that runs already. SCENE may "
    "be "
    "a recording, which is shown with a time line, and gone on with from any moment.";
constexpr const char* kFooter =
    "Examples:\n"
    "  acus-view insertion_pullback        an installed scene, or a file, with a server of its own\n"
    "  acus-view liver.yaml --cloud 8      with the tips of eight worlds that differ a little\n"
    "  acus-view run.acus                  a recording, of acus-server --record or of the page\n"
    "  acus-view run.acus --export run.mp4 the recording as a film\n"
    "  acus-view                           the server at the default endpoints\n"
    "  acus-view --commands ipc:///run/acus/liver/commands --states ipc:///run/acus/liver/states\n"
    "\nThe page is for this machine alone, and for those who know its URL. From another machine: ssh -L "
    "8080:127.0.0.1:PORT.\n"
    "\nExit status: 0 ended by SIGINT or SIGTERM; 1 bad command line; 2 the server that it started has ended, or the "
    "recording cannot be used; 3 the "
    "port "
    "is not free, or the page's files are missing; 4 anything else, as an export that did not end.";

constexpr const char* kNoServerProgram = ": there is no acus-server beside this program";

struct Arguments {
  std::string scene, page = view::page_folder();
  std::string commands = protocol::kDefaultCommandsEndpoint, states = protocol::kDefaultStatesEndpoint;
  client::KeyFiles keys;
  unsigned short port = 0;
  bool no_browser = false, lockstep = false, play = false;
  std::string cloud;       // as check_cloud() takes it
  view::FilmOptions film;  // no target: none
};

// A number of worlds, or where a cloud is published already.
std::optional<int> worlds_of(const std::string& cloud) {
  int worlds = 0;
  const auto [end, error] = std::from_chars(cloud.data(), cloud.data() + cloud.size(), worlds);
  if (error != std::errc() || end != cloud.data() + cloud.size()) return {};
  return worlds;
}

std::string check_cloud(const std::string& cloud) {
  const std::optional<int> worlds = worlds_of(cloud);
  if (!worlds) return client::check_endpoint(cloud);
  return *worlds >= 2 && *worlds <= 1000 ? "" : "expected 2 to 1000 worlds, or an endpoint";
}

std::optional<view::CloudOptions> cloud_of(const Arguments& arguments) {
  if (arguments.cloud.empty()) return {};
  if (const std::optional<int> worlds = worlds_of(arguments.cloud))
    return view::CloudOptions{*worlds, "", arguments.scene};
  return view::CloudOptions{0, arguments.cloud, ""};
}

void declare(CLI::App& app, Arguments& arguments) {
  app.footer(kFooter);
  app.set_version_flag("--version", ACUS_VERSION);
  const auto scene =
      app.add_option("SCENE", arguments.scene, "Scene to start a server with, as for acus-server, or a recording");
  app.add_option("--commands", arguments.commands, "Commands endpoint of a server that runs already")
      ->check(client::check_endpoint)
      ->capture_default_str()
      ->excludes(scene);
  app.add_option("--states", arguments.states, "States endpoint of that server")
      ->check(client::check_endpoint)
      ->capture_default_str()
      ->excludes(scene);
  client::declare_keys(app, arguments.keys);
  app.add_option("--port", arguments.port, "Port of this machine to serve the page on")
      ->default_str("any that is free");
  app.add_option("--page", arguments.page, "Folder with the files of the page")->capture_default_str();
  app.add_flag("--lockstep", arguments.lockstep, "The server that is started makes ticks only when the page asks")
      ->needs(scene);
  app.add_flag("--play", arguments.play,
               "Play the motion that is made for the scene, to and fro until somebody takes the needle, once the page "
               "is open")
      ->needs(scene);
  app.add_option("--cloud", arguments.cloud,
                 "Draw where the tip may be if tissue and needle are a little other than in the scene: of so many "
                 "worlds, with an acus-cloud of its own, or of one that publishes there")
      ->type_name("WORLDS|ENDPOINT")
      ->check(check_cloud);
  CLI::Option* film = app.add_option("--export", arguments.film.target,
                                     "Show nothing: make pictures of the recording into a folder, or a film if the "
                                     "name ends in .mp4, .webm or .mkv, and end. Needs chromium, films ffmpeg too")
                          ->type_name("FOLDER|FILE")
                          ->check([](const std::string& target) { return target.empty() ? "expected a name" : ""; })
                          ->needs(scene);
  app.add_option("--rate", arguments.film.rate, "Pictures a second of simulation time, for --export")
      ->needs(film)
      ->check(client::within(0.1, 240))
      ->capture_default_str();
  app.add_option("--size", arguments.film.size, "Width and height of these pictures, in pixels")
      ->needs(film)
      ->check(CLI::Range(200, 4000))
      ->capture_default_str();
  app.add_flag("--no-browser", arguments.no_browser, "Print the URL and open nothing");
}

// Where there is a desktop. The program that opens it is not waited for; it gets a file that leads to the URL, whose
// token is nobody else's to see.
void open_browser(const std::string& url, std::optional<view::RedirectingFile>& file) {
  if (std::getenv("DISPLAY") == nullptr && std::getenv("WAYLAND_DISPLAY") == nullptr) return;
  file.emplace(url);
  const std::string command = "xdg-open '" + file->path() + "' >/dev/null 2>&1 &";
  if (std::system(command.c_str()) != 0) std::fprintf(stderr, "acus-view: no program opened the page; open its URL\n");
}

std::vector<std::string> options_to_server(const Arguments& arguments, const view::ServerAddress& server) {
  std::vector<std::string> options{"--commands", server.commands, "--states", server.states};
  if (!arguments.keys.server.empty())
    options.insert(options.end(),
                   {"--curve-server-key", arguments.keys.server, "--curve-client-key", arguments.keys.client});
  return options;
}

// What is wrong with SCENE; empty if nothing is.
std::string problem_with(const Arguments& arguments) {
  if (arguments.scene.empty()) return "";
  if (!arguments.film.target.empty()) {
    if (!std::filesystem::exists(arguments.scene)) return "there is no such file";
    if (!client::is_recording(arguments.scene))
      return "--export is for recordings, and this is none; record a run first (acus-server --record)";
    if (const std::string problem = view::problem_with(arguments.film); !problem.empty())
      return "--export " + arguments.film.target + ": " + problem;
  }
  if (client::is_recording(arguments.scene))
    return arguments.play || arguments.lockstep || !arguments.cloud.empty()
               ? "--play, --lockstep and --cloud are for scenes, and this is a recording"
               : "";
  return view::look_around(arguments.scene).path.empty()
             ? "expected the file of a scene or a recording, or the name of an installed scene"
             : "";
}

// Makes the film while the context runs, which it ends.
class Filming {
 public:
  Filming(asio::io_context& context, const std::string& url, const view::FilmOptions& options)
      : thread_([this, &context, url, options](const std::stop_token& stop) {
          try {
            make_film(
                url, options, [this](int done, int all) { tell_progress(done, all); }, stop);
            done_ = true;
          } catch (const std::exception& error) {
            if (!stop.stop_requested())
              std::fprintf(stderr, "%sacus-view: --export: %s\n", begun_ ? "\n" : "", error.what());
          }
          context.stop();
        }) {}

  // Ends it where it is.
  bool end() {
    thread_.request_stop();
    thread_.join();
    return done_;
  }

 private:
  void tell_progress(int done, int all) {
    const bool terminal = isatty(STDERR_FILENO) != 0;
    begun_ = terminal && done < all;
    if (terminal) std::fprintf(stderr, "\rpicture %d of %d%s", done, all, done == all ? "\n" : "");
    if (!terminal && done == all) std::fprintf(stderr, "%d pictures\n", all);
  }

  bool begun_ = false;  // a line of progress stands unfinished
  bool done_ = false;
  std::jthread thread_;
};

int run(const Arguments& arguments) {
  if (const std::string problem = problem_with(arguments); !problem.empty()) {
    std::fprintf(stderr, "acus-view: %s: %s\n", arguments.scene.c_str(), problem.c_str());
    return kBadCommandLine;
  }
  asio::io_context context(1);
  asio::signal_set signals(context, SIGINT, SIGTERM, SIGHUP);
  bool interrupted = false;
  signals.async_wait([&](const boost::system::error_code&, int) {
    interrupted = true;
    context.stop();
  });

  view::Gateway::Options options;
  try {
    options.page = view::read_page(arguments.page);
  } catch (const std::runtime_error& error) {
    std::fprintf(stderr, "acus-view: %s\n", error.what());
    return kCannotListen;
  }
  bool gone = false;
  std::optional<view::StartedServer> server;
  options.server = {arguments.commands, arguments.states, client::read_keys(arguments.keys)};
  if (client::is_recording(arguments.scene)) {
    options.run = arguments.scene;
    options.run_is_unusable = [&](int status) {
      std::fprintf(stderr, "acus-view: %s cannot be shown: acus-export has ended with status %d\n",
                   arguments.scene.c_str(), status);
      gone = true;
      context.stop();
    };
  } else if (!arguments.scene.empty()) {
    server.emplace(context, arguments.scene,
                   arguments.lockstep ? std::vector<std::string>{"--lockstep"} : std::vector<std::string>{},
                   [&](int status) {
                     std::fprintf(stderr, "acus-view: the server has ended with status %d%s\n", status,
                                  status == view::ChildProgram::kNoProgram ? kNoServerProgram : "");
                     gone = true;
                     context.stop();
                   });
    options.server = server->address();
    options.recordings = server->folder();
    options.scenes = view::look_around(arguments.scene);
    if (arguments.play)
      options.first_motion = motion_for(options.scenes, std::filesystem::path(arguments.scene).stem().string());
  }
  options.to_server = options_to_server(arguments, options.server);
  options.cloud = cloud_of(arguments);
  setpriority(PRIO_PROCESS, 0, 5);  // ticks come first
  std::optional<view::Door> door;
  try {
    door.emplace(context, arguments.port);
  } catch (const boost::system::system_error& error) {
    std::fprintf(stderr, "acus-view: port %d: %s\n", arguments.port, error.what());
    return kCannotListen;
  }
  view::Gateway gateway(context, std::move(options));
  door->open(gateway);
  const std::string url = door->url(gateway);
  if (!arguments.film.target.empty()) {
    Filming filming(context, url, arguments.film);
    context.run();
    if (filming.end()) return kEnded;
    if (interrupted)
      std::fputs("acus-view: --export: interrupted; a film that is not whole is removed, pictures stay\n", stderr);
    return gone ? kNoServer : kFailed;
  }
  std::printf("%s\n", url.c_str());
  std::fflush(stdout);
  std::optional<view::RedirectingFile> opened;
  if (!arguments.no_browser) open_browser(url, opened);

  context.run();
  return gone ? kNoServer : kEnded;
}

}  // namespace

int main(int argc, char** argv) {
  Arguments arguments;
  CLI::App app(kDescription, "acus-view");
  declare(app, arguments);
  return client::run_program(
      app, argc, argv, [&] { return run(arguments); },
      [](const std::exception& error) {
        return dynamic_cast<const protocol::KeyError*>(&error) != nullptr ? kBadCommandLine : kFailed;
      });
}
