// SPDX-License-Identifier: MIT
#include "client/view/cloud_link.h"

#include <filesystem>
#include <system_error>
#include <utility>

namespace acus::view {

namespace {

constexpr int kWaiting = 100;               // messages
constexpr std::int64_t kLargest = 1 << 20;  // bytes of one

}  // namespace

CloudLink::CloudLink(boost::asio::io_context& context, const CloudOptions& options,
                     const std::vector<std::string>& server, std::function<void(const Frame&)> take,
                     std::function<void(const std::string&)> ended) {
  std::string endpoint = options.endpoint;
  if (options.worlds > 0) {
    folder_ = new_folder();
    endpoint = "ipc://" + folder_ + "/cloud";
  }
  const auto hand_on = [take = std::move(take)](std::string_view bytes) {
    Frame frame;
    frame.topic = "cloud";
    frame.bytes = std::make_shared<const std::string>(bytes);
    take(frame);
  };
  tips_ = std::make_unique<WatchedSocket>(context, zmq::socket_type::sub, endpoint, std::nullopt, hand_on,
                                          [](zmq::socket_t& socket) {
                                            socket.set(zmq::sockopt::rcvhwm, kWaiting);
                                            socket.set(zmq::sockopt::maxmsgsize, kLargest);
                                            socket.set(zmq::sockopt::subscribe, "cloud");
                                          });
  if (options.worlds > 0) start(context, options, endpoint, server, std::move(ended));
}

CloudLink::~CloudLink() {
  program_.reset();
  std::error_code error;
  if (!folder_.empty()) std::filesystem::remove_all(folder_, error);
}

void CloudLink::start(boost::asio::io_context& context, const CloudOptions& options, const std::string& endpoint,
                      const std::vector<std::string>& server, std::function<void(const std::string&)> ended) {
  std::vector<std::string> arguments{"--worlds", std::to_string(options.worlds), "--publish", endpoint};
  arguments.insert(arguments.end(), server.begin(), server.end());
  if (!options.scene.empty()) arguments.push_back(options.scene);
  program_.emplace(context, "acus-cloud", std::move(arguments), [ended = std::move(ended)](int status) {
    ended(status == ChildProgram::kNoProgram
              ? "there is no cloud: acus-cloud is not beside acus-view"
              : "there is no cloud: acus-cloud has ended with status " + std::to_string(status));
  });
}

}  // namespace acus::view
