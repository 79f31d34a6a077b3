// SPDX-License-Identifier: Apache-2.0
#include "exiftool.hpp"

#include <fcntl.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <utility>

extern char** environ;  // NOLINT(readability-redundant-declaration): not in every unistd.h

namespace pipescout {
namespace {

/// A picture of 64 million pixels in base64 is below it.
constexpr std::size_t kMostOutput = 256U << 20U;  // bytes

class Descriptor {
 public:
  explicit Descriptor(int number) : number_(number) {}
  Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
  Descriptor& operator=(Descriptor&&) = delete;
  ~Descriptor() { close(); }
  void close() {
    if (number_ >= 0) {
      ::close(std::exchange(number_, -1));
    }
  }
  [[nodiscard]] int get() const { return number_; }

 private:
  int number_;
};

class FileActions {
 public:
  FileActions() { ::posix_spawn_file_actions_init(&actions_); }
  FileActions(const FileActions&) = delete;
  FileActions& operator=(const FileActions&) = delete;
  ~FileActions() { ::posix_spawn_file_actions_destroy(&actions_); }
  void make(int from, int to) { ::posix_spawn_file_actions_adddup2(&actions_, from, to); }
  void silence(int number) {
    ::posix_spawn_file_actions_addopen(&actions_, number, "/dev/null", O_WRONLY, 0);
  }
  [[nodiscard]] const posix_spawn_file_actions_t* get() const { return &actions_; }

 private:
  posix_spawn_file_actions_t actions_{};
};

/// Until the other end closes; `whole` is false where it was too much or cannot be read.
std::string read_all(int descriptor, bool& whole) {
  std::string text;
  std::array<char, 65536> block{};
  whole = true;
  while (true) {
    const ssize_t size = ::read(descriptor, block.data(), block.size());
    if (size > 0) {
      text.append(block.data(), static_cast<std::size_t>(size));
      if (text.size() > kMostOutput) {
        whole = false;
        return text;
      }
    } else if (size == 0) {
      return text;
    } else if (errno != EINTR) {
      whole = false;
      return text;
    }
  }
}

/// Runs the program with these words behind its options; `actions` give it its files.
std::string output_of(const std::string& program, const std::vector<std::string>& tags,
                      const std::vector<std::string>& files, FileActions& actions) {
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) {
    throw ExiftoolError(std::string("no pipe: ") + std::strerror(errno));
  }
  const Descriptor output(ends[0]);
  Descriptor written(ends[1]);
  actions.make(written.get(), STDOUT_FILENO);
  actions.silence(STDERR_FILENO);

  // -config "": nothing of the user's own configuration is run.
  std::vector<std::string> words{program, "-config", "", "-j", "-n", "-b"};
  words.insert(words.end(), tags.begin(), tags.end());
  words.insert(words.end(), files.begin(), files.end());
  std::vector<char*> pointers;
  for (std::string& word : words) {
    pointers.push_back(word.data());
  }
  pointers.push_back(nullptr);
  pid_t child = 0;
  const int failure =
      ::posix_spawnp(&child, program.c_str(), actions.get(), nullptr, pointers.data(), environ);
  if (failure != 0) {
    throw ExiftoolError("cannot run " + program + ": " + std::strerror(failure) +
                        "; install the Debian package libimage-exiftool-perl");
  }
  written.close();
  bool whole = true;
  std::string text = read_all(output.get(), whole);
  if (!whole) {
    ::kill(child, SIGKILL);
  }
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (!whole) {
    throw ExiftoolError(program + " has more output than an image can have, or cannot be read");
  }
  // 1: something is wrong with the file, which the text says.
  if (!WIFEXITED(status) || WEXITSTATUS(status) > 1) {
    throw ExiftoolError(program + " has failed");
  }
  return text;
}

/// A file in memory with this content.
Descriptor in_memory(std::span<const std::uint8_t> content) {
  Descriptor memory(::memfd_create("image", MFD_CLOEXEC));
  if (memory.get() < 0) {
    throw ExiftoolError(std::string("no file in memory: ") + std::strerror(errno));
  }
  while (!content.empty()) {
    const ssize_t size = ::write(memory.get(), content.data(), content.size());
    if (size < 0 && errno != EINTR) {
      throw ExiftoolError(std::string("no file in memory: ") + std::strerror(errno));
    }
    content = content.subspan(static_cast<std::size_t>(std::max<ssize_t>(size, 0)));
  }
  ::lseek(memory.get(), 0, SEEK_SET);
  return memory;
}

}  // namespace

std::string exiftool_json(const std::string& program, const std::vector<std::string>& tags,
                          std::span<const std::uint8_t> content) {
  const Descriptor input = in_memory(content);
  FileActions actions;
  actions.make(input.get(), STDIN_FILENO);
  return output_of(program, tags, {"-"}, actions);
}

std::string exiftool_json(const std::string& program, const std::vector<std::string>& tags,
                          std::span<const std::filesystem::path> files) {
  std::vector<Descriptor> open;
  std::vector<std::string> names;
  FileActions actions;
  for (const std::filesystem::path& file : files) {
    // What cannot be opened, or would wait for a writer, is an empty file, so that the order stays.
    std::error_code error;
    const int number = std::filesystem::is_regular_file(file, error)
                           ? ::open(file.c_str(), O_RDONLY | O_CLOEXEC)
                           : -1;
    open.emplace_back(number >= 0 ? number : ::open("/dev/null", O_RDONLY | O_CLOEXEC));
    if (open.back().get() < 0) {
      throw ExiftoolError(std::strerror(errno));
    }
    // Duplicated to itself, a descriptor is inherited.
    actions.make(open.back().get(), open.back().get());
    names.push_back("/dev/fd/" + std::to_string(open.back().get()));
  }
  return output_of(program, tags, names, actions);
}

}  // namespace pipescout
