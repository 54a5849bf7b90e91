// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/transport/listening.h"

#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string_view>

#include "protocol/endpoint_address.h"

namespace acus {
namespace {

constexpr std::string_view kIpc = "ipc://", kLocalhost = "tcp://localhost:";

// Any name will do. With a domain and no ZAP handler, ZeroMQ accepts every peer that speaks ZMTP 3, and closes the
// connections of those before it. ZMTP 1.0 has no greeting: bytes of any origin are frames, a web page's POST included.
constexpr const char* kZapDomain = "acus";
constexpr int kMaxHandshake = 10'000;  // ms from a connection to the end of its handshake

std::string reason_of(int error) {
  switch (error) {
    case EADDRINUSE:
      return "another program listens there; end it, or choose another endpoint";
    case EADDRNOTAVAIL:
    case ENODEV:
      return "no network interface of this machine has that address; give one of its addresses, or * for all";
    case EACCES:
    case EPERM:
    case EROFS:
      return "this user may not listen there; choose a port above 1023, or a folder that this user may write to";
    case ENOENT:
    case ENOTDIR:
      return "the folder does not exist; create it, or choose another path";
    default:
      return zmq_strerror(error);
  }
}

// What a program listening at the path says to a connection: 0 if it takes it, else an errno.
int error_of_connecting(const std::string& path) {
  sockaddr_un address{};
  if (path.size() >= sizeof address.sun_path) return ENAMETOOLONG;
  address.sun_family = AF_UNIX;
  std::memcpy(address.sun_path, path.c_str(), path.size() + 1);
  const int file = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (file < 0) return errno;
  const int result = ::connect(file, reinterpret_cast<const sockaddr*>(&address), sizeof address);
  const int error = result == 0 ? 0 : errno;
  ::close(file);
  return error;
}

// ZeroMQ removes whatever has the path's name before it binds, also for an abstract name, which begins with @. Returns
// what must not be removed, or nothing.
std::string in_the_way(const std::string& path) {
  struct stat status {};
  if (lstat(path.c_str(), &status) != 0) return {};
  if (!S_ISSOCK(status.st_mode)) {
    return "'" + path + "' exists and is no socket; remove it, or choose another path";
  }
  switch (error_of_connecting(path)) {
    case ECONNREFUSED:  // left behind by a program that has ended
    case ENOENT:
      return {};
    case EACCES:
      return "'" + path + "' is the socket of another user; choose another path";
    default:
      return "another server listens there; end it, or choose another path";
  }
}

// ZeroMQ binds to addresses and interfaces, not to names of hosts.
std::string with_address(const std::string& endpoint) {
  return endpoint.starts_with(kLocalhost) ? "tcp://127.0.0.1:" + endpoint.substr(kLocalhost.size()) : endpoint;
}

void set_keys(zmq::socket_t& socket, const CurveServer& curve) {
  socket.set(zmq::sockopt::curve_server, true);
  socket.set(zmq::sockopt::curve_secretkey, curve.key.secret_key);
}

}  // namespace

void listen(zmq::socket_t& socket, const std::string& option, const std::string& endpoint, const Admission& admission) {
  const std::string cannot = "cannot listen on " + option + " '" + endpoint + "': ";
  if (!admission.curve && !admission.insecure && !protocol::is_local_endpoint(endpoint)) {
    throw CannotListen(
        cannot +
        "other machines could connect, and whoever does can command the needles; give "
        "--curve-server-key and --curve-clients (acus-keygen makes keys), or --insecure if everybody who "
        "can reach it may do so");
  }
  if (endpoint.starts_with(kIpc) && endpoint != "ipc://*") {
    const std::string obstacle = in_the_way(endpoint.substr(kIpc.size()));
    if (!obstacle.empty()) throw CannotListen(cannot + obstacle);
  }
  socket.set(zmq::sockopt::zap_domain, std::string(kZapDomain));
  socket.set(zmq::sockopt::handshake_ivl, kMaxHandshake);
  if (admission.curve) set_keys(socket, *admission.curve);
  try {
    socket.bind(with_address(endpoint));
  } catch (const zmq::error_t& error) {
    throw CannotListen(cannot + reason_of(error.num()));
  }
}

}  // namespace acus
