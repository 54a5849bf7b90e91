// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/runtime/log.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

namespace acus {
namespace {

std::string line_of(LogFormat format, const std::string& message) {
  const spdlog::details::log_msg record(spdlog::log_clock::time_point(std::chrono::microseconds(1'500'000)), {},
                                        "acus-server", spdlog::level::warn, message);
  spdlog::memory_buf_t line;
  make_log_formatter(format)->format(record, line);
  return {line.data(), line.size()};
}

nlohmann::json json_of(const std::string& message) { return nlohmann::json::parse(line_of(LogFormat::json, message)); }

std::string every_byte() {
  std::string bytes;
  for (int i = 0; i < 256; ++i) bytes.push_back(static_cast<char>(i));
  return bytes;
}

}  // namespace

TEST_CASE("a record in JSON has time, level, program and message") {
  CHECK(line_of(LogFormat::json, "ticks were late") ==
        R"({"time":"1970-01-01T00:00:01.500000Z","level":"warning","program":"acus-server","message":"ticks were late"})"
        "\n");
}

TEST_CASE("a record in JSON keeps what it can of any bytes") {
  CHECK(json_of("a \"scene\"\nwith\tlines: é")["message"] == "a \"scene\"\nwith\tlines: é");
  CHECK(json_of("\xff")["message"] == "\xef\xbf\xbd");
}

TEST_CASE("whatever is in a message stays in one line of bounded length") {
  for (const LogFormat format : {LogFormat::text, LogFormat::json}) {
    for (const std::string& message :
         {every_byte(), std::string(100'000, 'a'), std::string(4'000, '\n'), std::string(4'000, '\xff'),
          std::string(4'096, '\0'), std::string()}) {
      const std::string line = line_of(format, message);
      CHECK(line.size() <= kMaxLogLine);
      CHECK(std::ranges::count(line, '\n') == 1);
      CHECK(line.back() == '\n');
      CHECK(std::none_of(line.begin(), line.end() - 1, [](unsigned char c) { return c < 0x20; }));
      if (format == LogFormat::json) CHECK(nlohmann::json::accept(line));
    }
  }
}

TEST_CASE("a cut message says so, and keeps its beginning") {
  const std::string line = line_of(LogFormat::text, std::string(100'000, 'a'));
  CHECK(line.find("[acus-server] [warning] aaaa") != std::string::npos);
  CHECK(line.ends_with("a...\n"));
  CHECK(json_of(std::string(100'000, 'a'))["message"].get<std::string>().ends_with("a..."));
}

TEST_CASE("levels have names on the command line") {
  CHECK(kLogLevels.size() == 6);
  CHECK(kLogLevels.at("warn") == spdlog::level::warn);
}

}  // namespace acus
