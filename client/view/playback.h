// SPDX-License-Identifier: MIT
// A recording that is shown as a server's states would be, with a time line: acus-export runs it again, as a process of
// its own, and what is there already can be looked at meanwhile.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "client/view/child_program.h"
#include "client/view/message_index.h"
#include "client/view/source.h"

namespace acus::view {

class Playback : public Source {
 public:
  struct Told {
    // That what is shown is now of another time: all before it is void, and what follows are messages of before that
    // time, for curves and lists.
    std::function<void()> jumped;
    std::function<void(const Frame&)> past;
    std::function<void(int status)> ended;  // acus-export, with its status
  };

  // Throws std::system_error if acus-export cannot be started.
  Playback(boost::asio::io_context& context, const std::string& recording, Listener listener, Told told);
  ~Playback() override;

  bool here() const override { return index_.frames() > 0; }
  bool lockstep() const override { return false; }
  Bytes hello() const override { return hello_; }
  Bytes describe() const override { return describe_; }
  void watch(bool wanted) override { watched_ = wanted; }
  void begin_driving() override {}
  void end_driving() override {}
  void drive(std::string_view) override {}

  // Seconds of simulation time from the beginning of the recording.
  double at() const { return static_cast<double>(frame_) / rate_; }
  double length() const { return index_.frames() < 2 ? 0 : static_cast<double>(index_.frames() - 1) / rate_; }
  bool whole() const { return whole_; }  // all of the recording is there
  bool playing() const { return playing_; }
  void play(bool wanted);
  void seek(double seconds);
  // Shows again what is shown, to one who has come.
  void show_again();

 private:
  void beat();
  void take_in();
  void show(std::size_t frame);

  boost::asio::steady_timer clock_;
  const Listener listener_;
  const Told told_;
  std::filesystem::path folder_;
  MessageIndex index_;
  std::unique_ptr<ChildProgram> program_;
  Bytes hello_, describe_;
  double rate_ = 60;  // Hz, of frames
  std::size_t frame_ = 0;
  double due_ = 0;  // frames that should have been shown, while it plays
  std::chrono::steady_clock::time_point beaten_;
  bool whole_ = false, exported_ = false, playing_ = true, watched_ = false, shown_ = false;
};

}  // namespace acus::view
