// SPDX-License-Identifier: MIT
#include "client/view/gateway.h"

#include <fcntl.h>

#include <algorithm>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <cctype>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <random>
#include <string_view>

#include "client/view/viewer.h"

namespace acus::view {

namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using asio::ip::tcp;

constexpr auto kRequestPatience = std::chrono::seconds(10);  // for a request to come, and an answer to leave
constexpr auto kDownloadPatience = std::chrono::minutes(5);  // for any byte of a recording to leave
constexpr int kDownloadBuffer = 64 << 10;  // bytes, of the kernel: they leave evenly however slowly they are read
constexpr auto kPause = std::chrono::milliseconds(100);
constexpr unsigned kLargestHeader = 16 << 10;  // bytes
constexpr const char* kRecordings = "/recordings/";
constexpr const char* kPolicy =
    "default-src 'self'; img-src 'self' data:; frame-ancestors 'none'; base-uri 'none'; form-action 'none'";

std::string draw_token() {
  std::random_device device;
  std::string token;
  for (int i = 0; i < 32; ++i) token += "0123456789abcdef"[device() & 15];
  return token;
}

std::string_view view_of(beast::string_view text) { return {text.data(), text.size()}; }

// Whatever the port: ssh may carry another one here.
bool is_this_machine(std::string_view host) {
  const std::string_view name = host.substr(0, host.find(':'));
  return name == "127.0.0.1" || name == "localhost";
}

// Of what the server gives recordings.
bool is_plain(std::string_view name) {
  const auto plain = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) || c == '.' || c == '_' || c == '-';
  };
  return !name.empty() && name.front() != '.' && std::all_of(name.begin(), name.end(), plain);
}

// One connection of a browser: requests for files, and the one that makes it a WebSocket.
class Connection : public std::enable_shared_from_this<Connection> {
 public:
  Connection(tcp::socket socket, Gateway& gateway, Place place)
      : stream_(std::move(socket)), gateway_(gateway), place_(std::move(place)) {}

  void read() {
    parser_.emplace();
    parser_->header_limit(kLargestHeader);
    stream_.expires_after(kRequestPatience);
    place_.wait([connection = weak_from_this()] {
      if (const auto self = connection.lock()) self->stream_.close();
    });
    http::async_read(stream_, buffer_, *parser_,
                     [self = shared_from_this()](const beast::error_code& error, std::size_t) {
                       self->place_.serve();
                       if (!error) self->answer(self->parser_->get());
                     });
  }

 private:
  using Request = http::request<http::empty_body>;

  void answer(const Request& request) {
    const std::string_view host = view_of(request[http::field::host]);
    if (!is_this_machine(host)) return refuse(http::status::forbidden, "expected 127.0.0.1 or localhost in Host");
    if (beast::websocket::is_upgrade(request)) {
      if (request.target() != "/link") return refuse(http::status::not_found, "expected /link");
      if (view_of(request[http::field::origin]) != "http://" + std::string(host))
        return refuse(http::status::forbidden, "expected the gateway's own page in Origin");
      std::make_shared<Viewer>(std::move(stream_), gateway_, std::move(place_))->begin(request);
      return;
    }
    if (request.target().starts_with(kRecordings)) return answer_for_recording(request);
    if (request.method() != http::verb::get && request.method() != http::verb::head)
      return refuse(http::status::method_not_allowed, "expected GET");
    const auto file = gateway_.options().page.find(std::string(view_of(request.target())));
    if (file == gateway_.options().page.end()) return refuse(http::status::not_found, "no such file");
    send(http::status::ok, file->second, request.method() == http::verb::head, request.keep_alive());
  }

