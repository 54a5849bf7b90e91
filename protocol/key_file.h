// SPDX-License-Identifier: MIT
// Keys of CURVE, with which ZeroMQ proves who is at the other end and encrypts what is said: 40 characters of Z85 each
// (rfc.zeromq.org/spec/32), which stand for 32 bytes. They stand in files as acus-keygen, pyzmq and czmq write them: lines `public-key = "..."`
// and `secret-key = "..."`, and `name = "..."` before them, if there is one. Other lines are skipped.
#pragma once

#include <stdexcept>
#include <string>
#include <vector>

namespace acus::protocol {

struct KeyPair {
  std::string public_key, secret_key;
};

struct PublicKey {
  std::string name;  // for people; may be empty
  std::string key;
};

// what() names the file and what is wrong, and never a secret key.
struct KeyError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// Of a file with one pair that nobody but its owner, and at most a group, can read. Throws KeyError, also if its keys do
// not belong together.
KeyPair read_key_pair(const std::string& path);

// Of a file without secret keys. Throws KeyError, also if there is not exactly one.
PublicKey read_public_key(const std::string& path);

// Likewise of any number of such files, one after the other; at least one.
std::vector<PublicKey> read_public_keys(const std::string& path);

}  // namespace acus::protocol
