// SPDX-License-Identifier: MIT
#include "client/haptics/program/partner_link.h"

#include <cmath>
#include <cstdint>

namespace acus::haptics {

namespace {

constexpr double kFarthest = 2, kStrongest = 1e3;  // m or rad, N or N m

bool within(const Vector6& v, double most) {
  for (const double each : v.at)
    if (!(std::abs(each) <= most)) return false;
  return true;
}

void require_local(const std::string& endpoint) {
  if (endpoint.rfind("ipc://", 0) == 0 || endpoint.rfind("tcp://127.0.0.1:", 0) == 0) return;
  throw client::ClientError("endpoint '" + endpoint +
                            "': a needle is shared on one machine; expected ipc://FILE or tcp://127.0.0.1:PORT");
}

}  // namespace

bool plausible(const TeacherNews& news) {
  return news.share >= 0 && news.share <= 1 && news.stored >= 0 && news.stored <= kStrongest &&
         std::isfinite(news.time) && within(joined(news.felt), kStrongest) && within(news.way, kFarthest);
}

bool plausible(const PupilNews& news) { return within(news.way, kFarthest); }

PartnerLink::PartnerLink(const std::string& endpoint, Side side) : socket_(context_, zmq::socket_type::pair) {
  require_local(endpoint);
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

bool PartnerLink::wait_until(std::chrono::steady_clock::time_point end) {
  const auto left = std::chrono::ceil<client::Timeout>(end - std::chrono::steady_clock::now());
  if (left.count() <= 0) return false;
  zmq::pollitem_t item{socket_.handle(), 0, ZMQ_POLLIN, 0};
  return zmq::poll(&item, 1, left) > 0;
}

}  // namespace acus::haptics
