// SPDX-License-Identifier: MIT
// acus-keygen: makes the keys with which servers and clients prove who they are.
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zmq.h>

#include <CLI/CLI.hpp>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <stdexcept>
#include <string>
#include <string_view>

#include "client/link/program.h"

namespace {

constexpr const char* kDescription =
    "Makes a pair of keys (CURVE): NAME.key_secret, which only its owner may read and acus-server or acus-replay needs "
    "to prove who it is, and NAME.key, the public part, which the other side needs.";
constexpr const char* kFooter =
    "Example, for a server that two clients may use:\n"
    "  acus-keygen server; acus-keygen alice; acus-keygen bob\n"
    "  cat alice.key bob.key > clients\n"
    "  acus-server SCENE --commands tcp://*:5750 --states tcp://*:5751 --curve-server-key server.key_secret "
    "--curve-clients clients\n"
    "  acus-replay TRAJECTORY --commands tcp://HOST:5750 --states tcp://HOST:5751 --curve-server-key server.key "
    "--curve-client-key alice.key_secret\n"
    "\nExit status: 0 done, 1 the files cannot be written, or exist.";

constexpr std::size_t kTextKey = 41;  // bytes, with the end

struct Keys {
  std::array<char, kTextKey> public_key{}, secret_key{};
};

Keys draw_keys() {
  Keys keys;
  if (zmq_curve_keypair(keys.public_key.data(), keys.secret_key.data()) != 0)
    throw std::runtime_error(std::string("ZeroMQ makes no keys: ") + zmq_strerror(zmq_errno()));
  return keys;
}

// The part of a path after its last slash.
std::string name_of(const std::string& path) { return path.substr(path.rfind('/') + 1); }

// A file that did not exist; it is removed again unless keep() is called.
class NewFile {
 public:
  NewFile(std::string path, mode_t mode)
      : path_(std::move(path)), file_(open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, mode)) {
    if (file_ >= 0) return;
    const std::string reason = errno == EEXIST ? "it exists, and keys are never overwritten; choose another name, or "
                                                 "remove it"
                                               : std::strerror(errno);
    throw std::runtime_error("cannot write '" + path_ + "': " + reason);
  }
  ~NewFile() {
    if (file_ >= 0) close(file_);
    if (!kept_) unlink(path_.c_str());
  }
  NewFile(const NewFile&) = delete;
  NewFile& operator=(const NewFile&) = delete;

  void write(std::string_view text) {
    if (::write(file_, text.data(), text.size()) != static_cast<ssize_t>(text.size()) || fsync(file_) != 0)
      throw std::runtime_error("cannot write '" + path_ + "': " + std::strerror(errno));
  }
  void keep() { kept_ = true; }
  const std::string& path() const { return path_; }

 private:
  std::string path_;
  int file_;
  bool kept_ = false;
};

std::string public_part(const std::string& name, const Keys& keys) {
  return "metadata\n    name = \"" + name + "\"\ncurve\n    public-key = \"" + keys.public_key.data() + "\"\n";
}

void make_keys(const std::string& path) {
  if (name_of(path).empty() || path.find_first_of("\"\n\r") != std::string::npos)
    throw std::runtime_error("expected a name, such as alice or keys/alice, without quotes and line breaks");
  NewFile secret_file(path + ".key_secret", S_IRUSR | S_IWUSR);
  NewFile public_file(path + ".key", S_IRUSR | S_IWUSR | S_IRGRP | S_IROTH);
  const Keys keys = draw_keys();
  const std::string common = public_part(name_of(path), keys);
  secret_file.write("# Secret key of a ZeroMQ CURVE pair: give it to nobody.\n" + common + "    secret-key = \"" +
                    keys.secret_key.data() + "\"\n");
  public_file.write("# Public key of a ZeroMQ CURVE pair.\n" + common);
  secret_file.keep();
  public_file.keep();
  std::printf("written     %s, which stays with its owner\nwritten     %s, public key %s\n", secret_file.path().c_str(),
              public_file.path().c_str(), keys.public_key.data());
}

}  // namespace

int main(int argc, char** argv) {
  std::signal(SIGXFSZ, SIG_IGN);  // a file that may not grow is an error
  CLI::App app(kDescription, "acus-keygen");
  app.footer(kFooter);
  app.set_version_flag("--version", ACUS_VERSION);
  std::string name;
  app.add_option("NAME", name, "of the files, without their ends; a folder may stand before it")->required();
  return acus::client::run_program(app, argc, argv, [&] {
    make_keys(name);
    return acus::client::kDone;
  });
}
