// SPDX-License-Identifier: Apache-2.0
// Preloaded into a program, lets a test set its wall clock while it runs: the file that the
// variable WALL_CLOCK names holds the seconds that are added to the time of the system, as 8 bytes.
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <unistd.h>

#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <ctime>

namespace {

std::int64_t added_seconds() {
  static const auto* const shared = []() -> const std::atomic<std::int64_t>* {
    const char* const path = std::getenv("WALL_CLOCK");
    const int file = path != nullptr ? open(path, O_RDONLY | O_CLOEXEC) : -1;
    if (file < 0) {
      return nullptr;
    }
    void* const memory = mmap(nullptr, sizeof(std::int64_t), PROT_READ, MAP_SHARED, file, 0);
    close(file);
    return memory != MAP_FAILED ? static_cast<const std::atomic<std::int64_t>*>(memory) : nullptr;
  }();
  return shared != nullptr ? shared->load() : 0;
}

}  // namespace

extern "C" int clock_gettime(clockid_t clock, timespec* time) noexcept {
  const auto result = static_cast<int>(syscall(SYS_clock_gettime, clock, time));
  if (result == 0 && (clock == CLOCK_REALTIME || clock == CLOCK_REALTIME_COARSE)) {
    time->tv_sec += added_seconds();
  }
  return result;
}

extern "C" int gettimeofday(timeval* time, void* zone) noexcept {
  const auto result = static_cast<int>(syscall(SYS_gettimeofday, time, zone));
  if (result == 0) {
    time->tv_sec += added_seconds();
  }
  return result;
}

extern "C" std::time_t time(std::time_t* where) noexcept {
  timespec now{};
  clock_gettime(CLOCK_REALTIME, &now);
  if (where != nullptr) {
    *where = now.tv_sec;
  }
  return now.tv_sec;
}
