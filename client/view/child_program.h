// SPDX-License-Identifier: MIT
// A program that lies beside the running one, as a process that ends with its owner.
#pragma once

#include <sys/types.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/signal_set.hpp>
#include <functional>
#include <string>
#include <vector>

namespace acus::view {

// A new folder for what programs leave for each other. Throws std::system_error.
std::string new_folder();

class ChildProgram {
 public:
  static constexpr int kNoProgram = 127;          // exit status
  using Ended = std::function<void(int status)>;  // may destroy the child

  // Returns at once. What it prints to standard output is not kept. Throws std::system_error if there can be no
  // process.
  ChildProgram(boost::asio::io_context& context, const std::string& name, std::vector<std::string> arguments,
               Ended ended);
  ~ChildProgram();  // ends it, and waits
  ChildProgram(const ChildProgram&) = delete;
  ChildProgram& operator=(const ChildProgram&) = delete;

  void ask_to_end();

 private:
  void start(std::vector<std::string> command);
  void watch();
  bool has_ended();

  boost::asio::signal_set signals_;
  Ended ended_;
  pid_t process_ = -1;
  int status_ = -1;
};

}  // namespace acus::view
