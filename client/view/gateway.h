// SPDX-License-Identifier: MIT
// Passes between pages and the server, or a recording; door.h lets pages in.
//
// On a WebSocket (`/link`), binary messages are the server's own, unchanged (protocol/README.md): states, acus-cloud's
// among them, and, to the one that drives, answers; from the one that drives, requests and streams. Text messages are
// the gateway's, JSON:
//
//   page     {"token": "..."}     first of all: that of the URL
//            {"drive": true}      asks to drive; {"drive": false} gives it back
//            {"play": "NAME"}     asks for a motion of `choices`; {"play": null} ends it. Not while another page drives
//            {"run": bool}        plays the recording, or stops it; {"seek": s} shows another moment, its end for what
//            is
//                                 beyond; below 0 nothing
//            {"branch": bool}     goes on from the moment that is shown, with a server; or back to the recording
//            {"beat": k}          has taken in all that came before the gateway's own; a page that is slower gets less
//   gateway  {"scenes": {NAME: MOTION...}, "motions": [NAME...], "records": bool}
//            what there is to choose from, with the motion that is made for each scene, "" for none, and whether GET
//            /recordings/NAME (Authorization: Bearer TOKEN) gives what the server has recorded; it stays until DELETE
//            of the same says that it has been saved
//            {"server": bool, "driving": bool, "driven": bool, "playing": NAME, "viewers": n, "lost": n, "run": null or
//             {"at": s, "length": s, "whole": bool, "playing": bool, "live": bool}}
//            whether the server answers, whether this page drives, whether any does, which motion is played, how many
//            look, how many events this page was not sent; of a recording which moment is shown, how much of it is
//            there, whether that is all, whether it plays, whether a server has gone on from it
//            {"jump": s}          what was told so far is void: another moment is shown. Forces and events of before
//                                 follow, then its shapes
//            {"notice": "..."}    a sentence to show
//            {"beat": k}          behind what left at one time
//
// Any number may look, as far as kMostPages; one drives.
#pragma once

#include <boost/asio/io_context.hpp>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "client/view/cloud_link.h"
#include "client/view/motion_player.h"
#include "client/view/page_files.h"
#include "client/view/playback.h"
#include "client/view/scene_folder.h"
#include "client/view/server_link.h"
#include "client/view/started_server.h"

namespace acus::view {

// A page that looks: what the gateway says to it.
class Page {
 public:
  // What the server said, to leave when there is room.
  virtual void put(const Frame& frame) = 0;
  virtual void say(const std::string& words) = 0;
  virtual void tell_of_the_scene() = 0;  // its `hello_reply` and `describe_reply`, if they have changed
  // What follows is of another moment (s) of the recording, and before that come messages of its past.
  virtual void jump(double moment) = 0;
  virtual void recall(const Frame& frame) = 0;

 protected:
  ~Page() = default;
};

class Gateway {
 public:
  static constexpr std::size_t kMostPages = 64;

  struct Options {
    ServerAddress server;
    std::string run;                                  // a recording to show instead of a server; empty: none
    std::function<void(int status)> run_is_unusable;  // of acus-export, which has said why
    std::map<std::string, PageFile> page;
    SceneFolder scenes;
    std::string recordings;              // folder that the server records into; empty: not known
    std::vector<std::string> to_server;  // options that tell a program where the server is
    std::optional<CloudOptions> cloud;   // none: no cloud is drawn
    std::string first_motion;            // to be played to and fro once the first page looks; empty: none
  };

  // Throws client::ClientError for the server's address.
  Gateway(boost::asio::io_context& context, Options options);

  // For connections and viewers.
  const Options& options() const { return options_; }
  const std::string& token() const { return token_; }
  bool is_token(std::string_view token) const;
  const Source& source() const { return *source_; }
  bool driven() const { return driver_ != nullptr; }
  std::size_t viewers() const { return pages_.size(); }
  bool add(Page& page);  // false: there are too many
  void remove(Page& page);
  bool is_driver(const Page& page) const { return driver_ == &page; }
  void begin_driving(Page& page);  // nothing happens while another drives
  void end_driving(Page& page);
  void drive(Page& page, std::string_view message);
  const std::string& choices() const { return choices_; }
  const std::string& playing() const { return player_.playing(); }
  void play(Page& page, const std::string& motion);
  void stop_playing(Page& page);
  // Of the recording, where one is shown.
  const Playback* run() const { return run_.get(); }
  bool live() const { return source_ != run_.get(); }
  void welcome();  // shows one who has come what is shown
  void play_run(bool wanted);
  void seek(double seconds);
  void branch(Page& page, bool wanted);

 private:
  bool others_drive(const Page& page) const { return driver_ != nullptr && driver_ != &page; }
  Source::Listener listener();
  void begin_cloud();
  void begin_run();
  void show(Source& source);
  void go_live();
  void back_to_the_run();
  void end_of_export(int status);
  void play_first();
  void say(const std::string& words);

  Options options_;
  std::string token_;
  std::set<Page*> pages_;
  Page* driver_ = nullptr;
  std::string choices_;  // JSON
  boost::asio::io_context& context_;
  std::unique_ptr<Playback> run_;
  std::unique_ptr<StartedServer> branched_;
  std::unique_ptr<ServerLink> server_;
  Source* source_ = nullptr;  // one of them
  std::unique_ptr<CloudLink> cloud_;
  MotionPlayer player_;
};

}  // namespace acus::view
