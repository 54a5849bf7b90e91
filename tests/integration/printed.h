// SPDX-License-Identifier: GPL-3.0-or-later
// A program and the end of the pipe that it prints into.
#pragma once

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <stdexcept>
#include <string>
#include <vector>

#include "tests/integration/process.h"
#include "tests/integration/server_process.h"

namespace acus::testing {

class Printed {
 public:
  explicit Printed(const std::vector<std::string>& argv) : pipe_(), process_(argv, pipe_.in) { pipe_.close_in(); }

  Process& process() { return process_; }

  // One line, without its end; what there is of it if no more comes.
  std::string read_line() {
    std::string line;
    for (char next = 0; read_byte(next) && next != '\n';) line += next;
    return line;
  }

  // All that comes until the program ends.
  std::string read_all() {
    std::string text;
    for (char next = 0; read_byte(next);) text += next;
    return text;
  }

  void stop_reading() { pipe_.close_out(); }

 private:
  struct Pipe {
    int out = -1, in = -1;
    Pipe() {
      int files[2];
      if (pipe2(files, O_CLOEXEC) != 0) throw std::runtime_error("cannot create a pipe");
      out = files[0];
      in = files[1];
    }
    ~Pipe() {
      close_in();
      close_out();
    }
    void close_in() {
      if (in >= 0) close(in);
      in = -1;
    }
    void close_out() {
      if (out >= 0) close(out);
      out = -1;
    }
  };

  bool read_byte(char& byte) {
    pollfd item{pipe_.out, POLLIN, 0};
    return poll(&item, 1, static_cast<int>(kPatience.count())) == 1 && read(pipe_.out, &byte, 1) == 1;
  }

  Pipe pipe_;
  Process process_;
};

}  // namespace acus::testing
