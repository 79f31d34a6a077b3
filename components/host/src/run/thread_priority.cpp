// SPDX-License-Identifier: Apache-2.0
#include "run/thread_priority.hpp"

#include <pthread.h>
#include <sched.h>
#include <sys/resource.h>

#include <cerrno>
#include <cstring>

namespace pipescout::host {

std::string apply_to_this_thread(const ExecutorSettings& settings) {
  if (settings.fifo) {
    sched_param parameter{};
    parameter.sched_priority = *settings.fifo;
    if (const int error = pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameter);
        error != 0) {
      return "real-time priority " + std::to_string(*settings.fifo) +
             " (SCHED_FIFO) is not permitted: " + std::strerror(error) +
             "; it runs with the priority of any other process. Give the process CAP_SYS_NICE, or "
             "raise its limit of real-time priorities (LimitRTPRIO= of systemd, ulimit -r)";
    }
  }
  // On Linux the niceness is the thread's own.
  if (settings.nice && setpriority(PRIO_PROCESS, 0, *settings.nice) != 0) {
    return "niceness " + std::to_string(*settings.nice) +
           " is not permitted: " + std::strerror(errno) +
           "; it keeps that of the process. Give the process CAP_SYS_NICE, or raise its limit of "
           "priorities (LimitNICE= of systemd, ulimit -e)";
  }
  return {};
}

}  // namespace pipescout::host
