// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/recording/recording_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <memory>

namespace acus {

namespace {

constexpr int kLevel = 3;                             // of compression
constexpr std::size_t kChunk = std::size_t{1} << 16;  // bytes read at a time
static_assert(std::endian::native == std::endian::little, "zstd's magic number is little-endian");
constexpr std::size_t kMaxFrame = std::size_t{1} << 28;  // bytes, packed and unpacked: a mesh and a state stay below

RecordingError system_error(const std::string& path, const char* what) {
  return RecordingError(path + ": " + what + ": " + std::strerror(errno));
}

int open_to_read(const std::string& path) {
  const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) throw system_error(path, "the recording cannot be read");
  return file;
}

ssize_t read_retrying(int file, char* to, std::size_t size) {
  ssize_t count = 0;
  do count = read(file, to, size);
  while (count < 0 && errno == EINTR);
  return count;
}

}  // namespace

// ---- Writing ----

RecordingWriter::RecordingWriter(std::string path)
    : path_(std::move(path)), file_(open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644)) {
  if (file_ >= 0) return;
  if (errno == EEXIST) throw RecordingError(path_ + ": there is a file of this name already; give the recording another one");
  throw system_error(path_, "the recording cannot be written");
}

RecordingWriter::~RecordingWriter() { close(file_); }

void RecordingWriter::flush() {
  if (pending_.empty()) return;
  packed_.resize(ZSTD_compressBound(pending_.size()));
  const std::unique_ptr<ZSTD_CCtx, decltype(&ZSTD_freeCCtx)> context(ZSTD_createCCtx(), ZSTD_freeCCtx);
  if (!context) throw RecordingError("no memory to pack the recording");
  ZSTD_CCtx_setParameter(context.get(), ZSTD_c_compressionLevel, kLevel);
  ZSTD_CCtx_setParameter(context.get(), ZSTD_c_checksumFlag, 1);
  const std::size_t size =
      ZSTD_compress2(context.get(), packed_.data(), packed_.size(), pending_.data(), pending_.size());
  if (ZSTD_isError(size)) throw RecordingError(std::string("the recording cannot be packed: ") + ZSTD_getErrorName(size));
  pending_.clear();
  for (std::size_t written = 0; written < size;) {
    const ssize_t count = pwrite(file_, packed_.data() + written, size - written, static_cast<off_t>(end_ + written));
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) {
      const RecordingError error(std::string("the recording cannot be written on: ") + std::strerror(errno));
      [[maybe_unused]] const int cut = ftruncate(file_, static_cast<off_t>(end_));  // a reader finds the end anyway
      throw error;
    }
    written += static_cast<std::size_t>(count);
  }
  end_ += size;
  struct stat now {};
  if (fstat(file_, &now) == 0 && now.st_nlink == 0) throw RecordingError("the recording's file has been removed");
}

// ---- Reading ----

RecordingReader::RecordingReader(const std::string& path) : file_(open_to_read(path)) {
  try {
    const std::optional<recorded::Item> first = next();
    const auto* opening = first ? std::get_if<recorded::Opening>(&*first) : nullptr;
    if (!opening) throw RecordingError("this is no recording of Acus");
    if (opening->version != recorded::Opening().version)
      throw RecordingError("the recording has version " + std::to_string(opening->version) + " of the format, this is for " +
                           std::to_string(recorded::Opening().version));
    opening_ = *opening;
  } catch (const RecordingError& error) {
    close(file_);
    throw RecordingError(path + ": " + error.what());
  }
}

RecordingReader::~RecordingReader() { close(file_); }

std::optional<recorded::Item> RecordingReader::next() {
  while (!ended_ && items_.empty()) ended_ = !read_frame();
  if (ended_) return std::nullopt;
  recorded::Item item = take_item(items_);
  if (const auto* ending = std::get_if<recorded::Ending>(&item)) end(ending->why);
  return item;
}

void RecordingReader::end(const std::string& why) {
  ended_ = true;
  problem_ = why;
  if (!items_.empty() || !buffer_.empty() || fill()) fail("something stands behind its end, which was not looked at");
}

// Returns false.
bool RecordingReader::fail(const std::string& why) {
  problem_ = why;
  damaged_ = true;
  return false;
}

// False, and why, where there is no whole frame any more.
bool RecordingReader::read_frame() {
  std::size_t size = ZSTD_findFrameCompressedSize(buffer_.data(), buffer_.size());
  while (ZSTD_isError(size) && buffer_.size() < kMaxFrame && fill())
    size = ZSTD_findFrameCompressedSize(buffer_.data(), buffer_.size());
  if (ZSTD_isError(size)) {
    if (!buffer_.empty()) return fail("what stands from byte " + std::to_string(offset_) + " on is damaged or not whole");
    problem_ = "it was not ended: its program was killed, its disk was full, or it is still being written";
    return false;
  }
  const unsigned long long content = ZSTD_getFrameContentSize(buffer_.data(), size);
  if (content <= kMaxFrame) {  // the codes for errors are above it
    unpacked_.resize(content);
    const std::size_t unpacked = ZSTD_decompress(unpacked_.data(), unpacked_.size(), buffer_.data(), size);
    if (!ZSTD_isError(unpacked)) {
      unpacked_.resize(unpacked);
      items_ = unpacked_;
      buffer_.erase(0, size);
      offset_ += size;
      return true;
    }
  }
  return fail("its part at byte " + std::to_string(offset_) + " is damaged");
}

// Reads on; false at the end of the file.
bool RecordingReader::fill() {
  const std::size_t before = buffer_.size();
  const std::size_t wanted = std::max(kChunk, before);  // so that long frames are not looked at too often
  buffer_.resize(before + wanted);
  const ssize_t count = read_retrying(file_, buffer_.data() + before, wanted);
  buffer_.resize(before + static_cast<std::size_t>(std::max<ssize_t>(0, count)));
  return count > 0;
}

// ---- Looking at ----

bool is_recording(const std::string& path) {
  struct stat status {};
  if (stat(path.c_str(), &status) != 0 || !S_ISREG(status.st_mode)) return false;
  std::array<char, 4> first{};
  std::ifstream(path, std::ios::binary).read(first.data(), first.size());
  const std::uint32_t magic = ZSTD_MAGICNUMBER;
  return std::memcmp(first.data(), &magic, first.size()) == 0;
}

RecordingLength length_of(const std::string& path) {
  RecordingReader reader(path);
  RecordingLength length;
  length.opening = reader.opening();
  double time_step = 0;
  while (const std::optional<recorded::Item> item = reader.next()) {
    if (const auto* world = std::get_if<recorded::World>(&*item)) time_step = 1 / world->rate;
    if (std::holds_alternative<recorded::Beginning>(*item)) length.begun = true;
    if (!std::holds_alternative<recorded::Tick>(*item)) continue;
    length.seconds += time_step;
    length.time_step = time_step;
  }
  length.problem = reader.problem();
  length.damaged = reader.damaged();
  return length;
}

}  // namespace acus
