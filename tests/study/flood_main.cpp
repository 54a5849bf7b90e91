// SPDX-License-Identifier: GPL-3.0-or-later
// acus-flood: a client that sends a running acus-server more than it should, for tests/study/flood to measure what the
// others notice of it.
#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <map>
#include <string>
#include <thread>
#include <zmq.hpp>

#include "protocol/codec.h"
#include "protocol/messages.h"

namespace {

using namespace acus;
using Clock = std::chrono::steady_clock;

constexpr auto kBatch = std::chrono::milliseconds(1);  // between two bursts
constexpr int kMaxAnswersRead = 10'000;                // in a row

struct Arguments {
  std::string commands = protocol::kDefaultCommandsEndpoint;
  std::string message = "pose";
  double rate = 100'000;  // Hz
  double duration = 10;   // s
};

std::string pose() {
  protocol::Pose pose;
  pose.needle = "needle";
  pose.seq = 1;
  return encode(pose);
}

const std::map<std::string, std::string>& messages() {
  static const std::map<std::string, std::string> all{{"pose", pose()},
                                                      {"hello", encode(protocol::Hello{})},
                                                      {"describe", encode(protocol::Describe{})},
                                                      {"reset", encode(protocol::Reset{})},
                                                      {"nonsense", std::string(1000, '\xc1')}};
  return all;
}

void declare(CLI::App& app, Arguments& arguments) {
  app.add_option("--commands", arguments.commands, "the server's endpoint for commands")->capture_default_str();
  app.add_option("--message", arguments.message, "what is sent; a pose is of a needle that this client does not hold")
      ->check(CLI::IsMember(messages()))
      ->capture_default_str();
  app.add_option("--rate", arguments.rate, "messages per second (Hz), or as many as the server takes")
      ->check(CLI::Range(1.0, 1e9))
      ->capture_default_str();
  app.add_option("--duration", arguments.duration, "(s)")->check(CLI::Range(0.1, 86'400.0))->capture_default_str();
}

class Flood {
 public:
  explicit Flood(const Arguments& arguments) : arguments_(arguments), socket_(context_, zmq::socket_type::dealer) {
    socket_.set(zmq::sockopt::linger, 0);
    socket_.connect(arguments.commands);
  }

  void run() {
    const auto begin = Clock::now();
    const std::string& bytes = messages().at(arguments_.message);
    for (double elapsed = 0; elapsed < arguments_.duration;) {
      std::this_thread::sleep_for(kBatch);
      elapsed = std::chrono::duration<double>(Clock::now() - begin).count();
      send_until(static_cast<std::uint64_t>(arguments_.rate * elapsed), bytes);
      read_answers();
    }
    std::printf("flood       %.0f messages '%s' a second sent, %.0f not taken; %.0f answers a second\n", rate_of(sent_),
                arguments_.message.c_str(), rate_of(refused_), rate_of(answers_));
  }

 private:
  // What the server had no room for is not made up for.
  void send_until(std::uint64_t due, const std::string& bytes) {
    while (sent_ + refused_ < due) {
      if (!socket_.send(zmq::buffer(bytes), zmq::send_flags::dontwait)) {
        refused_ = due - sent_;
        return;
      }
      ++sent_;
    }
  }

  void read_answers() {
    zmq::message_t answer;
    for (int i = 0; i < kMaxAnswersRead && socket_.recv(answer, zmq::recv_flags::dontwait); ++i) ++answers_;
  }

  double rate_of(std::uint64_t count) const { return static_cast<double>(count) / arguments_.duration; }

  const Arguments arguments_;
  zmq::context_t context_;
  zmq::socket_t socket_;
  std::uint64_t sent_ = 0, refused_ = 0, answers_ = 0;
};

}  // namespace

int main(int argc, char** argv) {
  Arguments arguments;
  CLI::App app("Sends a running acus-server more messages than it should.", "acus-flood");
  declare(app, arguments);
  CLI11_PARSE(app, argc, argv);
  try {
    Flood(arguments).run();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "acus-flood: %s\n", error.what());
    return 1;
  }
  return 0;
}
