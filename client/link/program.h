// SPDX-License-Identifier: MIT
// A program from its command line to its exit status.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>

#include "protocol/printable.h"

namespace acus::client {

// Exit statuses that programs have in common. The others are a program's own.
inline constexpr int kDone = 0, kBadInput = 1, kRefused = 2, kVanished = 3, kMismatch = 5, kInterrupted = 6;

// Parses the command line, a bad one is kBadInput, and does `work`, which returns the status. What that throws is
// printed behind the program's name, and status_of(error) is the status.
template <class Work, class StatusOf>
int run_program(CLI::App& app, int argc, char** argv, Work work, StatusOf status_of) {
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kDone : kBadInput;
  }
  try {
    return work();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", app.get_name().c_str(), protocol::printable(error.what()).c_str());
    return status_of(error);
  }
}

// As above, for work that throws for bad input alone.
template <class Work>
int run_program(CLI::App& app, int argc, char** argv, Work work) {
  return run_program(app, argc, argv, work, [](const std::exception&) { return kBadInput; });
}

}  // namespace acus::client
