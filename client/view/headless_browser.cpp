// SPDX-License-Identifier: MIT
#include "client/view/headless_browser.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <utility>

#include "client/view/child_program.h"

namespace acus::view {

namespace {

using nlohmann::json;

constexpr const char* kBrowsers[] = {"chromium", "chromium-browser", "google-chrome"};
constexpr auto kAnswerPatience = std::chrono::minutes(2);  // for an answer: large tissues take a while without a GPU
constexpr int kLookMilliseconds = 100;
constexpr int kMostEndTries = 150;
constexpr useconds_t kEndPause = 20'000;

std::string find_browser() {
  for (const char* name : kBrowsers)
    if (std::string found = find_program(name); !found.empty()) return found;
  throw std::runtime_error("no browser to draw pictures with; install chromium");
}

std::string from_base64(std::string_view text) {
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  unsigned buffer = 0;
  int bits = 0;
  for (const char character : text) {
    const std::size_t digit = kDigits.find(character);
    if (digit == std::string_view::npos) break;  // the padding
    buffer = buffer << 6 | static_cast<unsigned>(digit);
    if ((bits += 6) < 8) continue;
    bits -= 8;
    bytes += static_cast<char>(buffer >> bits & 0xff);
  }
  return bytes;
}

}  // namespace

bool has_browser() {
  return std::ranges::any_of(kBrowsers, [](const char* name) { return !find_program(name).empty(); });
}

std::string find_program(const std::string& name) {
  const char* path = std::getenv("PATH");
  for (std::string rest = path != nullptr ? path : ""; !rest.empty();) {
    const std::size_t end = std::min(rest.find(':'), rest.size());
    std::string candidate = rest.substr(0, end) + "/" + name;
    if (access(candidate.c_str(), X_OK) == 0) return candidate;
    rest.erase(0, end + 1);
  }
  return "";
}

HeadlessBrowser::HeadlessBrowser(std::stop_token stop) : folder_(new_folder()), stop_(std::move(stop)) {}

// Delegates, so that the destructor cleans up whatever goes wrong from here on.
HeadlessBrowser::HeadlessBrowser(const std::string& url, int width, int height, std::stop_token stop)
    : HeadlessBrowser(std::move(stop)) {
  std::vector<std::string> command{find_browser(),
                                   "--headless=new",
                                   "--remote-debugging-pipe",
                                   "--use-angle=swiftshader",
                                   "--enable-unsafe-swiftshader",
                                   "--disable-dev-shm-usage",
                                   "--hide-scrollbars",
                                   "--no-first-run",
                                   "--disable-background-networking",
                                   "--user-data-dir=" + folder_};
  if (geteuid() == 0) command.emplace_back("--no-sandbox");  // Chromium's sandbox refuses root
  start(std::move(command));
  const json page = ask("Target.createTarget", {{"url", "about:blank"}});
  session_ = ask("Target.attachToTarget", {{"targetId", page.at("targetId")}, {"flatten", true}})
                 .at("sessionId")
                 .get<std::string>();
  ask("Emulation.setDeviceMetricsOverride",
      {{"width", width}, {"height", height}, {"deviceScaleFactor", 1}, {"mobile", false}});
  const json answer = ask("Page.navigate", {{"url", url}});
  if (const std::string error = answer.value("errorText", ""); !error.empty())
    throw std::runtime_error("the browser cannot open " + url + ": " + error);
}

HeadlessBrowser::~HeadlessBrowser() {
  if (process_ > 0) end();
  std::error_code error;
  for (int tries = 0; std::filesystem::remove_all(folder_, error), error && tries < kMostEndTries; ++tries)
    usleep(kEndPause);
}

void HeadlessBrowser::end() {
  close(commands_);  // for which it ends
  close(answers_);
  for (int tries = 0; waitpid(process_, nullptr, WNOHANG) == 0; ++tries) {
    if (tries >= kMostEndTries) kill(-process_, SIGKILL);
    usleep(kEndPause);
  }
  kill(-process_, SIGKILL);  // processes of its own that still write
}

json HeadlessBrowser::evaluate(const std::string& expression) {
  const json answer =
      ask("Runtime.evaluate", {{"expression", expression}, {"awaitPromise", true}, {"returnByValue", true}});
  if (const auto thrown = answer.find("exceptionDetails"); thrown != answer.end()) {
    const json& exception = thrown->value("exception", json::object());
    throw std::runtime_error("the page: " + exception.value("description", thrown->value("text", "an error")));
  }
  return answer.at("result").value("value", json());
}

std::string HeadlessBrowser::picture() {
  return from_base64(ask("Page.captureScreenshot", {{"format", "png"}}).at("data").get<std::string>());
}

void HeadlessBrowser::start(std::vector<std::string> command) {
  std::array<int, 2> commands{}, answers{};
  if (pipe2(commands.data(), O_CLOEXEC) != 0 || pipe2(answers.data(), O_CLOEXEC) != 0)
    throw std::system_error(errno, std::system_category(), "a pipe to the browser");
  std::vector<char*> arguments;
  for (std::string& argument : command) arguments.push_back(argument.data());
  arguments.push_back(nullptr);
  std::string temporary = "TMPDIR=" + folder_;
  std::vector<char*> environment{temporary.data()};
  for (char** each = environ; *each != nullptr; ++each)
    if (std::string_view(*each).substr(0, 7) != "TMPDIR=") environment.push_back(*each);
  environment.push_back(nullptr);
  process_ = fork();
  if (process_ < 0) throw std::system_error(errno, std::system_category(), "starting " + command.front());
  if (process_ == 0) {
    setpgid(0, 0);  // Ctrl-C in the terminal is for the owner, which ends this one
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    constexpr int kAbove = 10;  // the pipes may have the numbers 3 and 4, in either order
    const int in = fcntl(commands[0], F_DUPFD, kAbove), out = fcntl(answers[1], F_DUPFD, kAbove);
    const int nowhere = open("/dev/null", O_RDWR);
    for (const int standard : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) dup2(nowhere, standard);
    dup2(in, 3);
    dup2(out, 4);
    for (const int number : {in, out}) close(number);
    execve(arguments[0], arguments.data(), environment.data());
    _exit(ChildProgram::kNoProgram);
  }
  close(commands[0]);
  close(answers[1]);
  commands_ = commands[1];
  answers_ = answers[0];
}

json HeadlessBrowser::ask(const char* method, const json& parameters) {
  json request{{"id", ++last_}, {"method", method}, {"params", parameters}};
  if (!session_.empty()) request["sessionId"] = session_;
  const std::string text = request.dump();
  // Whole at once: requests are shorter than what a pipe takes, and one is under way at a time.
  if (write(commands_, text.c_str(), text.size() + 1) != static_cast<ssize_t>(text.size() + 1))
    throw std::runtime_error("the browser has ended");
  while (true) {
    const json answer = json::parse(next_message(), nullptr, false);
    if (!answer.is_object() || answer.value("id", 0) != last_) continue;  // an event
    if (answer.contains("error"))
      throw std::runtime_error("the browser: " + answer["error"].value("message", "an error"));
    return answer.at("result");
  }
}

std::string HeadlessBrowser::next_message() {
  const auto end_of_patience = std::chrono::steady_clock::now() + kAnswerPatience;
  while (true) {
    if (const std::size_t end = received_.find('\0'); end != std::string::npos) {
      std::string message = received_.substr(0, end);
      received_.erase(0, end + 1);
      return message;
    }
    if (stop_.stop_requested()) throw std::runtime_error("stopped");
    if (std::chrono::steady_clock::now() > end_of_patience) throw std::runtime_error("the browser does not answer");
    pollfd readable{answers_, POLLIN, 0};
    if (poll(&readable, 1, kLookMilliseconds) <= 0) continue;
    std::array<char, 1 << 16> bytes;
    const ssize_t count = read(answers_, bytes.data(), bytes.size());
    if (count <= 0) throw std::runtime_error("the browser has ended");
    received_.append(bytes.data(), static_cast<std::size_t>(count));
  }
}

}  // namespace acus::view
