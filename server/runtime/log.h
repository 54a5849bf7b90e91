// SPDX-License-Identifier: GPL-3.0-or-later
// The log of the server: lines on standard error, for people or for programs.
//
// A line is one record, whatever is in it, and at most kMaxLogLine bytes. The log holds nothing up: a line for which
// standard error has no room is lost.
#pragma once

#include <limits.h>
#include <spdlog/formatter.h>
#include <spdlog/spdlog.h>

#include <map>
#include <memory>
#include <string>

namespace acus {

enum class LogFormat {
  text,  // [2026-01-31 12:00:00.000] [acus-server] [info] message
  json,  // {"time":"2026-01-31T11:00:00.000000Z","level":"info","program":"acus-server","message":"message"}
};

struct LogOptions {
  spdlog::level::level_enum level = spdlog::level::info;
  LogFormat format = LogFormat::text;
};

// Bytes of a line, its end included: what poll() says a pipe has room for.
inline constexpr std::size_t kMaxLogLine = PIPE_BUF;

// By their names on the command line.
inline const std::map<std::string, spdlog::level::level_enum> kLogLevels{
    {"trace", spdlog::level::trace}, {"debug", spdlog::level::debug}, {"info", spdlog::level::info},
    {"warn", spdlog::level::warn},   {"error", spdlog::level::err},   {"off", spdlog::level::off}};
inline const std::map<std::string, LogFormat> kLogFormats{{"text", LogFormat::text}, {"json", LogFormat::json}};

std::unique_ptr<spdlog::formatter> make_log_formatter(LogFormat format);

// Logs to standard error from now on. May be called again, with other options.
void begin_log(const LogOptions& options);

}  // namespace acus
