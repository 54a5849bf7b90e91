// SPDX-License-Identifier: GPL-3.0-or-later
// accept4() for the libraries of acus-server. libzmq 4.3.4 ends the process when a connection over ipc finds no free
// descriptor of the process (EMFILE), and goes on when the system has none (ENFILE), which is the same to it. A dynamic
// library takes this function before the C library's.
#include <sys/socket.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>

extern "C" __attribute__((visibility("default"))) int accept4(int listener, sockaddr* address, socklen_t* size,
                                                              int flags) {
  const auto accepted = static_cast<int>(syscall(SYS_accept4, listener, address, size, flags));
  if (accepted < 0 && errno == EMFILE) errno = ENFILE;
  return accepted;
}
