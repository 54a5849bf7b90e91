// SPDX-License-Identifier: MIT
// Between two acus-haptic programs that share a needle: one message a sample each way over a pair of ZeroMQ sockets, on
// this machine alone. Messages are structures as they lie in memory; what has another size, mark or range is left out.
#pragma once

#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <zmq.hpp>

#include "client/haptics/vectors.h"
#include "client/link/client.h"

namespace acus::haptics {

// What the teacher's program tells. Frame of device.h, turned by --axes.
struct TeacherNews {
  static constexpr std::uint64_t kMark = 0x3168636165746361;
  std::uint64_t mark = kMark;
  std::uint64_t origin = 0;  // counts from 1; another one: ways begin anew
  std::uint64_t sample = 0;
  double time = 0;    // s, of the teacher's session
  double rate = 1;    // Hz, of its samples
  double share = 1;   // of the teacher, 0 to 1
  double stored = 0;  // J
  Wrench felt;        // N, N m, of one hand alone
  Vector6 way;        // m, rad, of the teacher's handle since the origin
  std::uint32_t lockstep = 0, ends = 0;
};

// What the pupil's program tells.
struct PupilNews {
  static constexpr std::uint64_t kMark = 0x316c69707570613a;
  std::uint64_t mark = kMark;
  std::uint64_t origin = 0;  // of the teacher's news that this answers
  std::uint64_t sample = 0;
  Vector6 way;  // m, rad
  std::uint64_t ends = 0;
};

// Whether the numbers are some that a hand can have.
bool plausible(const TeacherNews& news);
bool plausible(const PupilNews& news);

class PartnerLink {
 public:
  enum class Side { teacher, pupil };

  // The teacher's side binds, the pupil's connects. Throws client::ClientError, also for an endpoint that others than
  // this machine could reach.
  PartnerLink(const std::string& endpoint, Side side);
  ~PartnerLink();
  PartnerLink(const PartnerLink&) = delete;
  PartnerLink& operator=(const PartnerLink&) = delete;

  // Without waiting; what nobody takes is lost.
  template <class News>
  void send(const News& news) {
    [[maybe_unused]] const int sent = zmq_send(socket_.handle(), &news, sizeof news, ZMQ_DONTWAIT);
  }

  // The next plausible message, if one comes in time.
  template <class News>
  std::optional<News> receive(client::Timeout timeout) {
    const auto end = std::chrono::steady_clock::now() + timeout;
    do {
      zmq::message_t message;
      while (socket_.recv(message, zmq::recv_flags::dontwait)) {
        News news;
        if (message.size() != sizeof news) continue;
        std::memcpy(&news, message.data(), sizeof news);
        if (news.mark == News::kMark && plausible(news)) return news;
      }
    } while (wait_until(end));
    return std::nullopt;
  }

 private:
  // False if it is that time, or a signal came.
  bool wait_until(std::chrono::steady_clock::time_point end);

  std::string file_;  // of an ipc socket that is bound
  zmq::context_t context_;
  zmq::socket_t socket_;
};

}  // namespace acus::haptics
