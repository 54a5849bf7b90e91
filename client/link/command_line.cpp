// SPDX-License-Identifier: MIT
#include "client/link/command_line.h"

#include <cstdio>

#include <array>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <string_view>

#include "protocol/endpoint_address.h"
#include "protocol/key_file.h"

namespace acus::client {

namespace {

std::atomic<bool> interrupted = false;
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler may only touch lock-free atomics");

extern "C" void on_signal(int) { interrupted = true; }

}  // namespace

std::string check_endpoint(const std::string& endpoint) {
  const std::string problem = protocol::problem_with_endpoint(endpoint, protocol::EndpointUse::connect);
  return problem.empty() ? problem : "endpoint '" + endpoint + "': " + problem;
}

CLI::Validator within(double low, double high) {
  char range[64];
  std::snprintf(range, sizeof range, "%g to %g", low, high);
  const std::string name = range;
  return {[=](std::string& text) {
            double value = 0;
            if (CLI::detail::lexical_cast(text, value) && value >= low && value <= high) return std::string();
            return "expected a number from " + name + ", found '" + text + "'";
          },
          name};
}

void declare_keys(CLI::App& app, KeyFiles& files) {
  CLI::Option* server = app.add_option("--curve-server-key", files.server,
                                       "file with the server's public key, for a server that asks for keys");
  CLI::Option* client =
      app.add_option("--curve-client-key", files.client,
                     "file with the key pair of this client, as acus-keygen writes it into NAME.key_secret");
  server->needs(client);
  client->needs(server);
}

std::optional<CurveKeys> read_keys(const KeyFiles& files) {
  if (files.server.empty()) return std::nullopt;
  return CurveKeys{protocol::read_public_key(files.server).key, protocol::read_key_pair(files.client)};
}

bool is_recording(const std::string& file) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(file, ignored)) return false;
  std::array<char, 4> begin{};
  std::ifstream(file, std::ios::binary).read(begin.data(), begin.size());
  return std::string_view(begin.data(), begin.size()) == "\x28\xb5\x2f\xfd";
}

std::atomic<bool>& catch_signals() {
  std::signal(SIGINT, on_signal);
  std::signal(SIGTERM, on_signal);
  return interrupted;
}

}  // namespace acus::client
