// SPDX-License-Identifier: Apache-2.0
#include "shared_memory.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <limits>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

namespace pipescout::dds {
namespace {

// What Fast DDS itself takes by default.
constexpr std::size_t kSmallestSegmentBytes = std::size_t{512} * 1024;

// Share of the free room that one process may take.
constexpr std::uintmax_t kShare = 8;

constexpr std::string_view kPrefix = "fastrtps_";
constexpr std::string_view kLockSuffix = "_el";
constexpr std::size_t kSegmentIdDigits = 16;

constexpr auto kYoung = std::chrono::seconds(10);

// "fastrtps_0123456789abcdef_el"; the locks of ports have another form and heal by themselves.
bool is_segment_lock(const std::string& name) {
  return name.size() == kPrefix.size() + kSegmentIdDigits + kLockSuffix.size() &&
         name.starts_with(kPrefix) && name.ends_with(kLockSuffix) &&
         name.find_first_not_of("0123456789abcdef", kPrefix.size()) ==
             kPrefix.size() + kSegmentIdDigits;
}

// True when the lock could be taken, so its owner is gone; the file stays locked until `release`.
class OwnerProbe {
 public:
  explicit OwnerProbe(const std::filesystem::path& file)
      : descriptor_(open(file.c_str(), O_RDONLY | O_CLOEXEC)) {}
  OwnerProbe(const OwnerProbe&) = delete;
  OwnerProbe& operator=(const OwnerProbe&) = delete;
  ~OwnerProbe() {
    if (descriptor_ >= 0) {
      close(descriptor_);
    }
  }
  [[nodiscard]] bool owner_gone() const {
    return descriptor_ >= 0 && flock(descriptor_, LOCK_EX | LOCK_NB) == 0;
  }

 private:
  int descriptor_;
};

}  // namespace

std::optional<std::uint32_t> fitting_segment_bytes(std::size_t wanted,
                                                   const std::filesystem::path& folder) {
  std::error_code error;
  const std::filesystem::space_info space = std::filesystem::space(folder, error);
  if (error || space.available / kShare < kSmallestSegmentBytes) {
    return std::nullopt;
  }
  const std::size_t most =
      std::min<std::size_t>(space.available / kShare, std::numeric_limits<std::uint32_t>::max());
  return static_cast<std::uint32_t>(std::clamp(wanted, kSmallestSegmentBytes, most));
}

bool is_locked(int descriptor) {
  if (flock(descriptor, LOCK_SH | LOCK_NB) == 0) {
    flock(descriptor, LOCK_UN);
    return false;
  }
  return errno == EWOULDBLOCK;
}

void remove_abandoned_segments(const std::filesystem::path& folder) {
  std::error_code error;
  std::vector<std::filesystem::path> locks;
  for (std::filesystem::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (is_segment_lock(name) || name.starts_with(kPayloadPrefix)) {
      locks.push_back(entry->path());
    }
  }
  const auto now = std::filesystem::file_time_type::clock::now();
  for (const std::filesystem::path& lock : locks) {
    const auto written = std::filesystem::last_write_time(lock, error);
    if (error || now - written < kYoung) {
      continue;
    }
    const OwnerProbe probe(lock);
    if (probe.owner_gone()) {
      // Files of another user cannot be removed; that user's next start does it.
      if (std::string segment = lock.string(); segment.ends_with(kLockSuffix)) {
        segment.resize(segment.size() - kLockSuffix.size());
        std::filesystem::remove(segment, error);
      }
      std::filesystem::remove(lock, error);
    }
  }
}

}  // namespace pipescout::dds
