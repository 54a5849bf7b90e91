// SPDX-License-Identifier: MIT
// A program from its command line to its exit status.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <optional>
#include <string>

#include "client/link/errors.h"
#include "protocol/printable.h"

namespace acus::client {

// Exit statuses that programs have in common. The others are a program's own.
inline constexpr int kDone = 0, kBadInput = 1, kRefused = 2, kVanished = 3, kMismatch = 5, kInterrupted = 6;

// Of what a link throws; nothing for other errors.
inline std::optional<int> status_of_link(const std::exception& error) {
  if (dynamic_cast<const Refused*>(&error) != nullptr) return kRefused;
  if (dynamic_cast<const Vanished*>(&error) != nullptr) return kVanished;
  if (dynamic_cast<const ProtocolMismatch*>(&error) != nullptr) return kMismatch;
  return std::nullopt;
}

// Does `work`, which returns the status. What that throws is printed behind the program's name, and status_of(error) is
// the status; it may throw on.
template <class Work, class StatusOf>
int told_status(const std::string& program, Work work, StatusOf status_of) {
  try {
    return work();
  } catch (const std::exception& error) {
    const int status = status_of(error);
    std::fprintf(stderr, "%s: %s\n", program.c_str(), protocol::printable(error.what()).c_str());
    return status;
  }
}

// Parses the command line, a bad one is kBadInput, and does `work` as told_status() does.
template <class Work, class StatusOf>
int run_program(CLI::App& app, int argc, char** argv, Work work, StatusOf status_of) {
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kDone : kBadInput;
  }
  return told_status(app.get_name(), work, status_of);
}

// As above, for work that throws for bad input alone.
template <class Work>
int run_program(CLI::App& app, int argc, char** argv, Work work) {
  return run_program(app, argc, argv, work, [](const std::exception&) { return kBadInput; });
}

}  // namespace acus::client
