// SPDX-License-Identifier: MIT
#include "client/view/gateway.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <random>
#include <string_view>

namespace acus::view {

namespace {

namespace asio = boost::asio;

std::string draw_token() {
  std::random_device device;
  std::string token;
  for (int i = 0; i < 32; ++i) token += "0123456789abcdef"[device() & 15];
  return token;
}

}  // namespace

Gateway::Gateway(asio::io_context& context, Options options)
    : options_(std::move(options)),
      token_(draw_token()),
      context_(context),
      player_(context, options_.to_server, [this](const std::string& why) { say(why); }) {
  nlohmann::json scenes = nlohmann::json::object();
  for (const std::string& scene : options_.scenes.scenes) scenes[scene] = motion_for(options_.scenes, scene);
  choices_ =
      nlohmann::json{
          {"scenes", scenes}, {"motions", options_.scenes.motions}, {"records", !options_.recordings.empty()}}
          .dump();
  if (options_.run.empty()) {
    server_ = std::make_unique<ServerLink>(context_, options_.server, listener());
    source_ = server_.get();
  } else {
    begin_run();
  }
  begin_cloud();
}

// In the same time wherever they differ.
bool Gateway::is_token(std::string_view token) const {
  unsigned differing = token.size() != token_.size();
  for (std::size_t i = 0; i < token_.size(); ++i)
    differing |= static_cast<unsigned>(token_[i] ^ (i < token.size() ? token[i] : '\0'));
  return differing == 0;
}

bool Gateway::add(Page& page) {
  if (pages_.size() >= kMostPages) return false;
  pages_.insert(&page);
  source_->watch(true);
  play_first();
  return true;
}

void Gateway::remove(Page& page) {
  end_driving(page);
  pages_.erase(&page);
  source_->watch(!pages_.empty());
}

void Gateway::begin_driving(Page& page) {
  if (driver_ != nullptr) return;
  try {
    source_->begin_driving();
    driver_ = &page;
  } catch (const std::exception&) {  // out of descriptors: nobody drives
  }
}

void Gateway::end_driving(Page& page) {
  if (driver_ != &page) return;
  driver_ = nullptr;
  source_->end_driving();
}

void Gateway::drive(Page& page, std::string_view message) {
  if (driver_ == &page) source_->drive(message);
}

Source::Listener Gateway::listener() {
  return {[this](const Frame& frame) {
            for (Page* page : pages_) page->put(frame);
          },
          [this](const Frame& frame) {
            if (driver_ != nullptr) driver_->put(frame);
          },
          [this] { play_first(); }};
}

void Gateway::begin_cloud() {
  if (!options_.cloud) return;
  cloud_ = std::make_unique<CloudLink>(
      context_, *options_.cloud, options_.to_server,
      [this](const Frame& frame) {
        for (Page* page : pages_) page->put(frame);
      },
      [this](const std::string& why) { say(why); });
}

void Gateway::begin_run() {
  Playback::Told told{[this] {
                        for (Page* page : pages_) page->jump(run_->at());
                      },
                      [this](const Frame& frame) {
                        for (Page* page : pages_) page->recall(frame);
                      },
                      [this](int status) { end_of_export(status); }};
  run_ = std::make_unique<Playback>(context_, options_.run, listener(), std::move(told));
  source_ = run_.get();
}

// Exit statuses of acus-export.
void Gateway::end_of_export(int status) {
  if (status == 4) return say("on this machine the recording comes out otherwise: shown is what comes out here");
  if (status == 5) return say("a part of the recording is damaged: shown is what stands before it");
  if (status == 0) return;
  if (run_->here())
    return say("acus-export has ended with status " + std::to_string(status) + ": shown is what it had made");
  options_.run_is_unusable(status);
}

void Gateway::show(Source& source) {
  if (driver_ != nullptr) end_driving(*driver_);
  source_->watch(false);
  source_ = &source;
  source_->watch(!pages_.empty());
}

void Gateway::welcome() {
  if (run_ && !live()) run_->show_again();
}

void Gateway::play_run(bool wanted) {
  if (run_ && !live()) run_->play(wanted);
}

void Gateway::seek(double seconds) {
  if (run_ && !live()) run_->seek(seconds);
}

void Gateway::branch(Page& page, bool wanted) {
  if (!run_ || wanted == live() || others_drive(page)) return;
  try {
    if (wanted) {
      go_live();
    } else {
      back_to_the_run();
    }
  } catch (const std::exception& error) {
    say(error.what());
  }
}

void Gateway::go_live() {
  run_->play(false);
  char moment[32];
  std::snprintf(moment, sizeof moment, "%.6f", run_->at());
  branched_ = std::make_unique<StartedServer>(context_, options_.run,
                                              std::vector<std::string>{"--at", moment, "--paused"}, [this](int status) {
                                                back_to_the_run();
                                                say("the server has ended with status " + std::to_string(status));
                                              });
  server_ = std::make_unique<ServerLink>(context_, branched_->address(), listener());
  show(*server_);
}

void Gateway::back_to_the_run() {
  show(*run_);
  server_.reset();
  branched_.reset();
  for (Page* page : pages_) page->tell_of_the_scene();
  run_->show_again();
}

void Gateway::play_first() {
  if (options_.first_motion.empty() || pages_.empty() || !source_->here()) return;
  const std::string motion = std::exchange(options_.first_motion, "");
  player_.play(motion, options_.scenes.motion(motion), source_->lockstep(), MotionPlayer::Times::to_and_fro);
}

void Gateway::play(Page& page, const std::string& motion) {
  const auto& motions = options_.scenes.motions;
  if (others_drive(page)) return;
  if (std::find(motions.begin(), motions.end(), motion) == motions.end()) return;
  player_.play(motion, options_.scenes.motion(motion), source_->lockstep());
}

void Gateway::stop_playing(Page& page) {
  if (!others_drive(page)) player_.stop();
}

void Gateway::say(const std::string& words) {
  for (Page* page : pages_) page->say(words);
}

}  // namespace acus::view
