// SPDX-License-Identifier: MIT
#include "client/view/door.h"

#include <fcntl.h>

#include <algorithm>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <cctype>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <optional>
#include <string_view>
#include <utility>

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

Door::Door(asio::io_context& context, unsigned short port)
    : acceptor_(context, tcp::endpoint(asio::ip::address_v4::loopback(), port)), pause_(context) {
  fcntl(acceptor_.native_handle(), F_SETFD, FD_CLOEXEC);  // the browser that is opened must not inherit it
}

void Door::open(Gateway& gateway) { accept(gateway); }

std::string Door::url(const Gateway& gateway) const {
  return "http://127.0.0.1:" + std::to_string(acceptor_.local_endpoint().port()) + "/#" + gateway.token();
}

void Door::accept(Gateway& gateway) {
  acceptor_.async_accept([this, &gateway](const beast::error_code& error, tcp::socket socket) {
    if (error == asio::error::operation_aborted) return;
    if (error || !connections_->make_room()) return accept_later(gateway);
    beast::error_code ignored;
    fcntl(socket.native_handle(), F_SETFD, FD_CLOEXEC);
    socket.set_option(tcp::no_delay(true), ignored);
    std::make_shared<Connection>(std::move(socket), gateway, Place(connections_))->read();
    accept(gateway);
  });
}

// Out of descriptors, for instance: some connection has to end first.
void Door::accept_later(Gateway& gateway) {
  pause_.expires_after(kPause);
  pause_.async_wait([this, &gateway](const beast::error_code& error) {
    if (!error) accept(gateway);
  });
}

}  // namespace acus::view
