// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/transport/recordings.h"

#include <algorithm>
#include <cctype>
#include <system_error>

#include "server/runtime/is_ready.h"
#include "server/transport/readable_text.h"

namespace acus {

namespace {

constexpr std::size_t kMaxName = 100;  // bytes

// Nothing that leads out of a folder, hides a file or surprises a shell.
bool is_plain(const std::string& name) {
  const auto plain = [](unsigned char c) { return std::isalnum(c) || c == '.' || c == '_' || c == '-'; };
  return !name.empty() && name.size() <= kMaxName && std::ranges::all_of(name, plain) && name[0] != '.' && name[0] != '-';
}

}  // namespace

void Recordings::begin(const std::string& path) {
  if (is_ending()) throw RecordingError("the recording before is still on its way to the disk; try again later");
  if (state() == protocol::RecordingState::on)
    throw RecordingError("'" + name() + "' is being recorded; end that with a 'record' without 'file' first");
  if (recorder_) throw RecordingError("'" + name() + "' ended by itself; say so with a 'record' without 'file' first");
  recorder_ = std::make_shared<Recorder>(path, server_);
}

void Recordings::begin_for_client(const std::string& name) {
  if (folder_.empty())
    throw RecordingError("this server keeps no recordings for clients; start it with --recordings FOLDER");
  if (!is_plain(name))
    throw RecordingError("field 'file' must be a name of letters, digits, '.', '_' and '-', at most " +
                         std::to_string(kMaxName) + ", found '" + readable(name, kMaxName) + "'");
  begin((std::filesystem::path(folder_) / name).string());
}

void Recordings::ask_to_end() {
  if (!recorder() || asked_to_end_) throw RecordingError("nothing is being recorded");
  asked_to_end_ = true;
}

void Recordings::end() {
  asked_to_end_ = false;
  const auto finish = [recorder = recorder_] { return recorder->finish(); };
  try {
    ending_ = std::async(std::launch::async, finish);
  } catch (const std::system_error&) {  // no thread to be had
    ending_ = std::async(std::launch::deferred, finish);
    ending_.wait();
  }
}

std::optional<Recordings::Ended> Recordings::take_ended() {
  if (!is_ending() || !is_ready(ending_)) return std::nullopt;
  Ended ended{name(), ending_.get()};
  recorder_.reset();
  return ended;
}

bool Recordings::finish() {
  if (is_ending()) return ending_.get();
  return !recorder_ || recorder_->finish();
}

std::string Recordings::name() const {
  return recorder_ ? std::filesystem::path(recorder_->path()).filename().string() : "";
}

protocol::RecordingState Recordings::state() const {
  using enum protocol::RecordingState;
  if (!recorder_) return off;
  if (is_ending()) return on;
  return recorder_->recording() ? on : failed;
}

}  // namespace acus
