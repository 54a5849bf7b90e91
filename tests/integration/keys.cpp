// SPDX-License-Identifier: GPL-3.0-or-later
// Where servers listen with keys and without, whom they admit then, and what the others are told.
#include <doctest/doctest.h>
#include <signal.h>
#include <sys/stat.h>

#include <deque>
#include <fstream>

#include "protocol/key_file.h"
#include "tests/integration/printed.h"
#include "tests/integration/raw_peer.h"
#include "tests/support/file_content.h"
#include "tests/support/places.h"

namespace acus::testing {
namespace {

constexpr int kBadCommandLine = 1, kCannotListen = 3, kNotThere = 3;

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

// A folder with the keys of a server, of alice, whom it admits, and of bob, whom it does not.
struct Keys {
  TemporaryFolder folder;

  Keys() {
    for (const std::string name : {"server", "alice", "bob"}) REQUIRE(make(name) == 0);
  }

  std::optional<int> make(const std::string& name) const {
    Printed keygen({program_path("acus-keygen"), folder / name});
    const auto status = keygen.process().wait(kPatience);
    CHECK_FALSE(contains(keygen.read_all(), protocol::read_key_pair(secret(name)).secret_key));
    return status;
  }
  std::string secret(const std::string& name) const { return folder / (name + ".key_secret"); }
  std::string open(const std::string& name) const { return folder / (name + ".key"); }

