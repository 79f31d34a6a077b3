// SPDX-License-Identifier: Apache-2.0
#include "pipescout/files/whole_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>
#include <utility>

namespace pipescout {

namespace {

namespace fs = std::filesystem;

constexpr mode_t kMode = 0644;

[[noreturn]] void fail(int error, const char* what, const fs::path& path) {
  throw std::system_error(error, std::generic_category(),
                          std::string("cannot ") + what + " " + path.string());
}

int open_file(const fs::path& path, int flags, const char* what) {
  const int descriptor = ::open(path.c_str(), flags | O_CLOEXEC, kMode);
  if (descriptor < 0) {
    fail(errno, what, path);
  }
  return descriptor;
}

/// Closes on the way out.
class Descriptor {
 public:
  explicit Descriptor(int descriptor) : descriptor_(descriptor) {}
  ~Descriptor() { ::close(descriptor_); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  [[nodiscard]] int get() const noexcept { return descriptor_; }

 private:
  int descriptor_;
};

/// 0 or the error. Regular files take all at once unless the disk is full; signals may cut it.
int write_all(int descriptor, std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = ::write(descriptor, text.data(), text.size());
    if (written < 0) {
      if (errno == EINTR) {
        continue;
      }
      return errno;
    }
    text.remove_prefix(static_cast<std::size_t>(written));
  }
  return 0;
}

void sync_folder(const fs::path& folder) {
  const Descriptor descriptor(
      open_file(folder.empty() ? "." : folder, O_RDONLY | O_DIRECTORY, "open folder"));
  if (::fsync(descriptor.get()) != 0) {
    fail(errno, "write to disk", folder);
  }
}

}  // namespace

LineFile::LineFile(fs::path path)
    : path_(std::move(path)),
      descriptor_(open_file(path_, O_WRONLY | O_CREAT | O_EXCL | O_APPEND, "make")) {}

LineFile::~LineFile() {
  ::close(descriptor_);
}

void LineFile::write(std::string_view line) {
  buffer_.assign(line);
  buffer_ += '\n';
  struct stat before {};
  if (::fstat(descriptor_, &before) != 0) {
    fail(errno, "ask for the size of", path_);
  }
  if (const int error = write_all(descriptor_, buffer_); error != 0) {
    // The error above is the one to tell, whether this works or not.
    [[maybe_unused]] const int ignored = ::ftruncate(descriptor_, before.st_size);
    fail(error, "write", path_);
  }
}

void LineFile::sync() {
  if (::fsync(descriptor_) != 0) {
    fail(errno, "write to disk", path_);
  }
}

void replace_file(const fs::path& path, std::string_view content, Survives survives) {
  fs::path temporary = path;
  temporary += ".tmp";
  try {
    const Descriptor descriptor(open_file(temporary, O_WRONLY | O_CREAT | O_TRUNC, "make"));
    if (const int error = write_all(descriptor.get(), content); error != 0) {
      fail(error, "write", temporary);
    }
    if (survives == Survives::kPowerLoss && ::fsync(descriptor.get()) != 0) {
      fail(errno, "write to disk", temporary);
    }
    if (::rename(temporary.c_str(), path.c_str()) != 0) {
      fail(errno, "replace", path);
    }
  } catch (...) {
    ::unlink(temporary.c_str());
    throw;
  }
  if (survives == Survives::kPowerLoss) {
    sync_folder(path.parent_path());
  }
}

}  // namespace pipescout
