// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <initializer_list>

#include "bytes.hpp"

namespace pipescout::bags {

/// A file that is read at any place. Throws BagError naming it.
class InputFile {
 public:
  explicit InputFile(std::filesystem::path path);
  ~InputFile();
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const noexcept { return path_; }
  /// When it was opened.
  [[nodiscard]] std::uint64_t size() const noexcept { return size_; }
  /// The bytes from `offset` on, fewer than asked for where the file ends.
  void read(std::uint64_t offset, std::uint64_t size, Bytes& into) const;

 private:
  std::filesystem::path path_;
  int descriptor_;
  std::uint64_t size_;
};

/// A new file that grows at its end, without a buffer. Throws BagError naming it.
class OutputFile {
 public:
  /// Fault kExists when the file exists.
  explicit OutputFile(std::filesystem::path path);
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const noexcept { return path_; }
  [[nodiscard]] std::uint64_t size() const noexcept { return size_; }
  /// All of the parts or nothing: what was written of them before an error is taken back.
  void write(std::initializer_list<ByteView> parts);
  /// Cuts the file back to an earlier size.
  void shorten(std::uint64_t size);

 private:
  std::filesystem::path path_;
  int descriptor_;
  std::uint64_t size_ = 0;
};

/// What errno means for a bag, with the system's text.
[[noreturn]] void throw_system_error(int error, const std::filesystem::path& file,
                                     const std::string& what);

}  // namespace pipescout::bags
