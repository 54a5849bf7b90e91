// SPDX-License-Identifier: MIT
#include "client/view/playback.h"

#include <algorithm>
#include <cmath>
#include <system_error>
#include <utility>
#include <variant>

#include "protocol/codec.h"

namespace acus::view {

namespace {

constexpr auto kFramePeriod = std::chrono::microseconds(16'666);
constexpr std::size_t kHistory = 1200;  // frames of forces that a jump tells of again, at most, over all that is before
constexpr std::size_t kStride = 2;      // frames from one of those to the next, at least

}  // namespace

Playback::Playback(boost::asio::io_context& context, const std::string& recording, Listener listener, Told told)
    : clock_(context),
      listener_(std::move(listener)),
      told_(std::move(told)),
      folder_(new_folder()),
      index_((folder_ / "messages").string()),
      beaten_(std::chrono::steady_clock::now()) {
  program_ = std::make_unique<ChildProgram>(
      context, "acus-export",
      std::vector<std::string>{recording, "--messages", (folder_ / "messages").string(), "--quiet"},
      [this](int status) {
        exported_ = true;
        told_.ended(status);
      });
  beat();
}

Playback::~Playback() {
  program_.reset();
  std::error_code ignored;
  std::filesystem::remove_all(folder_, ignored);
}

void Playback::beat() {
  take_in();
  const auto now = std::chrono::steady_clock::now();
  const double passed = std::chrono::duration<double>(now - std::exchange(beaten_, now)).count();
  if (here() && watched_ && !std::exchange(shown_, true)) show(frame_);
  if (playing_ && shown_ && watched_) {
    const std::size_t last = index_.frames() - 1;
    due_ = std::min(due_ + passed * rate_, static_cast<double>(last));
    while (frame_ < static_cast<std::size_t>(due_)) show(++frame_);
    if (whole_ && frame_ == last) playing_ = false;
  }
  clock_.expires_after(kFramePeriod);
  clock_.async_wait([this](const boost::system::error_code& error) {
    if (!error) beat();
  });
}

void Playback::take_in() {
  if (whole_) return;
  const bool all = exported_;  // before the last look
  const bool was_here = here();
  const bool more = index_.read_on();
  if (all && !more) {
    whole_ = true;
    index_.close();
  }
  if (!hello_ && !index_.describe().empty()) {
    hello_ = std::make_shared<const std::string>(index_.hello());
    describe_ = std::make_shared<const std::string>(index_.describe());
    const auto hello = std::get<protocol::HelloReply>(protocol::decode_reply(*hello_));
    for (const protocol::TopicInfo& topic : hello.topics)
      if (topic.name == "needle") rate_ = topic.rate;
  }
  if (here() && !was_here) listener_.arrived();
}

void Playback::show(std::size_t frame) { index_.visit(frame, listener_.state); }

void Playback::play(bool wanted) {
  playing_ = wanted && here();
  if (playing_ && whole_ && frame_ + 1 == index_.frames()) seek(0);
  due_ = static_cast<double>(frame_);
}

void Playback::seek(double seconds) {
  if (!here() || !(seconds >= 0)) return;
  frame_ = static_cast<std::size_t>(std::min(std::round(seconds * rate_), static_cast<double>(index_.frames() - 1)));
  due_ = static_cast<double>(frame_);
  show_again();
}

void Playback::show_again() {
  if (!here()) return;
  told_.jumped();
  index_.visit_history(0, frame_, std::max(kStride, frame_ / kHistory + 1), told_.past);
  show(frame_);
}

}  // namespace acus::view
