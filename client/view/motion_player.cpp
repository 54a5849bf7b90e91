// SPDX-License-Identifier: MIT
#include "client/view/motion_player.h"

#include <system_error>
#include <utility>

namespace acus::view {

namespace {

// Exit statuses of acus-replay.
std::string reason_of(int status) {
  switch (status) {
    case 1:
      return "it does not fit this scene";
    case 2:
      return "the server refused it: does somebody hold the needle?";
    case 3:
      return "the server went away";
    case 4:
      return "states were lost on the way";
    case ChildProgram::kNoProgram:
      return "there is no acus-replay beside acus-view";
    default:
      return "acus-replay ended with status " + std::to_string(status);
  }
}

}  // namespace

void MotionPlayer::play(const std::string& name, const std::filesystem::path& trajectory, bool lockstep, Times times) {
  if (!playing_.empty()) return;
  arguments_ = {trajectory.string()};
  arguments_.insert(arguments_.end(), options_.begin(), options_.end());
  if (lockstep) arguments_.push_back("--lockstep");
  if (times == Times::to_and_fro) arguments_.insert(arguments_.end(), {"--passes", "2"});
  times_ = times;
  playing_ = name;
  stopped_ = false;
  start();
}

void MotionPlayer::start() {
  try {
    program_ = std::make_unique<ChildProgram>(context_, "acus-replay", arguments_, [this](int status) { end(status); });
  } catch (const std::system_error& error) {
    failed_(std::exchange(playing_, "") + " cannot be played: " + error.what());
  }
}

void MotionPlayer::stop() {
  stopped_ = true;
  if (program_) program_->ask_to_end();
}

void MotionPlayer::end(int status) {
  program_.reset();
  if (status == 0 && times_ == Times::to_and_fro && !stopped_) return start();
  const std::string name = std::exchange(playing_, "");
  if (status != 0 && !stopped_) failed_(name + " was not played to its end: " + reason_of(status));
}

}  // namespace acus::view
