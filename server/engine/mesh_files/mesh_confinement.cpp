// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/mesh_files/mesh_confinement.h"

#include <grp.h>
#include <linux/audit.h>
#include <linux/capability.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sys/ioctl.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstddef>
#include <fstream>
#include <vector>

namespace acus {
namespace {

// Never above what is allowed already.
void limit(int resource, rlim_t value) {
  rlimit now{};
  if (getrlimit(resource, &now) != 0) return;
  now.rlim_max = std::min(now.rlim_max, value);
  now.rlim_cur = now.rlim_max;
  setrlimit(resource, &now);
}

#if defined(__x86_64__)
constexpr unsigned kArchitecture = AUDIT_ARCH_X86_64;
#elif defined(__aarch64__)
constexpr unsigned kArchitecture = AUDIT_ARCH_AARCH64;
#else
constexpr unsigned kArchitecture = 0;
#endif

// Reading what is open, computing and answering take these.
constexpr std::array kAllowedCalls{
    SYS_read,
    SYS_readv,
    SYS_pread64,
    SYS_write,
    SYS_writev,
    SYS_close,
    SYS_lseek,
    SYS_fstat,
    SYS_newfstatat,
    SYS_brk,
    SYS_mmap,
    SYS_munmap,
    SYS_mremap,
    SYS_mprotect,
    SYS_madvise,
    SYS_futex,
    SYS_getrandom,
    SYS_clock_gettime,
    SYS_clock_getres,
    SYS_gettimeofday,
    SYS_clock_nanosleep,
    SYS_nanosleep,
    SYS_times,
    SYS_getrusage,
    SYS_uname,
    SYS_sysinfo,
    SYS_sched_yield,
    SYS_sched_getaffinity,
    SYS_getpid,
    SYS_gettid,
    SYS_getuid,
    SYS_geteuid,
    SYS_getgid,
    SYS_getegid,
    SYS_rt_sigaction,
    SYS_rt_sigprocmask,
    SYS_rt_sigreturn,
    SYS_sigaltstack,
    SYS_exit,
    SYS_exit_group,
#ifdef SYS_time
    SYS_time,
#endif
};

sock_filter load(std::size_t offset) { return BPF_STMT(BPF_LD | BPF_W | BPF_ABS, static_cast<unsigned>(offset)); }
// The lower half of an argument: both machines are little-endian, and these arguments are 32 bits.
sock_filter load_argument(std::size_t number) {
  return load(offsetof(seccomp_data, args) + number * sizeof(seccomp_data::args[0]));
}
sock_filter answer(unsigned action) { return BPF_STMT(BPF_RET | BPF_K, action); }
sock_filter skip_unless(unsigned test, unsigned value, unsigned char count = 1) {
  return BPF_JUMP(BPF_JMP | BPF_K | test, value, 0, count);
}

std::vector<sock_filter> filter_of_calls() {
  constexpr unsigned kRefuse = SECCOMP_RET_ERRNO | EPERM, kAllow = SECCOMP_RET_ALLOW;
  std::vector<sock_filter> filter{load(offsetof(seccomp_data, arch)),
                                  BPF_JUMP(BPF_JMP | BPF_K | BPF_JEQ, kArchitecture, 1, 0), answer(kRefuse),
                                  load(offsetof(seccomp_data, nr))};
  for (const long call : kAllowedCalls) {
    filter.push_back(skip_unless(BPF_JEQ, static_cast<unsigned>(call)));
    filter.push_back(answer(kAllow));
  }
  const auto judge = [&](long call, std::size_t argument, unsigned test, unsigned value, unsigned then,
                         unsigned other) {
    filter.push_back(skip_unless(BPF_JEQ, static_cast<unsigned>(call), 4));
    filter.push_back(load_argument(argument));
    filter.push_back(skip_unless(test, value));
    filter.push_back(answer(then));
    filter.push_back(answer(other));
  };
  judge(SYS_ioctl, 1, BPF_JEQ, TCGETS, kAllow, kRefuse);                            // isatty()
  judge(SYS_prlimit64, 0, BPF_JEQ, 0, kAllow, kRefuse);                             // its own limits
  judge(SYS_tgkill, 0, BPF_JEQ, static_cast<unsigned>(getpid()), kAllow, kRefuse);  // abort()
  filter.push_back(answer(kRefuse));
  return filter;
}

// A namespace may have no other user than root, or a process no right to change: then it is root without capabilities.
void leave_root() {
  constexpr unsigned kNobody = 65534;
  if (geteuid() == 0) {
    setgroups(0, nullptr);
    const bool left = setresgid(kNobody, kNobody, kNobody) == 0 && setresuid(kNobody, kNobody, kNobody) == 0;
    static_cast<void>(left);
  }
  __user_cap_header_struct header{_LINUX_CAPABILITY_VERSION_3, 0};
  const std::array<__user_cap_data_struct, 2> none{};
  syscall(SYS_capset, &header, none.data());
}

void end_with_parent() { prctl(PR_SET_PDEATHSIG, SIGKILL); }

}  // namespace

void limit_resources(rlim_t memory_bytes, rlim_t processor_seconds) {
  end_with_parent();
  limit(RLIMIT_CORE, 1);  // bytes: too small for a file, and unlike 0 it also stops a core that goes to a program
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // these reserve terabytes of addresses
  limit(RLIMIT_AS, memory_bytes);
#else
  static_cast<void>(memory_bytes);
#endif
  // The first signal says why, the second one cannot be caught.
  rlimit processor{processor_seconds, processor_seconds + 1};
  setrlimit(RLIMIT_CPU, &processor);
  std::ofstream("/proc/self/oom_score_adj") << 1000;
}

void confine() {
  limit(RLIMIT_FSIZE, 0);
  leave_root();
  end_with_parent();  // anew: who becomes another user forgets it
  if (kArchitecture == 0 || prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0) return;
  std::vector<sock_filter> filter = filter_of_calls();
  const sock_fprog program{static_cast<unsigned short>(filter.size()), filter.data()};
  syscall(SYS_seccomp, SECCOMP_SET_MODE_FILTER, SECCOMP_FILTER_FLAG_TSYNC, &program);
}

}  // namespace acus
