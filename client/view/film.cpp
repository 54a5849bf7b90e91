// SPDX-License-Identifier: MIT
#include "client/view/film.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <system_error>

#include "client/view/headless_browser.h"

namespace acus::view {

namespace {

constexpr double kMostPictures = 100'000;

bool is_film(const std::string& target) {
  std::string ending = std::filesystem::path(target).extension().string();
  std::ranges::transform(ending, ending.begin(), [](unsigned char letter) { return std::tolower(letter); });
  return ending == ".mp4" || ending == ".webm" || ending == ".mkv";
}

std::string quoted(const std::string& word) {
  std::string result = "'";
  for (const char character : word) result += character == '\'' ? std::string("'\\''") : std::string(1, character);
  return result + "'";
}

// Where pictures go: files of a folder, or a pipe to ffmpeg.
class Pictures {
 public:
  explicit Pictures(const FilmOptions& options) : target_(options.target) {
    if (!is_film(target_)) {
      std::filesystem::create_directories(target_);
      return;
    }
    std::FILE* file = std::fopen(target_.c_str(), "wxe");  // nobody else's, which ffmpeg may replace and this removes
    if (file == nullptr) throw std::runtime_error(target_ + " cannot be made anew: " + std::strerror(errno));
    std::fclose(file);
    // Films have pixels by four, hence even sizes.
    const std::string command = "ffmpeg -y -loglevel error -f image2pipe -framerate " + std::to_string(options.rate) +
                                " -i - -vf 'pad=ceil(iw/2)*2:ceil(ih/2)*2' -pix_fmt yuv420p " +
                                quoted("file:" + target_);
    ffmpeg_ = popen(command.c_str(), "we");
    if (ffmpeg_ == nullptr) throw std::runtime_error("ffmpeg cannot be started");
  }
  ~Pictures() {
    if (ffmpeg_ == nullptr) return;
    pclose(ffmpeg_);
    std::error_code ignored;
    std::filesystem::remove(target_, ignored);
  }
  Pictures(const Pictures&) = delete;
  Pictures& operator=(const Pictures&) = delete;

  void add(const std::string& picture) {
    if (ffmpeg_ != nullptr) {
      if (!written(picture, ffmpeg_)) throw std::runtime_error("ffmpeg has ended early");
      return;
    }
    std::array<char, 16> name{};
    std::snprintf(name.data(), name.size(), "%06d.png", ++count_);
    const std::string path = target_ + "/" + name.data();
    std::FILE* file = std::fopen(path.c_str(), "wbxe");
    if (file == nullptr) throw std::runtime_error(path + " cannot be made anew: " + std::strerror(errno));
    const bool whole = written(picture, file);
    if (std::fclose(file) != 0 || !whole) throw std::runtime_error(path + " could not be written whole");
  }

  void finish() {
    if (ffmpeg_ != nullptr && pclose(std::exchange(ffmpeg_, nullptr)) != 0)
      throw std::runtime_error("ffmpeg could not make " + target_);
  }

 private:
  static bool written(const std::string& bytes, std::FILE* file) {
    return std::fwrite(bytes.data(), 1, bytes.size(), file) == bytes.size();
  }

  const std::string target_;
  std::FILE* ffmpeg_ = nullptr;
  int count_ = 0;
};

}  // namespace

std::string problem_with(const FilmOptions& options) {
  std::error_code ignored;
  if (!has_browser()) return "needs chromium, which is not there; install it";
  if (is_film(options.target)) {
    if (find_program("ffmpeg").empty()) return "needs ffmpeg, which is not there; install it, or name a folder";
    if (std::filesystem::exists(options.target, ignored)) return "there is such a file already";
    const auto folder = std::filesystem::path(options.target).parent_path();
    if (!folder.empty() && !std::filesystem::is_directory(folder, ignored)) return "there is no such folder";
    return "";
  }
  if (!std::filesystem::exists(options.target, ignored)) return "";
  if (!std::filesystem::is_directory(options.target, ignored))
    return "expected a folder, or a file that ends in .mp4, .webm or .mkv";
  if (!std::filesystem::is_empty(options.target, ignored)) return "expected an empty folder, or a new one";
  return "";
}

void make_film(const std::string& url, const FilmOptions& options,
               const std::function<void(int done, int all)>& progress, const std::stop_token& stop) {
  HeadlessBrowser browser(url, options.size.first, options.size.second, stop);
  // The page's script may not have run yet.
  const double length = browser.evaluate(
      "new Promise((done) => { const look = () => window.acus?.standing.run?.whole ? done(acus.standing.run.length)"
      " : setTimeout(look, 50); look(); })");
  const double pictures_after_first = std::floor(length * options.rate + 1e-6);
  if (pictures_after_first >= kMostPictures) throw std::runtime_error("too many pictures; give a lower --rate");
  const int all = static_cast<int>(pictures_after_first) + 1;
  Pictures pictures(options);
  for (int i = 0; i < all; ++i) {
    browser.evaluate("acus.show(" + std::to_string(i / options.rate) + ")");
    pictures.add(browser.picture());
    progress(i + 1, all);
  }
  pictures.finish();
}

}  // namespace acus::view
