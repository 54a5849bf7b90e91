// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/models/field/field_worker.h"

#include <pthread.h>
#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <stdexcept>
#include <string>
#include <system_error>

#include "server/engine/math/processor_time.h"

namespace acus {

namespace {

// How often this process is a copy.
std::atomic<int> forks{0};

void count_forks() {
  static const int counted = pthread_atfork(nullptr, nullptr, [] { forks.fetch_add(1, std::memory_order_relaxed); });
  (void)counted;
}

int this_thread() {
  thread_local const int id = gettid();
  return id;
}

// An ordinary one where the other is, or is not there any more, or where the system does not permit it.
void be_as_urgent_as(int thread) {
  sched_param parameters{};
  const int policy = sched_getscheduler(thread);
  const bool real_time = (policy == SCHED_FIFO || policy == SCHED_RR) && sched_getparam(thread, &parameters) == 0;
  parameters.sched_priority = real_time ? std::max(1, parameters.sched_priority - FieldWorker::kLessUrgent) : 0;
  pthread_setschedparam(pthread_self(), real_time ? SCHED_FIFO : SCHED_OTHER, &parameters);
}

}  // namespace

FieldWorker::FieldWorker(const TissueSystem& system, std::shared_ptr<FieldWindow> memory)
    : system_(system), task_(system, std::move(memory)) {
  if (!system.field->threaded) return;
  count_forks();
  forks_ = forks.load(std::memory_order_relaxed);
  start_ = next_start_ = ElementRotations(system.model);
  try {
    thread_ = std::thread([this] { run(); });
  } catch (const std::system_error& error) {
    throw std::runtime_error(std::string("tissue.window_thread: the system gives no thread (") +
                             error.code().message() +
                             "); set it to false, or let the process have more of them (ulimit -u)");
  }
}

FieldWorker::~FieldWorker() {
  if (!has_thread()) return;
  stopped_.store(true, std::memory_order_relaxed);
  ended_.store(true, std::memory_order_relaxed);
  begun_.store(++handed_, std::memory_order_release);
  begun_.notify_one();
  thread_.join();
}

bool FieldWorker::has_thread() {
  if (!thread_.joinable()) return false;
  if (forks.load(std::memory_order_relaxed) == forks_) return true;
  thread_.detach();
  task_.begin(nullptr);
  return false;
}

void FieldWorker::advance(const std::shared_ptr<const FieldWindow>& window, const ElementRotations& start, int tick) {
  const bool threaded = has_thread();
  if (task_.window() != window) {
    if (threaded) return hand_over(window, start);
    task_.begin(window);
  }
  if (!threaded) task_.advance(system_, start, tick);
}

void FieldWorker::hand_over(const std::shared_ptr<const FieldWindow>& window, const ElementRotations& start) {
  stopped_.store(true, std::memory_order_relaxed);
  wait_until_idle();
  stopped_.store(false, std::memory_order_relaxed);
  if (next_ == window)
    std::swap(start_.batches, next_start_.batches);
  else
    start_.batches = start.batches;
  next_ = nullptr;
  task_.begin(window);
  whose_ = this_thread();
  begun_.store(++handed_, std::memory_order_release);
  begun_.notify_one();
}

FieldTask::Result& FieldWorker::take() {
  if (has_thread()) wait_until_idle();
  return task_.take();
}

void FieldWorker::wait_until_idle() {
  for (std::uint32_t done = done_.load(std::memory_order_acquire); done != handed_;
       done = done_.load(std::memory_order_acquire))
    done_.wait(done, std::memory_order_acquire);
}

void FieldWorker::run() {
  pthread_setname_np(pthread_self(), "acus-window");
  int urgent_as = 0;
  for (std::uint32_t work = 0;;) {
    begun_.wait(work, std::memory_order_acquire);
    work = begun_.load(std::memory_order_acquire);
    if (ended_.load(std::memory_order_relaxed)) return;
    if (whose_ != urgent_as) be_as_urgent_as(urgent_as = whose_);
    const double start = processor_time();
    if (task_.finish(system_, start_, stopped_)) {
      next_start_.batches = task_.result().element_rotations.batches;
      seconds_.store(processor_time() - start, std::memory_order_relaxed);
    }
    done_.store(work, std::memory_order_release);
    done_.notify_one();
  }
}

}  // namespace acus
