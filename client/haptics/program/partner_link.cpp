// SPDX-License-Identifier: MIT
#include "client/haptics/program/partner_link.h"

#include <cerrno>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <system_error>

#include "protocol/endpoint_address.h"

namespace acus::haptics {

namespace {

constexpr double kFarthest = 2, kTurned = 10, kStrongest = 1e3;  // m, rad, N or N m

bool within(const Vector6& v, double upper, double lower) {
  for (int i = 0; i < 6; ++i)
    if (!(std::abs(v[i]) <= (i < 3 ? upper : lower))) return false;
  return true;
}

// The file of an ipc endpoint; empty for another one.
std::string file_of(const std::string& endpoint) { return endpoint.rfind("ipc://", 0) == 0 ? endpoint.substr(6) : ""; }

void require_local(const std::string& endpoint) {
  const std::string problem = protocol::problem_with_endpoint(endpoint, protocol::EndpointUse::connect);
  if (!problem.empty()) throw client::ClientError("endpoint '" + endpoint + "': " + problem);
  if (!file_of(endpoint).empty() || endpoint.rfind("tcp://127.0.0.1:", 0) == 0) return;
  throw client::ClientError("endpoint '" + endpoint +
                            "': a needle is shared on one machine; expected ipc://FILE or tcp://127.0.0.1:PORT");
}

}  // namespace

bool plausible(const TeacherNews& news) {
  return news.share >= 0 && news.share <= 1 && news.stored >= 0 && news.stored <= kStrongest &&
         std::isfinite(news.time) && within(joined(news.felt), kStrongest, kStrongest) &&
         within(news.way, kFarthest, kTurned);
}

bool plausible(const PupilNews& news) { return within(news.way, kFarthest, kTurned); }

PartnerLink::PartnerLink(const std::string& endpoint, Side side) : socket_(context_, zmq::socket_type::pair) {
  require_local(endpoint);
  if (side == Side::teacher) file_ = file_of(endpoint);
  std::error_code none;
  const auto there = std::filesystem::status(file_, none);
  // ZeroMQ would put its socket in the place of any file.
  if (std::filesystem::exists(there) && !std::filesystem::is_socket(there))
    throw client::ClientError("endpoint '" + endpoint + "': there is a file that is no socket; choose another place");
  try {
    socket_.set(zmq::sockopt::linger, 200);
    socket_.set(zmq::sockopt::maxmsgsize, std::int64_t{1024});
    socket_.set(zmq::sockopt::sndhwm, 64);
    socket_.set(zmq::sockopt::rcvhwm, 64);
    if (side == Side::teacher)
      socket_.bind(endpoint);
    else
      socket_.connect(endpoint);
  } catch (const zmq::error_t& error) {
    throw client::ClientError("endpoint '" + endpoint + "': " + error.what());
  }
}

PartnerLink::~PartnerLink() {
  std::error_code none;
  if (!file_.empty()) std::filesystem::remove(file_, none);
}

bool PartnerLink::wait_until(std::chrono::steady_clock::time_point end) {
  const auto left = std::chrono::ceil<client::Timeout>(end - std::chrono::steady_clock::now());
  if (left.count() <= 0) return false;
  zmq::pollitem_t item{socket_.handle(), 0, ZMQ_POLLIN, 0};
  if (zmq_poll(&item, 1, left.count()) >= 0) return item.revents != 0;
  if (zmq_errno() == EINTR) return false;  // a signal, for which whoever waits looks
  throw client::ClientError(std::string("a shared needle: ") + zmq_strerror(zmq_errno()));
}

}  // namespace acus::haptics
