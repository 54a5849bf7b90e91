// SPDX-License-Identifier: MIT
#include "protocol/key_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zmq.h>

#include <array>
#include <cerrno>
#include <cstdint>
#include <sstream>
#include <string_view>
#include <utility>

namespace acus::protocol {
namespace {

constexpr std::size_t kKeyLength = 40, kKeyBytes = 32;
constexpr std::string_view kZ85 =
    "0123456789abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ.-:+=^!/*?&<>()[]{}@%$#";
constexpr off_t kMostBytes = 1 << 20;
constexpr mode_t kForbidden = S_IWGRP | S_IXGRP | S_IRWXO;

// All that a file says, in its order.
struct Content {
  std::vector<PublicKey> public_keys;
  std::vector<std::string> secret_keys;
  mode_t mode = 0;  // of the file
};

std::string trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return std::string(text.substr(first, text.find_last_not_of(" \t\r") + 1 - first));
}

std::string unquoted(const std::string& text) {
  const bool quoted = text.size() >= 2 && text.front() == text.back() && (text.front() == '"' || text.front() == '\'');
  return quoted ? text.substr(1, text.size() - 2) : text;
}

// Of all groups of five characters, some stand for no four bytes.
bool is_key(const std::string& text) {
  if (text.size() != kKeyLength || text.find_first_not_of(kZ85) != std::string::npos) return false;
  std::array<std::uint8_t, kKeyBytes> bytes{};
  return zmq_z85_decode(bytes.data(), text.c_str()) != nullptr;
}

// Throws KeyError.
void check_that_they_belong_together(const std::string& path, const KeyPair& pair) {
  std::array<char, kKeyLength + 1> public_key{};
  if (zmq_curve_public(public_key.data(), pair.secret_key.c_str()) != 0) {
    throw KeyError("the key file '" + path + "': ZeroMQ does not take its secret key: " +
                   (zmq_errno() == ENOTSUP ? "this ZeroMQ has no CURVE" : zmq_strerror(zmq_errno())));
  }
  if (pair.public_key == public_key.data()) return;
  throw KeyError("the key file '" + path +
                 "': the public key is not that of the secret key, so nobody could connect; acus-keygen NAME writes "
                 "both into NAME.key_secret");
}

struct OpenFile {
  explicit OpenFile(const std::string& path) : number(open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC)) {}
  ~OpenFile() {
    if (number >= 0) close(number);
  }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;

  const int number;  // negative if it cannot be opened
};

// The whole text, of a file that is one: a pipe or a device may never end. Throws KeyError.
std::string read_text(const std::string& path, mode_t& mode) {
  const OpenFile file(path);
  struct stat status {};
  if (file.number < 0 || fstat(file.number, &status) != 0) throw KeyError("the key file '" + path + "' cannot be read");
  if (!S_ISREG(status.st_mode)) throw KeyError("'" + path + "' is no file; expected a key file, as acus-keygen writes");
  if (status.st_size > kMostBytes)
    throw KeyError("the key file '" + path + "' has more than 1 MiB; acus-keygen writes some hundred bytes");
  std::string text(static_cast<std::size_t>(status.st_size), ' ');
  const ssize_t count = ::read(file.number, text.data(), text.size());
  if (count < 0) throw KeyError("the key file '" + path + "' cannot be read");
  text.resize(static_cast<std::size_t>(count));
  mode = status.st_mode;
  return text;
}

Content read(const std::string& path) {
  Content content;
  std::istringstream file(read_text(path, content.mode));
  std::string line, name;
  for (int number = 1; std::getline(file, line); ++number) {
    const std::string text = trimmed(line);
    const auto equals = text.find('=');
    if (text.starts_with('#') || equals == std::string::npos) continue;
    const std::string field = trimmed(std::string_view(text).substr(0, equals));
    const std::string value = unquoted(trimmed(std::string_view(text).substr(equals + 1)));
    if (field == "name") name = value;
    if (field != "public-key" && field != "secret-key") continue;
    if (!is_key(value)) {
      throw KeyError("the key file '" + path + "', line " + std::to_string(number) + ": expected a " + field +
                     " of 40 characters of Z85 in quotes, found something else; acus-keygen writes such files");
    }
    if (field == "secret-key") {
      content.secret_keys.push_back(value);
    } else {
      content.public_keys.push_back({std::exchange(name, {}), value});
    }
  }
  return content;
}

}  // namespace

KeyPair read_key_pair(const std::string& path) {
  const Content content = read(path);
  if (!content.secret_keys.empty() && (content.mode & kForbidden) != 0)
    throw KeyError("the key file '" + path + "' holds a secret key and is open to others; chmod 600 '" + path + "'");
  if (content.public_keys.size() != 1 || content.secret_keys.size() != 1) {
    throw KeyError("the key file '" + path + "': expected one public and one secret key, found " +
                   std::to_string(content.public_keys.size()) + " and " + std::to_string(content.secret_keys.size()) +
                   "; acus-keygen NAME writes them into NAME.key_secret");
  }
  KeyPair pair{content.public_keys.front().key, content.secret_keys.front()};
  check_that_they_belong_together(path, pair);
  return pair;
}

std::vector<PublicKey> read_public_keys(const std::string& path) {
  const Content content = read(path);
  if (!content.secret_keys.empty()) {
    throw KeyError("the key file '" + path +
                   "' holds a secret key, which only its owner needs; give the public part, which acus-keygen NAME "
                   "writes into NAME.key");
  }
  if ((content.mode & S_IWOTH) != 0)
    throw KeyError("the key file '" + path + "' can be changed by anybody, and so lets anybody in; chmod o-w '" + path +
                   "'");
  if (content.public_keys.empty())
    throw KeyError("the key file '" + path + "' holds no public key; acus-keygen NAME writes one into NAME.key");
  return content.public_keys;
}

PublicKey read_public_key(const std::string& path) {
  const std::vector<PublicKey> keys = read_public_keys(path);
  if (keys.size() == 1) return keys.front();
  throw KeyError("the key file '" + path + "': expected one public key, found " + std::to_string(keys.size()));
}

}  // namespace acus::protocol
