// SPDX-License-Identifier: GPL-3.0-or-later
// Who does the work of windows (field_task.h): the ticks, a slice each, or a thread beside them
// (`tissue.window_thread`).
//
// The thread is handed a window in its first tick and is waited for in the first tick of the next one: it has k ticks
// for what it takes, and all bits are the same. A tick calls the kernel to wake it, once a window, and to wait for it
// where it is late. Against other programs it is as urgent as the thread that ticks, less kLessUrgent.
//
// In a process that fork() has copied there is no such thread; ticks do the work.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <thread>

#include "server/engine/models/field/field_task.h"

namespace acus {

class FieldWorker {
 public:
  // Of SCHED_FIFO: behind all that passes commands and states on, before ordinary programs.
  static constexpr int kLessUrgent = 20;

  // The system must outlive this; `memory` as FieldTask takes it. Throws std::runtime_error where there is to be a
  // thread and cannot be.
  FieldWorker(const TissueSystem& system, std::shared_ptr<FieldWindow> memory);
  ~FieldWorker();
  FieldWorker(const FieldWorker&) = delete;
  FieldWorker& operator=(const FieldWorker&) = delete;

  const FieldTask& task() const { return task_; }
  // Processor time that the thread took for its last window (s); 0: there was none.
  double thread_seconds() const { return seconds_.load(std::memory_order_relaxed); }

  // What is due at the end of tick `tick` (0 to k - 1) of the window. `start`: of the elements, when it began.
  void advance(const std::shared_ptr<const FieldWindow>& window, const ElementRotations& start, int tick);
  // Of the window that advance() was last called for, whose ticks are over; whoever takes it may take it apart.
  FieldTask::Result& take();
  // That window has become this one, which begins with the elements' rotations of the result.
  void follow(const std::shared_ptr<const FieldWindow>& window) { next_ = window; }

 private:
  void hand_over(const std::shared_ptr<const FieldWindow>& window, const ElementRotations& start);
  void wait_until_idle();
  void run();  // the thread
  bool has_thread();

  const TissueSystem& system_;
  FieldTask task_;

  // The thread's while it works.
  ElementRotations start_, next_start_;
  int whose_ = 0;  // thread that waits for it, as the kernel knows it

  std::shared_ptr<const FieldWindow> next_;
  std::uint32_t handed_ = 0;
  int forks_ = 0;
  std::atomic<std::uint32_t> begun_{0}, done_{0};  // windows
  std::atomic<bool> stopped_{false}, ended_{false};
  std::atomic<double> seconds_{0};
  std::thread thread_;
};

}  // namespace acus
