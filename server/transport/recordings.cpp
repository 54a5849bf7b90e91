// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/transport/recordings.h"

#include <algorithm>
#include <cctype>
#include <system_error>

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
  if (state() == protocol::RecordingState::on)
    throw RecordingError("'" + name() + "' is being recorded; end that with a 'record' without 'file' first");
  if (recorder_) throw RecordingError("'" + name() + "' ended by itself; say so with a 'record' without 'file' first");
  if (ending_.valid() && ending_.wait_for(std::chrono::seconds(0)) != std::future_status::ready)
    throw RecordingError("the recording before is still on its way to the disk; try again later");
  recorder_ = std::make_unique<Recorder>(path, server_);
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
  if (!recorder_ || asked_to_end_) throw RecordingError("nothing is being recorded");
  asked_to_end_ = true;
}

void Recordings::end() {
  asked_to_end_ = false;
  try {
    ending_ = std::async(std::launch::async, [ending = std::move(recorder_)]() mutable { ending.reset(); });
  } catch (const std::system_error&) {  // no thread to be had: it was done here
  }
}

std::string Recordings::name() const {
  return recorder_ ? std::filesystem::path(recorder_->path()).filename().string() : "";
}

protocol::RecordingState Recordings::state() const {
  using enum protocol::RecordingState;
  if (!recorder_) return off;
  return recorder_->recording() ? on : failed;
}

}  // namespace acus
