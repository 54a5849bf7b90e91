// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/runtime/log.h"

#include <poll.h>
#include <spdlog/fmt/chrono.h>
#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <unistd.h>

#include <csignal>
#include <nlohmann/json.hpp>
#include <string_view>

#include "protocol/printable.h"

namespace acus {
namespace {

using spdlog::memory_buf_t;
using spdlog::details::log_msg;

// Waits for nobody: a pipe whose reader is gone or does not read takes no line.
struct LogSink : spdlog::sinks::stderr_color_sink_mt {
  void log(const log_msg& message) override {
    pollfd file{STDERR_FILENO, POLLOUT, 0};
    if (poll(&file, 1, 0) == 1 && (file.revents & POLLOUT)) spdlog::sinks::stderr_color_sink_mt::log(message);
  }
};

// The message in a line of text: what comes from clients and scenes moves no terminal's cursor.
class EscapedMessage : public spdlog::custom_flag_formatter {
 public:
  void format(const log_msg& message, const std::tm&, memory_buf_t& out) override {
    out.append(protocol::printable({message.payload.data(), message.payload.size()}));
  }
  std::unique_ptr<custom_flag_formatter> clone() const override { return std::make_unique<EscapedMessage>(); }
};

std::unique_ptr<spdlog::formatter> make_text_formatter() {
  auto formatter = std::make_unique<spdlog::pattern_formatter>();
  formatter->add_flag<EscapedMessage>('*').set_pattern("[%Y-%m-%d %H:%M:%S.%e] [%n] [%^%l%$] %*");
  return formatter;
}

// RFC 3339, UTC.
std::string time_text(spdlog::log_clock::time_point time) {
  const auto micros = std::chrono::duration_cast<std::chrono::microseconds>(time.time_since_epoch()).count();
  const std::time_t seconds = micros / 1'000'000;
  return fmt::format("{:%Y-%m-%dT%H:%M:%S}.{:06}Z", fmt::gmtime(seconds), micros % 1'000'000);
}

// One object a line; bytes that are no UTF-8 become U+FFFD.
class JsonFormatter : public spdlog::formatter {
 public:
  void format(const log_msg& message, memory_buf_t& out) override {
    using json = nlohmann::ordered_json;
    const std::string_view level = spdlog::level::to_string_view(message.level).data();
    const json line{{"time", time_text(message.time)},
                    {"level", level},
                    {"program", std::string_view(message.logger_name.data(), message.logger_name.size())},
                    {"message", std::string_view(message.payload.data(), message.payload.size())}};
    const std::string text = line.dump(-1, ' ', false, json::error_handler_t::replace) + "\n";
    out.append(text.data(), text.data() + text.size());
  }
  std::unique_ptr<formatter> clone() const override { return std::make_unique<JsonFormatter>(); }
};

// Cuts messages until their lines are short enough: escaping may make six bytes of one.
class CuttingFormatter : public spdlog::formatter {
 public:
  explicit CuttingFormatter(std::unique_ptr<spdlog::formatter> inner) : inner_(std::move(inner)) {}

  void format(const log_msg& message, memory_buf_t& out) override {
    const std::size_t begin = out.size();
    inner_->format(message, out);
    for (std::size_t size = message.payload.size() / 2; out.size() - begin > kMaxLogLine && size > 0; size /= 2) {
      const std::string cut = std::string(message.payload.data(), size) + "...";
      log_msg shorter = message;
      shorter.payload = cut;
      out.resize(begin);
      inner_->format(shorter, out);
      message.color_range_start = shorter.color_range_start;
      message.color_range_end = shorter.color_range_end;
    }
  }
  std::unique_ptr<formatter> clone() const override { return std::make_unique<CuttingFormatter>(inner_->clone()); }

 private:
  std::unique_ptr<spdlog::formatter> inner_;
};

}  // namespace

std::unique_ptr<spdlog::formatter> make_log_formatter(LogFormat format) {
  return std::make_unique<CuttingFormatter>(format == LogFormat::json ? std::make_unique<JsonFormatter>()
                                                                      : make_text_formatter());
}

// A server outlives who reads its log: lines that cannot be written are lost, and nothing else happens. So it does a
// file that may not grow.
void begin_log(const LogOptions& options) {
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
  auto logger = std::make_shared<spdlog::logger>("acus-server", std::make_shared<LogSink>());
  logger->set_formatter(make_log_formatter(options.format));
  logger->set_level(options.level);
  spdlog::set_default_logger(std::move(logger));
  spdlog::set_error_handler([](const std::string&) {});
}

}  // namespace acus
