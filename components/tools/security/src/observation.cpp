// SPDX-License-Identifier: Apache-2.0
#include "observation.hpp"

#include <fcntl.h>
#include <spawn.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <condition_variable>
#include <csignal>
#include <fstream>
#include <iterator>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <system_error>

#include "pipescout/command_line/command.hpp"
#include "pipescout/dds/dds_transport.hpp"
#include "pipescout/files/temporary_folder.hpp"

namespace pipescout::security {
namespace {

using command_line::CommandError;

/// `pipescout run` in a folder that is removed with it; stopped at the end. What it prints is kept
/// there too.
class CompositionRun {
 public:
  CompositionRun(const std::vector<std::string>& words, const std::string& ns) {
    std::vector<std::string> all{"pipescout", "run"};
    all.insert(all.end(), words.begin(), words.end());
    all.insert(all.end(), {"--out", (folder_.path() / "mission").string()});
    if (!ns.empty()) {
      all.insert(all.end(), {"--namespace", ns});
    }
    std::vector<char*> argv;
    for (auto& word : all) {
      argv.push_back(word.data());
    }
    argv.push_back(nullptr);
    posix_spawn_file_actions_t files;
    posix_spawn_file_actions_init(&files);
    posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, log_.c_str(),
                                     O_WRONLY | O_CREAT | O_APPEND, S_IRUSR | S_IWUSR);
    posix_spawn_file_actions_adddup2(&files, STDOUT_FILENO, STDERR_FILENO);
    const int failure = posix_spawnp(&pid_, "pipescout", &files, nullptr, argv.data(), environ);
    posix_spawn_file_actions_destroy(&files);
    if (failure != 0) {
      throw CommandError("cannot run 'pipescout': " + std::generic_category().message(failure));
    }
  }
  CompositionRun(const CompositionRun&) = delete;
  CompositionRun& operator=(const CompositionRun&) = delete;
  ~CompositionRun() {
    if (!ended_) {
      kill(pid_, SIGTERM);  // it ends within two seconds
      waitpid(pid_, nullptr, 0);
    }
  }

  void check() {
    int status = 0;
    if (!ended_ && waitpid(pid_, &status, WNOHANG) == pid_) {
      ended_ = true;
      if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) {
        std::ifstream printed(log_, std::ios::binary);
        throw CommandError("the composition ended with an error before it was observed:\n" +
                           std::string(std::istreambuf_iterator<char>(printed), {}));
      }
    }
  }

 private:
  TemporaryFolder folder_;
  const std::string log_ = (folder_.path() / "log").string();
  pid_t pid_ = -1;
  bool ended_ = false;
};

}  // namespace

keystore::Policy observe(const ObservationRequest& request) {
  using Clock = std::chrono::steady_clock;
  std::mutex mutex;
  std::condition_variable changed;
  auto last_change = Clock::now();
  // Endpoints that are gone again count too.
  std::map<Gid, std::string> enclaves;
  std::map<Gid, DiscoveredEndpoint> endpoints;

  auto dds = DdsOptions::from_environment();
  dds.name = "pipescout security";
  dds.super_client = true;
  const auto transport = create_dds_transport(dds);
  const auto look = [&] {
    const std::lock_guard lock(mutex);
    for (const auto& participant : transport->remote_participants()) {
      enclaves[participant.gid] = participant.enclave;
    }
    for (const auto& endpoint : transport->remote_endpoints()) {
      if (endpoints.try_emplace(endpoint.gid, endpoint).second) {
        last_change = Clock::now();
        changed.notify_all();
      }
    }
  };
  transport->on_graph_changed(look);
  look();
  {
    std::optional<CompositionRun> run;
    if (!request.composition.empty()) {
      run.emplace(request.composition, request.ns);
    }
    const auto deadline = Clock::now() + request.at_most;
    std::unique_lock lock(mutex);
    while (Clock::now() < deadline) {
      const auto complete = last_change + request.quiet;
      if (Clock::now() >= complete && (!endpoints.empty() || !run)) {
        break;
      }
      constexpr auto kChildCheck = std::chrono::milliseconds(200);
      changed.wait_until(lock, std::min(deadline, Clock::now() + kChildCheck));
      if (run) {
        run->check();
      }
    }
  }
  transport->on_graph_changed(nullptr);
  keystore::Policy policy;
  for (const auto& [gid, endpoint] : endpoints) {
    const auto known = enclaves.find(endpoint.participant);
    if (!request.enclave.empty()) {
      keystore::add_endpoint(policy[request.enclave], endpoint.topic, endpoint.is_writer);
    } else if (known != enclaves.end() && !known->second.empty()) {
      keystore::add_endpoint(policy[known->second], endpoint.topic, endpoint.is_writer);
    }
  }
  if (policy.empty()) {
    throw CommandError("no ROS node was seen on domain " + std::to_string(dds.domain_id));
  }
  return policy;
}

}  // namespace pipescout::security
