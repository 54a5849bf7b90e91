// SPDX-License-Identifier: MIT
#include "protocol/endpoint_address.h"

#include <arpa/inet.h>
#include <sys/un.h>

#include <charconv>

namespace acus::protocol {
namespace {

constexpr std::string_view kTcp = "tcp://", kIpc = "ipc://";
constexpr int kMaxPort = 65535;
constexpr std::size_t kMaxPathBytes = sizeof(sockaddr_un::sun_path) - 1;

std::string quoted(std::string_view text) { return "'" + std::string(text) + "'"; }

// A port as it is written, digits and nothing else; -1 if it is none.
int port_of(std::string_view text) {
  int port = -1;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), port);
  return error == std::errc() && end == text.data() + text.size() && port >= 0 && port <= kMaxPort ? port : -1;
}

std::string problem_with_tcp(std::string_view address, EndpointUse use) {
  const std::size_t colon = address.rfind(':');
  if (colon == std::string_view::npos) return "expected tcp://HOST:PORT, found no port";
  const std::string_view host = address.substr(0, colon), port = address.substr(colon + 1);
  if (host.empty()) return "expected tcp://HOST:PORT, found no host";
  if (use == EndpointUse::connect) {
    if (host == "*") return "expected the host where the server runs, found '*'";
    if (port_of(port) <= 0) return "expected a port from 1 to 65535, found " + quoted(port);
  } else if (port != "*" && port_of(port) < 0) {
    return "expected a port from 0 to 65535, or * for a free one, found " + quoted(port);
  }
  return {};
}

std::string problem_with_ipc(std::string_view path, EndpointUse use) {
  if (path.empty() || path == "@") return "expected ipc://PATH, found no path";
  if (path == "*" && use == EndpointUse::connect) return "expected the path where the server listens, found '*'";
  if (path.size() > kMaxPathBytes) {
    return "expected a path of at most " + std::to_string(kMaxPathBytes) + " bytes, found " +
           std::to_string(path.size()) + "; choose a shorter one";
  }
  return {};
}

}  // namespace

std::string problem_with_endpoint(std::string_view endpoint, EndpointUse use) {
  if (endpoint.find('\0') != std::string_view::npos) return "expected no zero byte in it";
  if (endpoint.starts_with(kTcp)) return problem_with_tcp(endpoint.substr(kTcp.size()), use);
  if (endpoint.starts_with(kIpc)) return problem_with_ipc(endpoint.substr(kIpc.size()), use);
  return "expected tcp://HOST:PORT or ipc://PATH, found " + quoted(endpoint);
}

// By its address, not by the name of an interface, which could have any.
bool is_local_endpoint(std::string_view endpoint) {
  if (endpoint.starts_with(kIpc)) return true;
  if (!endpoint.starts_with(kTcp)) return false;
  const std::string_view address = endpoint.substr(kTcp.size());
  const std::string host(address.substr(0, address.rfind(':')));
  in_addr number{};
  if (inet_pton(AF_INET, host.c_str(), &number) == 1) return ntohl(number.s_addr) >> 24 == IN_LOOPBACKNET;
  return host == "localhost" || host == "[::1]" || host == "::1";
}

bool is_wildcard_endpoint(std::string_view endpoint) {
  return endpoint == "ipc://*" ||
         (endpoint.starts_with(kTcp) && (endpoint.ends_with(":*") || endpoint.ends_with(":0")));
}

}  // namespace acus::protocol
