// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <future>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "stage_progress.hpp"

namespace pipescout::reproduce {

/// Results of `work(seed)` in the order of the seeds; as many at once as there are processors.
template <class Work>
auto for_each_seed(StageProgress& progress, const std::string& stage,
                   const std::vector<std::uint64_t>& seeds, Work work) {
  using Result = decltype(work(std::uint64_t{}));
  std::vector<Result> results(seeds.size());
  std::atomic<std::size_t> next = 0;
  std::mutex at_progress;
  const auto worker = [&] {
    for (std::size_t i = next++; i < seeds.size(); i = next++) {
      results[i] = work(seeds[i]);
      const std::lock_guard lock(at_progress);
      progress.step();
    }
  };
  progress.begin(stage, seeds.size());
  std::vector<std::future<void>> workers;
  for (unsigned i = 0; i < std::max(1U, std::thread::hardware_concurrency()); ++i) {
    workers.push_back(std::async(std::launch::async, worker));
  }
  for (auto& each_worker : workers) {
    each_worker.get();
  }
  progress.end();
  return results;
}

}  // namespace pipescout::reproduce
