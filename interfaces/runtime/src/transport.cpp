// SPDX-License-Identifier: Apache-2.0
#include "pipescout/runtime/transport.hpp"

#include <algorithm>
#include <cstddef>
#include <string>
#include <string_view>

namespace pipescout {
namespace {

constexpr std::size_t kPrefixBytes = 12;

}  // namespace

std::string to_string(const Gid& gid) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string text;
  for (std::size_t i = 0; i < gid.bytes.size(); ++i) {
    if (i > 0) {
      text += i == kPrefixBytes ? '|' : '.';
    }
    text += kDigits[gid.bytes[i] >> 4U];
    text += kDigits[gid.bytes[i] & 0xFU];
  }
  return text;
}

bool same_participant(const Gid& a, const Gid& b) noexcept {
  return std::equal(a.bytes.begin(), a.bytes.begin() + kPrefixBytes, b.bytes.begin());
}

Gid participant_of(const Gid& endpoint) noexcept {
  Gid participant = endpoint;
  std::fill(participant.bytes.begin() + kPrefixBytes, participant.bytes.end(), std::uint8_t{0});
  return participant;
}

}  // namespace pipescout