  std::vector<std::string> of_server() const {
    return {"--curve-server-key", secret("server"), "--curve-clients", open("alice")};
  }
  client::CurveKeys of_client(const std::string& name, const std::string& server = "server") const {
    return {protocol::read_public_key(open(server)).key, protocol::read_key_pair(secret(name))};
  }
};

// Whether a client is not let in and says so, sooner or later: an attempt may come before the server listens, or end
// without a reason.
bool is_refused(const ServerProcess& server, const std::optional<client::CurveKeys>& keys,
                const std::string& sentence) {
  const auto deadline = std::chrono::steady_clock::now() + kPatience;
  client::CommandLink commands(server.commands(), keys);
  while (std::chrono::steady_clock::now() < deadline) {
    try {
      commands.hello(200ms);
      return false;
    } catch (const client::Vanished& error) {
      if (contains(error.what(), sentence)) return true;
    }
  }
  return false;
}

std::string secret_line(const Keys& keys, const std::string& name) {
  return "    secret-key = \"" + protocol::read_key_pair(keys.secret(name)).secret_key + "\"\n";
}

// Of a server on the small scene, which is written into the folder.
std::vector<std::string> command_line(const TemporaryFolder& folder, const std::string& commands,
                                      const std::string& states, const std::vector<std::string>& options) {
  const std::string scene = folder.write("scene.yaml", small_scene("small"));
  std::vector<std::string> line{program_path("acus-server"), scene, "--commands", commands, "--states", states};
  line.insert(line.end(), options.begin(), options.end());
  return line;
}

// How a server ends whose command line names these endpoints, and what it says.
std::pair<std::optional<int>, std::string> outcome(const std::string& commands, const std::string& states,
                                                   const std::vector<std::string>& options) {
  const TemporaryFolder folder;
  Printed server(command_line(folder, commands, states, options));
  const auto status = server.process().wait(kPatience);
  return {status, server.read_all()};
}

// The endpoint for commands that the server's log names.
std::string commands_of(Printed& server) {
  std::string line;
  do line = server.read_line();
  while (!line.empty() && !contains(line, "commands on "));
  REQUIRE(!line.empty());
  return line.substr(line.find("tcp://"));
}

}  // namespace

TEST_CASE("the log says who connects, holds and is gone, by what a client cannot choose") {
  const Keys keys;
  const TemporaryFolder folder;
  Printed server(command_line(folder, "tcp://127.0.0.1:*", "tcp://127.0.0.1:*", keys.of_server()));
  const auto read_until = [&](const std::string& part) {
    std::string text, next;
    do text += (next = server.read_line()) + "\n";
    while (!next.empty() && !contains(next, part));
    return text;
  };
  const std::string endpoint = commands_of(server);
  client::CommandLink(endpoint, keys.of_client("alice")).acquire({"needle"}, kPatience);
  const std::string log = read_until("disconnects");
  const std::string alice =
      "at 127.0.0.1 with the key of 'alice', " + protocol::read_public_key(keys.open("alice")).key;
  for (const std::string what : {" connects", " holds needle", " is gone and holds nothing any more", " disconnects"})
    CHECK(contains(log, alice + what));
}

TEST_CASE("strangers who say nothing lock nobody out who has a key") {
  const Keys keys;
  const TemporaryFolder folder;
  std::vector<std::string> line = command_line(folder, "tcp://127.0.0.1:*", "tcp://127.0.0.1:*", keys.of_server());
  line.insert(line.begin(), {"/usr/bin/prlimit", "--nofile=64:64"});
  Printed server(line);
  const std::string endpoint = commands_of(server);
  std::deque<RawPeer> strangers;
  for (int round = 0; round < 3; ++round) {
    for (int i = 0; i < 40; ++i) strangers.emplace_back(endpoint);
    CHECK(client::CommandLink(endpoint, keys.of_client("alice")).hello(kPatience).scene == "small");
  }
}

TEST_CASE("a stranger without a key is cut off once it has sent a mebibyte, and others are served") {
  const Keys keys;
  const TemporaryFolder folder;
  Printed server(command_line(folder, "tcp://127.0.0.1:*", "tcp://127.0.0.1:*", keys.of_server()));
  const std::string endpoint = commands_of(server);
  RawPeer patient(endpoint), stranger(endpoint);
  const std::string long_command("\6\0\0\0\0\1\xff\xff\xff", 9);  // of 32 MiB
  patient.send(zmtp3_greeting("CURVE") + long_command + std::string(100'000, 'x'));
  stranger.send(zmtp3_greeting("CURVE") + long_command);
  for (int i = 0; i < 3; ++i) stranger.send(std::string(500'000, 'x'));
  CHECK(stranger.is_closed());
  CHECK(patient.send("x"));
  CHECK(client::CommandLink(endpoint, keys.of_client("alice")).hello(kPatience).scene == "small");
}

TEST_CASE("acus-keygen writes a secret that only its owner can read, and never overwrites") {
  const Keys keys;
  struct stat status {};
  REQUIRE(stat(keys.secret("alice").c_str(), &status) == 0);
  CHECK((status.st_mode & 0777) == 0600);
  const protocol::KeyPair pair = protocol::read_key_pair(keys.secret("alice"));
  const protocol::PublicKey open = protocol::read_public_key(keys.open("alice"));
  CHECK(open.key == pair.public_key);
  CHECK(open.name == "alice");
  CHECK(pair.secret_key != pair.public_key);
  CHECK(pair.secret_key != protocol::read_key_pair(keys.secret("bob")).secret_key);

  CHECK(keys.make("alice") == 1);
  CHECK(protocol::read_key_pair(keys.secret("alice")).secret_key == pair.secret_key);
  REQUIRE(unlink(keys.secret("bob").c_str()) == 0);
  std::ifstream before(keys.open("bob"));
  Printed keygen({program_path("acus-keygen"), keys.folder / "bob"});
  CHECK(keygen.process().wait(kPatience) == 1);
  CHECK(contains(keygen.read_all(), "never overwritten"));
  CHECK(stat(keys.secret("bob").c_str(), &status) != 0);  // no secret without its public part
}

TEST_CASE("a server with keys serves the clients that it knows, on both sockets") {
  const Keys keys;
  ServerProcess server(keys.of_server());
  client::CommandLink commands(server.commands(), keys.of_client("alice"));
  CHECK(commands.hello(kPatience).scene == "small");
  commands.acquire({"needle"}, kPatience);
  REQUIRE(commands.send(pose_at(0.4, 1)));
  client::StateLink states(server.states(), client::StateLink::kCapacity, keys.of_client("alice"));
  states.subscribe("force");
  while (receive<protocol::Force>(states).seq != 1) {
  }
}

TEST_CASE("a server with keys admits nobody else, and says why") {
  const Keys keys;
  ServerProcess server(keys.of_server());
  CHECK(is_refused(server, keys.of_client("bob"), "refuses this client's key"));
  CHECK(is_refused(server, std::nullopt, "admits only clients with keys"));
  CHECK(is_refused(server, keys.of_client("alice", "bob"), "not that of this server"));
  client::CurveKeys stolen = keys.of_client("bob");
  stolen.own.public_key = keys.of_client("alice").own.public_key;  // without the secret that belongs to it
  CHECK(is_refused(server, stolen, "the connection ended in the handshake"));

  client::StateLink admitted(server.states(), client::StateLink::kCapacity, keys.of_client("alice"));
  client::StateLink strange(server.states(), client::StateLink::kCapacity, keys.of_client("bob"));
  for (client::StateLink* states : {&strange, &admitted}) states->subscribe("force");
  for (int i = 0; i < 100; ++i) receive<protocol::Force>(admitted);
  CHECK_FALSE(strange.receive(0ms));
}

TEST_CASE("a server without keys says so to who has some") {
  const Keys keys;
  ServerProcess server;
  CHECK(is_refused(server, keys.of_client("alice"), "does not use keys"));
}

TEST_CASE("the log names the key of who is refused, and no secret") {
  const Keys keys;
  const TemporaryFolder folder;
  Printed server(
      command_line(folder, "ipc://" + (folder / "commands"), "ipc://" + (folder / "states"), keys.of_server()));
  client::CommandLink refused("ipc://" + (folder / "commands"), keys.of_client("bob"));
  std::string said, text;
  while (!contains(said = server.read_line(), "is refused: its public key")) {
    REQUIRE_FALSE(said.empty());
    text += said;
  }
  CHECK(contains(said, keys.of_client("bob").own.public_key));
  server.process().send_signal(SIGTERM);
  text += said + server.read_all();
  for (const std::string name : {"server", "alice", "bob"})
    CHECK_FALSE(contains(text, protocol::read_key_pair(keys.secret(name)).secret_key));
}

TEST_CASE("acus-replay takes keys from files") {
  const Keys keys;
  ServerProcess server(keys.of_server());
  const std::string motion = server.folder().write(
      "motion.csv", "t,needle,x,y,z,qw,qx,qy,qz\n0,needle,0,0,0.5,1,0,0,0\n0.1,needle,0,0,0.5,1,0,0,0\n");
  const auto status_of = [&](const std::vector<std::string>& options) {
    std::vector<std::string> line{program_path("acus-replay"), motion,     "--commands",
                                  server.commands(),           "--states", server.states()};
    line.insert(line.end(), options.begin(), options.end());
    return Process(line).wait(kPatience);
  };
  CHECK(status_of({"--curve-server-key", keys.open("server"), "--curve-client-key", keys.secret("alice"), "--timeout",
                   "60"}) == 0);
  CHECK(status_of({"--curve-server-key", keys.open("server"), "--curve-client-key", keys.secret("bob"), "--timeout",
                   "1"}) == kNotThere);
  CHECK(status_of({"--curve-server-key", keys.open("server")}) == kBadCommandLine);
  CHECK(status_of({"--curve-server-key", keys.secret("server"), "--curve-client-key", keys.secret("alice")}) ==
        kBadCommandLine);
}

TEST_CASE("where other machines can connect, a server listens with keys or not at all, unless told otherwise") {
  const std::string local = "tcp://127.0.0.1:*", elsewhere = "tcp://192.0.2.1:*";  // an address that nobody has
  for (const auto& [commands, states] : {std::pair{elsewhere, local}, {local, elsewhere}, {"tcp://*:*", local}}) {
    const auto [status, said] = outcome(commands, states, {});
    CHECK(status == kCannotListen);
    for (const std::string part : {"other machines", "--curve-server-key", "--curve-clients", "--insecure"})
      CHECK(contains(said, part));
  }
  const Keys keys;
  for (const auto& options : {std::vector<std::string>{"--insecure"}, keys.of_server()}) {
    const auto [status, said] = outcome(elsewhere, local, options);
    CHECK(status == kCannotListen);
    CHECK(contains(said, "no network interface"));
  }
}

TEST_CASE("keys that cannot be used are a bad command line") {
  const Keys keys;
  const std::string local = "tcp://127.0.0.1:*";
  const auto check = [&](const std::vector<std::string>& options, const std::string& part) {
    const auto [status, said] = outcome(local, local, options);
    CHECK(status == kBadCommandLine);
    CAPTURE(said);
    CHECK(contains(said, part));
  };
  check({"--curve-server-key", keys.secret("server")}, "--curve-clients");
  check({"--curve-clients", keys.open("alice")}, "--curve-server-key");
  check({"--curve-server-key", keys.open("server"), "--curve-clients", keys.open("alice")}, "expected one public");
  check({"--curve-server-key", keys.secret("server"), "--curve-clients", keys.folder / "nobody"}, "cannot be read");
  const std::string mixed = keys.folder.write("mixed", content_of(keys.open("bob")) + secret_line(keys, "server"));
  REQUIRE(chmod(mixed.c_str(), 0600) == 0);
  check({"--curve-server-key", mixed, "--curve-clients", keys.open("alice")},
        "'" + mixed + "': the public key is not that of the secret key");
  auto both = keys.of_server();
  both.emplace_back("--insecure");
  check(both, "--insecure");
  REQUIRE(chmod(keys.secret("server").c_str(), 0644) == 0);
  check(keys.of_server(), "chmod 600");
}

}  // namespace acus::testing
