// SPDX-License-Identifier: GPL-3.0-or-later
// Preloaded into a process, makes the next call of a function fail for which the folder ACUS_FAILING_CALLS has a file of
// its name, and removes that file. write fails only for files, malloc only for what the system is asked for pages.
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <pthread.h>
#include <spawn.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#define PAGES (128 << 10)  // bytes, from which on malloc() maps memory

extern void* __libc_malloc(size_t);
extern void* __libc_calloc(size_t, size_t);

static int fails(const char* call, int with) {
  const char* folder = getenv("ACUS_FAILING_CALLS");
  char path[PATH_MAX];
  if (!folder) return 0;
  char* end = path;
  for (const char* c = folder; *c; ++c) *end++ = *c;
  *end++ = '/';
  for (const char* c = call; *c; ++c) *end++ = *c;
  *end = '\0';
  const int before = errno;
  const int failed = syscall(SYS_unlink, path) == 0;
  errno = failed ? with : before;
  return failed;
}

static int is_file(int file) {
  struct stat status;
  return fstat(file, &status) == 0 && S_ISREG(status.st_mode);
}

#define NEXT(name) ((__typeof__(&name))dlsym(RTLD_NEXT, #name))

int pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*run)(void*), void* what) {
  if (fails("thread", EAGAIN)) return EAGAIN;
  return NEXT(pthread_create)(thread, attributes, run, what);
}

int posix_spawn(pid_t* process, const char* path, const posix_spawn_file_actions_t* actions,
                const posix_spawnattr_t* attributes, char* const arguments[], char* const environment[]) {
  if (fails("fork", EAGAIN)) return EAGAIN;
  return NEXT(posix_spawn)(process, path, actions, attributes, arguments, environment);
}

void* malloc(size_t size) { return size >= PAGES && fails("mmap", ENOMEM) ? NULL : __libc_malloc(size); }

void* calloc(size_t count, size_t size) {
  return size && count >= PAGES / size && fails("mmap", ENOMEM) ? NULL : __libc_calloc(count, size);
}

int open(const char* path, int flags, ...) {
  va_list more;
  va_start(more, flags);
  const mode_t mode = flags & (O_CREAT | O_TMPFILE) ? va_arg(more, mode_t) : 0;
  va_end(more);
  return fails("open", EMFILE) ? -1 : (int)syscall(SYS_openat, AT_FDCWD, path, flags, mode);
}

FILE* fopen(const char* path, const char* mode) { return fails("open", EMFILE) ? NULL : NEXT(fopen)(path, mode); }
FILE* fopen64(const char* path, const char* mode) { return fails("open", EMFILE) ? NULL : NEXT(fopen64)(path, mode); }

ssize_t write(int file, const void* bytes, size_t size) {
  return is_file(file) && fails("write", ENOSPC) ? -1 : syscall(SYS_write, file, bytes, size);
}

ssize_t pwrite(int file, const void* bytes, size_t size, off_t at) {
  return fails("write", ENOSPC) ? -1 : syscall(SYS_pwrite64, file, bytes, size, at);
}

ssize_t pwrite64(int file, const void* bytes, size_t size, off64_t at) { return pwrite(file, bytes, size, at); }

int fsync(int file) { return fails("fsync", EIO) ? -1 : (int)syscall(SYS_fsync, file); }
