// SPDX-License-Identifier: MIT
// What programs that talk to a server have in common on their command lines: endpoints, keys, and how they are ended.
#pragma once

#include <CLI/CLI.hpp>
#include <atomic>
#include <optional>
#include <string>

#include "client/link/client.h"

namespace acus::client {

// What is wrong with an endpoint to connect to; nothing: empty. For CLI::Option::check().
std::string check_endpoint(const std::string& endpoint);

// A number from low to high; unlike CLI::Range, NaN is none.
CLI::Validator within(double low, double high);

struct KeyFiles {
  std::string server, client;  // empty: no keys
};

// --curve-server-key and --curve-client-key, both or neither.
void declare_keys(CLI::App& app, KeyFiles& files);

// Throws protocol::KeyError.
std::optional<CurveKeys> read_keys(const KeyFiles& files);

// Whether a file is what a server recorded: it begins as zstd's files do, which neither trajectories nor scenes do.
// Nothing is read of a pipe.
bool is_recording(const std::string& file);

// From now on SIGINT and SIGTERM set what this returns, and do not end the program.
std::atomic<bool>& catch_signals();

}  // namespace acus::client
