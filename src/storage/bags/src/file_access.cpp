// SPDX-License-Identifier: Apache-2.0
#include "file_access.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <system_error>
#include <utility>

#include "pipescout/bags/bag_error.hpp"

namespace pipescout::bags {

void throw_system_error(int error, const std::filesystem::path& file, const std::string& what) {
  BagFault fault = BagFault::kSystem;
  switch (error) {
    case ENOENT:
    case ENOTDIR:
      fault = BagFault::kNotFound;
      break;
    case EEXIST:
      fault = BagFault::kExists;
      break;
    case ENOSPC:
    case EDQUOT:
    case EFBIG:
      fault = BagFault::kNoSpace;
      break;
    default:
      break;
  }
  throw BagError(fault, file, what + ": " + std::generic_category().message(error));
}

InputFile::InputFile(std::filesystem::path path)
    : path_(std::move(path)), descriptor_(::open(path_.c_str(), O_RDONLY | O_CLOEXEC)) {
  if (descriptor_ < 0) {
    throw_system_error(errno, path_, "cannot be opened");
  }
  struct stat status {};
  if (::fstat(descriptor_, &status) != 0 || !S_ISREG(status.st_mode)) {
    ::close(descriptor_);
    throw BagError(BagFault::kNotFound, path_, "is no regular file");
  }
  size_ = static_cast<std::uint64_t>(status.st_size);
}

InputFile::~InputFile() {
  ::close(descriptor_);
}

void InputFile::read(std::uint64_t offset, std::uint64_t size, Bytes& into) const {
  // Never more than the file has: lengths come from the file itself and may be anything.
  const std::uint64_t present = offset < size_ ? std::min(size, size_ - offset) : 0;
  into.resize(static_cast<std::size_t>(present));
  std::size_t done = 0;
  while (done < into.size()) {
    const ssize_t count = ::pread(descriptor_, into.data() + done, into.size() - done,
                                  static_cast<off_t>(offset + done));
    if (count < 0 && errno == EINTR) {
      continue;
    }
    if (count < 0) {
      throw_system_error(errno, path_, "cannot be read");
    }
    if (count == 0) {
      break;
    }
    done += static_cast<std::size_t>(count);
  }
  into.resize(done);
}

OutputFile::OutputFile(std::filesystem::path path)
    : path_(std::move(path)),
      descriptor_(::open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666)) {
  if (descriptor_ < 0) {
    throw_system_error(errno, path_, "cannot be made");
  }
}

OutputFile::~OutputFile() {
  ::close(descriptor_);
}

void OutputFile::write(std::initializer_list<ByteView> parts) {
  constexpr std::size_t kParts = 4;
  std::array<iovec, kParts> left{};
  std::size_t count = 0;
  std::uint64_t total = 0;
  for (const ByteView part : parts) {
    if (!part.empty()) {
      left.at(count++) = {const_cast<std::byte*>(part.data()), part.size()};
      total += part.size();
    }
  }
  iovec* first = left.data();
  while (count > 0) {
    const ssize_t written = ::writev(descriptor_, first, static_cast<int>(count));
    if (written < 0 && errno == EINTR) {
      continue;
    }
    if (written < 0) {
      const int error = errno;
      // What the file would end with otherwise looks like the work of a kill.
      if (::ftruncate(descriptor_, static_cast<off_t>(size_)) == 0) {
        ::lseek(descriptor_, static_cast<off_t>(size_), SEEK_SET);
      }
      throw_system_error(error, path_, "cannot be written");
    }
    auto done = static_cast<std::size_t>(written);
    while (count > 0 && done >= first->iov_len) {
      done -= first->iov_len;
      ++first;
      --count;
    }
    if (count > 0) {
      first->iov_base = static_cast<std::byte*>(first->iov_base) + done;
      first->iov_len -= done;
    }
  }
  size_ += total;
}

void OutputFile::shorten(std::uint64_t size) {
  if (::ftruncate(descriptor_, static_cast<off_t>(size)) != 0 ||
      ::lseek(descriptor_, static_cast<off_t>(size), SEEK_SET) < 0) {
    throw_system_error(errno, path_, "cannot be cut");
  }
  size_ = size;
}

}  // namespace pipescout::bags