  // Where it is, it stays until somebody who has the token says that it is saved.
  void answer_for_recording(const Request& request) {
    constexpr std::string_view kScheme = "Bearer ";
    const std::string_view credentials = view_of(request[http::field::authorization]);
    if (!credentials.starts_with(kScheme) || !gateway_.is_token(credentials.substr(kScheme.size())))
      return refuse(http::status::unauthorized, "expected the token in Authorization");
    const std::string name(view_of(request.target()).substr(std::strlen(kRecordings)));
    const std::string file = gateway_.options().recordings + "/" + name;
    std::error_code error;
    if (!is_plain(name) || gateway_.options().recordings.empty() || !std::filesystem::is_regular_file(file, error))
      return refuse(http::status::not_found, "no such recording");
    if (request.method() == http::verb::get) return hand_out(file);
    if (request.method() != http::verb::delete_)
      return refuse(http::status::method_not_allowed, "expected GET or DELETE");
    if (!std::filesystem::remove(file, error)) return refuse(http::status::not_found, "no such recording");
    send(http::status::ok, {"text/plain; charset=utf-8", "removed\n"}, false, request.keep_alive());
  }

  void hand_out(const std::string& file) {
    const auto response = std::make_shared<http::response<http::file_body>>(http::status::ok, 11);
    beast::error_code error;
    response->body().open(file.c_str(), beast::file_mode::scan, error);
    if (error) return refuse(http::status::not_found, "no such recording");
    response->set(http::field::content_type, "application/octet-stream");
    response->prepare_payload();
    stream_.socket().set_option(asio::socket_base::send_buffer_size(kDownloadBuffer), error);
    respond(response, false, kDownloadPatience);
  }

  void refuse(http::status status, const char* why) {
    send(status, {"text/plain; charset=utf-8", why + std::string("\n")}, false);
  }

  void send(http::status status, const PageFile& file, bool head, bool keep_alive = false) {
    auto response = std::make_shared<http::response<http::string_body>>(status, 11, head ? "" : file.bytes);
    response->set(http::field::content_type, file.type);
    response->content_length(file.bytes.size());
    respond(response, keep_alive && !head);
  }

  template <class Body>
  void respond(const std::shared_ptr<http::response<Body>>& response, bool keep_alive,
               std::chrono::seconds patience = kRequestPatience) {
    response->set(http::field::cache_control, "no-store");
    response->set("Content-Security-Policy", kPolicy);
    response->set("Cross-Origin-Opener-Policy", "same-origin");
    response->set("Cross-Origin-Resource-Policy", "same-origin");
    response->set("Referrer-Policy", "no-referrer");
    response->set("X-Content-Type-Options", "nosniff");
    response->keep_alive(keep_alive);
    write_on(std::make_shared<Leaving<Body>>(response, patience));
  }

  template <class Body>
  struct Leaving {
    Leaving(std::shared_ptr<http::response<Body>> what, std::chrono::seconds most)
        : response(std::move(what)), serializer(*response), patience(most) {}

    std::shared_ptr<http::response<Body>> response;
    http::response_serializer<Body> serializer;
    std::chrono::seconds patience;  // from one byte to the next
  };

  template <class Body>
  void write_on(const std::shared_ptr<Leaving<Body>>& leaving) {
    stream_.expires_after(leaving->patience);
    http::async_write_some(stream_, leaving->serializer,
                           [self = shared_from_this(), leaving](const beast::error_code& error, std::size_t) {
                             if (!error && !leaving->serializer.is_done()) return self->write_on(leaving);
                             if (!error && leaving->response->keep_alive()) return self->read();
                             beast::error_code ignored;
                             self->stream_.socket().shutdown(tcp::socket::shutdown_send, ignored);
                           });
  }

  beast::tcp_stream stream_;
  Gateway& gateway_;
  Place place_;
  beast::flat_buffer buffer_;
  std::optional<http::request_parser<http::empty_body>> parser_;
};

}  // namespace

Gateway::Gateway(asio::io_context& context, Options options)
    : options_(std::move(options)),
      token_(draw_token()),
      acceptor_(context, tcp::endpoint(asio::ip::address_v4::loopback(), options_.port)),
      pause_(context),
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
  fcntl(acceptor_.native_handle(), F_SETFD, FD_CLOEXEC);  // the browser that is opened must not inherit it
  accept();
}

