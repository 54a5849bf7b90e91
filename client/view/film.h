// SPDX-License-Identifier: MIT
// A recording as pictures: the page in a browser without a window, from moment to moment, into PNG files or, by ffmpeg,
// into a film.
#pragma once

#include <functional>
#include <stop_token>
#include <string>
#include <utility>

namespace acus::view {

struct FilmOptions {
  std::string target;  // a folder for pictures, made if it is not there, or the file of a film (.mp4, .webm, .mkv)
  double rate = 30;    // pictures a second of simulation time
  std::pair<int, int> size{1280, 720};  // px
};

// What the options ask for and this machine cannot do, with the remedy; empty if it can.
std::string problem_with(const FilmOptions& options);

// Makes pictures of the recording whose page has the URL, and tells how many of how many are done. Blocks, until a
// request to stop at most. Throws std::runtime_error that says what went wrong; pictures made so far stay, a film does
// not.
void make_film(const std::string& url, const FilmOptions& options,
               const std::function<void(int done, int all)>& progress, const std::stop_token& stop);

}  // namespace acus::view
