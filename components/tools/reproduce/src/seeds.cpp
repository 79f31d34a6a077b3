// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <charconv>
#include <numeric>

#include "reproduce.hpp"

namespace pipescout::reproduce {

std::vector<std::uint64_t> seeds_of(const ReproduceOptions& options, std::size_t count) {
  std::vector<std::uint64_t> seeds(count);
  std::iota(seeds.begin(), seeds.end(), options.seed_base);
  return seeds;
}

std::optional<std::uint64_t> seed_base_of(std::string_view revision) {
  constexpr std::size_t kDigits = 8;
  constexpr std::uint64_t kBlock = 1000;        // seeds that no table exceeds by much
  constexpr std::uint64_t kBlocks = 1'000'000;  // so that seeds stay easy to type
  const std::string_view digits = revision.substr(0, kDigits);
  std::uint32_t hash = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), hash, 16);
  if (digits.size() < kDigits || error != std::errc() || end != digits.data() + kDigits) {
    return std::nullopt;
  }
  return kBlock * (1 + hash % kBlocks);
}

}  // namespace pipescout::reproduce