void Gateway::accept() {
  acceptor_.async_accept([this](const beast::error_code& error, tcp::socket socket) {
    if (error == asio::error::operation_aborted) return;
    if (error || !connections_->make_room()) return accept_later();
    beast::error_code ignored;
    fcntl(socket.native_handle(), F_SETFD, FD_CLOEXEC);
    socket.set_option(tcp::no_delay(true), ignored);
    std::make_shared<Connection>(std::move(socket), *this, Place(connections_))->read();
    accept();
  });
}

// Out of descriptors, for instance: some connection has to end first.
void Gateway::accept_later() {
  pause_.expires_after(kPause);
  pause_.async_wait([this](const beast::error_code& error) {
    if (!error) accept();
  });
}

std::string Gateway::url() const {
  return "http://127.0.0.1:" + std::to_string(acceptor_.local_endpoint().port()) + "/#" + token_;
}

// In the same time wherever they differ.
bool Gateway::is_token(std::string_view token) const {
  unsigned differing = token.size() != token_.size();
  for (std::size_t i = 0; i < token_.size(); ++i)
    differing |= static_cast<unsigned>(token_[i] ^ (i < token.size() ? token[i] : '\0'));
  return differing == 0;
}

bool Gateway::add(Viewer& viewer) {
  if (viewers_.size() >= kMostViewers) return false;
  viewers_.insert(&viewer);
  source_->watch(true);
  play_first();
  return true;
}

void Gateway::remove(Viewer& viewer) {
  end_driving(viewer);
  viewers_.erase(&viewer);
  source_->watch(!viewers_.empty());
}

void Gateway::begin_driving(Viewer& viewer) {
  if (driver_ != nullptr) return;
  try {
    source_->begin_driving();
    driver_ = &viewer;
  } catch (const std::exception&) {  // out of descriptors: nobody drives
  }
}

void Gateway::end_driving(Viewer& viewer) {
  if (driver_ != &viewer) return;
  driver_ = nullptr;
  source_->end_driving();
}

void Gateway::drive(Viewer& viewer, std::string_view message) {
  if (driver_ == &viewer) source_->drive(message);
}

Source::Listener Gateway::listener() {
  return {[this](const Frame& frame) {
            for (Viewer* viewer : viewers_) viewer->put(frame);
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
        for (Viewer* viewer : viewers_) viewer->put(frame);
      },
      [this](const std::string& why) { say(why); });
}

void Gateway::begin_run() {
  Playback::Told told{[this] {
                        for (Viewer* viewer : viewers_) viewer->jump(run_->at());
                      },
                      [this](const Frame& frame) {
                        for (Viewer* viewer : viewers_) viewer->recall(frame);
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
  source_->watch(!viewers_.empty());
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

void Gateway::branch(Viewer& viewer, bool wanted) {
  if (!run_ || wanted == live() || others_drive(viewer)) return;
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
  for (Viewer* viewer : viewers_) viewer->tell_of_the_scene();
  run_->show_again();
}

void Gateway::play_first() {
  if (options_.first_motion.empty() || viewers_.empty() || !source_->here()) return;
  const std::string motion = std::exchange(options_.first_motion, "");
  player_.play(motion, options_.scenes.motion(motion), source_->lockstep(), MotionPlayer::Times::to_and_fro);
}

void Gateway::play(Viewer& viewer, const std::string& motion) {
  const auto& motions = options_.scenes.motions;
  if (others_drive(viewer)) return;
  if (std::find(motions.begin(), motions.end(), motion) == motions.end()) return;
  player_.play(motion, options_.scenes.motion(motion), source_->lockstep());
}

void Gateway::stop_playing(Viewer& viewer) {
  if (!others_drive(viewer)) player_.stop();
}

void Gateway::say(const std::string& words) {
  for (Viewer* viewer : viewers_) viewer->say(words);
}

}  // namespace acus::view
