// SPDX-License-Identifier: Apache-2.0
#include "program.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/file.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace pipescout::host {
namespace {

std::string environment_prefixes() {
  const char* outside = std::getenv("AMENT_PREFIX_PATH");
  return std::string(TEST_PREFIX) + (outside != nullptr ? ":" + std::string(outside) : "");
}

/// A DDS domain for the tests of this process alone: those of other processes run side by side.
/// That of the environment where there is one, as ctest gives it.
int own_domain() {
  if (const char* given = std::getenv("ROS_DOMAIN_ID"); given != nullptr && *given != '\0') {
    return std::stoi(given);
  }
  constexpr int kDomains = 100;
  for (int i = 0; i < kDomains; ++i) {
    const int domain = 1 + (getpid() + i) % kDomains;
    const auto file =
        std::filesystem::temp_directory_path() / ("pipescout_domain_" + std::to_string(domain));
    const int lock = open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (lock >= 0 && flock(lock, LOCK_EX | LOCK_NB) == 0) {
      return domain;  // held until this process ends
    }
    close(lock);
  }
  throw std::runtime_error("no DDS domain is free");
}

struct ProcessStatus {
  char state = '\0';  ///< NUL when there is no such process
  pid_t parent = 0;
};

ProcessStatus status_of(pid_t pid) {
  std::ifstream stream("/proc/" + std::to_string(pid) + "/stat");
  std::string line;
  std::getline(stream, line);
  // "pid (name) state parent ...", where the name may hold anything.
  std::istringstream rest(line.substr(std::min(line.size(), line.rfind(')') + 1)));
  ProcessStatus status;
  rest >> status.state >> status.parent;
  return status;
}

}  // namespace

int Finished::code() const {
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

int Finished::signal() const {
  return WIFSIGNALED(status) ? WTERMSIG(status) : 0;
}

Program::Program(const std::vector<std::string>& arguments, const std::filesystem::path& folder) {
  std::vector<std::string> words{PIPESCOUT_PROGRAM};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (auto& word : words) {
    argv.push_back(word.data());
  }
  argv.push_back(nullptr);
  setenv("ROS_LOCALHOST_ONLY", "1", 1);
  static const std::string kDomain = std::to_string(own_domain());
  setenv("ROS_DOMAIN_ID", kDomain.c_str(), 1);
  static const std::string kPrefixes = environment_prefixes();
  setenv("AMENT_PREFIX_PATH", kPrefixes.c_str(), 1);
  std::array<int, 2> out{};
  std::array<int, 2> err{};
  if (pipe2(out.data(), O_CLOEXEC) != 0 || pipe2(err.data(), O_CLOEXEC) != 0) {
    throw std::runtime_error("pipe2 failed");
  }
  const pid_t parent = getpid();
  pid_ = fork();
  if (pid_ == 0) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    // Under nohup it would be ignored.
    ::signal(SIGHUP, SIG_DFL);
    dup2(out[1], STDOUT_FILENO);
    dup2(err[1], STDERR_FILENO);
    if (getppid() == parent && chdir(folder.c_str()) == 0) {
      execv(argv.front(), argv.data());
    }
    _exit(127);
  }
  close(out[1]);
  close(err[1]);
  out_.fd = out[0];
  err_.fd = err[0];
  for (auto* stream : {&out_, &err_}) {
    stream->reader = std::thread([this, stream] { collect(*stream); });
  }
}

Program::~Program() {
  if (!reaped_) {
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }
  for (auto* stream : {&out_, &err_}) {
    stream->reader.join();
    close(stream->fd);
  }
}

void Program::collect(Stream& stream) {
  std::array<char, 4096> buffer{};
  while (true) {
    const auto size = read(stream.fd, buffer.data(), buffer.size());
    if (size < 0 && errno == EINTR) {
      continue;
    }
    const std::lock_guard lock(mutex_);
    if (size <= 0) {
      stream.ended = true;
      changed_.notify_all();
      return;
    }
    stream.text.append(buffer.data(), static_cast<std::size_t>(size));
    changed_.notify_all();
  }
}

void Program::signal(int number) const {
  kill(pid_, number);
}

bool Program::wait_for(const Stream& stream, const std::string& text) {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, kPatience,
                    [&] { return stream.ended || stream.text.find(text) != std::string::npos; });
  return stream.text.find(text) != std::string::npos;
}

bool Program::wait_for_out(const std::string& text) {
  return wait_for(out_, text);
}

bool Program::wait_for_err(const std::string& text) {
  return wait_for(err_, text);
}

std::string Program::out() {
  const std::lock_guard lock(mutex_);
  return out_.text;
}

std::string Program::err() {
  const std::lock_guard lock(mutex_);
  return err_.text;
}

Finished Program::finish() {
  const int process = static_cast<int>(syscall(SYS_pidfd_open, pid_, 0));
  pollfd descriptor{process, POLLIN, 0};
  constexpr int kMilliseconds =
      static_cast<int>(std::chrono::duration_cast<std::chrono::milliseconds>(kPatience).count());
  if (process < 0 || poll(&descriptor, 1, kMilliseconds) != 1) {
    kill(pid_, SIGKILL);
  }
  close(process);
  Finished finished;
  waitpid(pid_, &finished.status, 0);
  reaped_ = true;
  std::unique_lock lock(mutex_);
  // Its children may hold the streams for a moment longer.
  changed_.wait_for(lock, kPatience, [&] { return out_.ended && err_.ended; });
  finished.out = out_.text;
  finished.err = err_.text;
  return finished;
}

Finished run_program(const std::vector<std::string>& arguments,
                     const std::filesystem::path& folder) {
  return Program(arguments, folder).finish();
}

std::vector<pid_t> children_of(pid_t pid) {
  std::vector<pid_t> children;
  for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
    const auto name = entry.path().filename().string();
    if (name.find_first_not_of("0123456789") != std::string::npos) {
      continue;
    }
    const auto child = static_cast<pid_t>(std::stol(name));
    const auto status = status_of(child);
    if (status.parent == pid && status.state != 'Z') {
      children.push_back(child);
    }
  }
  return children;
}

bool is_running(pid_t pid) {
  const auto state = status_of(pid).state;
  return state != '\0' && state != 'Z';
}

std::set<std::string> sockets_of(pid_t pid) {
  std::set<std::string> sockets;
  for (const auto& entry :
       std::filesystem::directory_iterator("/proc/" + std::to_string(pid) + "/fd")) {
    std::error_code closed_meanwhile;
    auto file = std::filesystem::read_symlink(entry, closed_meanwhile).string();
    if (file.starts_with("socket:")) {
      sockets.insert(std::move(file));
    }
  }
  return sockets;
}

std::set<std::string> shared_memory_of(pid_t pid) {
  std::set<std::string> files;
  std::ifstream stream("/proc/" + std::to_string(pid) + "/maps");
  for (std::string line; std::getline(stream, line);) {
    if (const auto file = line.find("/dev/shm/"); file != std::string::npos) {
      files.insert(line.substr(file));
    }
  }
  return files;
}

bool eventually(const std::function<bool()>& condition) {
  const auto end = std::chrono::steady_clock::now() + kPatience;
  while (!condition()) {
    if (std::chrono::steady_clock::now() >= end) {
      return false;
    }
    // No event: nothing tells of a change in another process.
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return true;
}

}  // namespace pipescout::host
