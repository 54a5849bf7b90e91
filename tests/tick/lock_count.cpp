// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/tick/lock_count.h"

#include <dlfcn.h>
#include <pthread.h>
#include <semaphore.h>

#include <atomic>

namespace {

constinit thread_local bool counting = false;
constinit thread_local int locks = 0;

// Counts a call, then makes it: `next` keeps the C library's own function of that name.
template <class Function, class... Arguments>
int counted(std::atomic<Function*>& next, const char* name, Arguments... arguments) {
  locks += counting;
  if (next.load() == nullptr) next = reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
  return next.load()(arguments...);
}

}  // namespace

#define ACUS_COUNT_LOCK(function, Type)                         \
  extern "C" int function(Type* lock) noexcept {                \
    static constinit std::atomic<int (*)(Type*)> next{nullptr}; \
    return counted<int(Type*)>(next, #function, lock);          \
  }

ACUS_COUNT_LOCK(pthread_mutex_lock, pthread_mutex_t)
ACUS_COUNT_LOCK(pthread_mutex_trylock, pthread_mutex_t)
ACUS_COUNT_LOCK(pthread_rwlock_rdlock, pthread_rwlock_t)
ACUS_COUNT_LOCK(pthread_rwlock_wrlock, pthread_rwlock_t)
ACUS_COUNT_LOCK(sem_wait, sem_t)

namespace acus::test {

LockCount::LockCount() {
  locks = 0;
  counting = true;
}
LockCount::~LockCount() { counting = false; }
int LockCount::value() const { return locks; }

}  // namespace acus::test
