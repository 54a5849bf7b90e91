// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/tick/sealed.h"

#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstddef>

namespace acus::test {

namespace {

Sealed* verdict = nullptr;  // shared with the child

void on_refusal(int, siginfo_t* info, void*) {
  verdict->system_call = info->si_syscall;
  _exit(0);
}

// Refuses this process every system call but the one that ends it.
bool seal() {
  struct sigaction action {};
  action.sa_sigaction = on_refusal;
  action.sa_flags = SA_SIGINFO;
  sigaction(SIGSYS, &action, nullptr);

  std::array<sock_filter, 4> code{{
      BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr)),
      BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_exit_group, 0, 1),
      BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
      BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_TRAP),
  }};
  const sock_fprog program{code.size(), code.data()};
  return prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 && prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program) == 0;
}

}  // namespace

Sealed run_sealed(const std::function<void()>& work) {
  const SharedWithChild<Sealed> shared;
  verdict = &*shared;
  const pid_t child = fork();
  if (child == 0) {
    if (!seal()) _exit(1);
    work();
    _exit(0);
  }
  int status = -1;
  waitpid(child, &status, 0);
  verdict->watched = WIFEXITED(status) && WEXITSTATUS(status) == 0;
  return *verdict;
}

}  // namespace acus::test
