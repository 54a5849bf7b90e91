// SPDX-License-Identifier: MIT
// Plays recorded motions into the server. acus-replay does that, as a client of its own with the server's rate.
#pragma once

#include <boost/asio/io_context.hpp>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "client/view/child_program.h"

namespace acus::view {

class MotionPlayer {
 public:
  // `options` say to acus-replay where the server is; `failed` is told in a sentence why a motion did not end well.
  MotionPlayer(boost::asio::io_context& context, std::vector<std::string> options,
               std::function<void(const std::string&)> failed)
      : context_(context), options_(std::move(options)), failed_(std::move(failed)) {}

  enum class Times { once, to_and_fro };  // the latter again and again, until it is stopped or does not end well

  // Nothing happens while one is being played.
  void play(const std::string& name, const std::filesystem::path& trajectory, bool lockstep, Times times = Times::once);
  void stop();

  const std::string& playing() const { return playing_; }  // empty: none is

 private:
  void start();
  void end(int status);

  boost::asio::io_context& context_;
  const std::vector<std::string> options_;
  const std::function<void(const std::string&)> failed_;
  std::string playing_;
  std::vector<std::string> arguments_;
  Times times_ = Times::once;
  bool stopped_ = false;
  std::unique_ptr<ChildProgram> program_;
};

}  // namespace acus::view
