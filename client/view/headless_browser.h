// SPDX-License-Identifier: MIT
// Chromium without a window, which shows one page and takes pictures of it. It is told what to do over two pipes
// (--remote-debugging-pipe: JSON of the DevTools protocol, each message ended by a zero byte).
#pragma once

#include <sys/types.h>

#include <nlohmann/json.hpp>
#include <stop_token>
#include <string>
#include <vector>

namespace acus::view {

// The file of a program that the shell would find; empty if there is none.
std::string find_program(const std::string& name);

// Whether there is a browser for it.
bool has_browser();

// All that it does blocks. Throws std::runtime_error if there is no browser, if it ends, or after a request to stop.
class HeadlessBrowser {
 public:
  // width, height (px) of the page.
  HeadlessBrowser(const std::string& url, int width, int height, std::stop_token stop);
  ~HeadlessBrowser();  // ends the browser, and waits
  HeadlessBrowser(const HeadlessBrowser&) = delete;
  HeadlessBrowser& operator=(const HeadlessBrowser&) = delete;

  // The value of an expression of JavaScript, awaited if it is a promise.
  nlohmann::json evaluate(const std::string& expression);
  // The bytes of a PNG file.
  std::string picture();

 private:
  explicit HeadlessBrowser(std::stop_token stop);
  void end();
  void start(std::vector<std::string> command);
  nlohmann::json ask(const char* method, const nlohmann::json& parameters);
  std::string next_message();

  const std::string folder_;
  const std::stop_token stop_;
  pid_t process_ = -1;
  int commands_ = -1, answers_ = -1, last_ = 0;
  std::string session_, received_;
};

}  // namespace acus::view
