// SPDX-License-Identifier: GPL-3.0-or-later
// Where servers may listen, and what they say if they cannot.
#include <doctest/doctest.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>

#include "tests/integration/printed.h"
#include "tests/integration/raw_peer.h"
#include "tests/support/file_content.h"
#include "tests/support/places.h"

namespace acus::testing {
namespace {

constexpr int kEnded = 0, kBadCommandLine = 1, kCannotListen = 3;

// A folder with a scene, and servers that are started in it.
struct Place {
  TemporaryFolder folder;
  std::string scene = folder.write("scene.yaml", small_scene("small"));

  std::vector<std::string> server(const std::string& commands, const std::string& states) const {
    return {program_path("acus-server"), scene, "--commands", commands, "--states", states};
  }
  std::string ipc(const std::string& name) const { return "ipc://" + (folder / name); }
};

// Starts a server that cannot listen, and checks how it ends and that it says each of these.
void check_refusal(const std::vector<std::string>& argv, int status, const std::vector<std::string>& said) {
  Printed server(argv);
  REQUIRE(server.process().wait(kPatience) == status);
  const std::string text = server.read_all();
  for (const std::string& part : said) {
    CAPTURE(text);
    CAPTURE(part);
    CHECK(text.find(part) != std::string::npos);
  }
}

void check_serves(const std::string& commands) {
  client::CommandLink link(commands);
  CHECK(link.hello(kPatience).scene == "small");
}

// Where a server says that its states are; empty if it does not.
std::string line_about_states(Printed& server) {
  std::string line = server.read_line();
  while (!line.empty() && line.find("states on ") == std::string::npos) line = server.read_line();
  return line;
}

}  // namespace

TEST_CASE("a file that is no socket is not replaced") {
  const Place place;
  const std::string path = place.folder.write("precious", "kept");
  std::filesystem::create_directory(place.folder / "folder");
  std::filesystem::create_symlink(path, place.folder / "link");
  for (const std::string name : {"precious", "folder", "link"}) {
    check_refusal(place.server(place.ipc(name), place.ipc("states")), kCannotListen,
                  {"--commands", place.folder / name, "exists and is no socket; remove it"});
    check_refusal(place.server(place.ipc("commands"), place.ipc(name)), kCannotListen,
                  {"--states", place.folder / name, "exists and is no socket; remove it"});
  }
  CHECK(content_of(path) == "kept");
  CHECK(std::filesystem::is_symlink(place.folder / "link"));
}

TEST_CASE("another server's sockets are not taken over, in each transport") {
  ServerProcess running;
  check_serves(running.commands());
  const Place place;
  check_refusal(place.server(running.commands(), place.ipc("states")), kCannotListen,
                {"--commands", running.commands(), "another server listens there"});
  check_refusal(place.server(place.ipc("commands"), running.states()), kCannotListen,
                {"--states", running.states(), "another server listens there"});
  check_serves(running.commands());
  subscribe(running, {"force"});

  const std::string abstract = "ipc://@acus-test-" + std::to_string(getpid());
  Process first(place.server(abstract, place.ipc("states")));
  check_serves(abstract);
  check_refusal(place.server(abstract, place.ipc("other_states")), kCannotListen,
                {"--commands", abstract, "another program listens there"});
  check_serves(abstract);

  Printed listening(place.server("ipc://*", "tcp://127.0.0.1:*"));
  const std::string line = line_about_states(listening);
  REQUIRE_FALSE(line.empty());
  const std::string port = line.substr(line.find("tcp://"));
  check_refusal(place.server(place.ipc("more"), port), kCannotListen,
                {"--states", port, "another program listens there"});
}

TEST_CASE("a server listens on localhost") {
  const Place place;
  Printed listening(place.server(place.ipc("commands"), "tcp://localhost:*"));
  CHECK(line_about_states(listening).find("tcp://127.0.0.1:") != std::string::npos);
}

TEST_CASE("a socket that a killed server left behind is replaced") {
  ServerProcess server;
  check_serves(server.commands());
  server.process().send_signal(SIGKILL);
  REQUIRE(server.process().wait(kPatience) == -SIGKILL);
  REQUIRE(std::filesystem::is_socket(server.folder() / "commands"));
  Process next(server.command_line({}));
  check_serves(server.commands());
}

TEST_CASE("where nobody can listen, one sentence says why and what to do") {
  const Place place;
  check_refusal(place.server(place.ipc("missing/commands"), place.ipc("states")), kCannotListen,
                {"--commands", "the folder does not exist; create it"});
  for (const std::string nowhere : {"tcp://192.0.2.1:5750", "tcp://no-such-interface:5750"}) {
    auto server = place.server(nowhere, place.ipc("states"));
    server.emplace_back("--insecure");
    check_refusal(server, kCannotListen,
                  {"--commands", nowhere, "no network interface of this machine has that address"});
  }
}

TEST_CASE("endpoints that mean nothing are a bad command line, at the server and at acus-replay") {
  const Place place;
  const std::string motion = place.folder.write("motion.csv", "t,needle,x,y,z,qw,qx,qy,qz\n0,needle,0,0,0,1,0,0,0\n");
  for (const std::string bad : {"tcp://127.0.0.1:99999", "tcp://127.0.0.1:-1", "tcp://127.0.0.1", "inproc://x",
                                "ws://127.0.0.1:5750", "nonsense", "ipc://"}) {
    for (const std::string option : {"--commands", "--states"}) {
      check_refusal({program_path("acus-server"), place.scene, option, bad}, kBadCommandLine,
                    {option, bad, "expected"});
      check_refusal({program_path("acus-replay"), motion, option, bad}, 1, {option, bad, "expected"});
    }
  }
  const std::string far = place.ipc(std::string(120, 'x'));
  check_refusal(place.server(far, place.ipc("states")), kBadCommandLine, {"--commands", "at most 107 bytes"});
  check_refusal(place.server(place.ipc("same"), place.ipc("same")), kBadCommandLine,
                {"--commands and --states", "give each its own"});
}

TEST_CASE("a web page is not heard over TCP either") {
  const Place place;
  Printed server(place.server("tcp://127.0.0.1:*", place.ipc("states")));
  std::string line = server.read_line();
  while (!line.empty() && line.find("commands on ") == std::string::npos) line = server.read_line();
  REQUIRE_FALSE(line.empty());
  const std::string commands = line.substr(line.find("tcp://"));
  RawPeer page(commands);
  page.send(web_page_post(zmtp1_frame(encode(protocol::Shutdown{}))));
  CHECK(page.is_closed());
  check_serves(commands);
  client::CommandLink(commands).shutdown(kPatience);
  CHECK(server.process().wait(kPatience) == kEnded);
}

// Typed for it, or an empty variable of a script.
TEST_CASE("a file that is no snapshot is not replaced by one") {
  const Place place;
  const TemporaryFolder& folder = place.folder;
  const std::string other = folder.write("other.txt", "as it was"), pipe = folder / "pipe",
                    beside = folder.write("new.new", "as it was");
  REQUIRE(mkfifo(pipe.c_str(), 0600) == 0);
  const auto check = [&](const std::vector<std::string>& options, const std::string& what) {
    std::vector<std::string> line = place.server(place.ipc("commands"), place.ipc("states"));
    line.insert(line.end(), options.begin(), options.end());
    check_refusal(line, kBadCommandLine, {what});
  };
  for (const std::string& there : {other, pipe, folder.path(), place.scene})
    check({"--snapshot", there}, "--snapshot " + there + ": something else stands there, which would be lost");
  check({"--snapshot", folder / "new"}, folder / "new.new: something else stands there, which would be lost");
  check({"--snapshot", folder / "absent/file"}, "no file can be made in its folder (No such file or directory)");
  check({"--snapshot", folder / "run", "--record", folder / "absent/../run"}, "--record names the same file");
  for (const char* option : {"--snapshot", "--restore", "--record"})
    check({option, ""}, std::string(option) + ": expected the name of a file");
  for (const std::string& kept : {other, beside}) CHECK(content_of(kept) == "as it was");
}

}  // namespace acus::testing
