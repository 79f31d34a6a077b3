// SPDX-License-Identifier: Apache-2.0
#include "core/name_claim.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <string_view>
#include <utility>

namespace pipescout::host {
namespace {

// Text: "1,STATE,AGE,HASHES[,ANSWER]...": the version of this format; 'a' (asks), 'h' (holds) or
// 'g' (has given up); ms; four letters for each name; and "GUID:VERDICT:NAME" with the prefix of
// the other's participant in hexadecimal digits, '+' (the writer is older and stays) or '?', and a
// name that both have.
constexpr std::string_view kVersion = "1";
constexpr char kOlder = '+';
constexpr char kUnjudged = '?';
constexpr std::size_t kPrefixBytes = 12;

// As base64url; none of the letters has a meaning elsewhere in the text.
constexpr std::string_view kLetters =
    "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_";
constexpr unsigned kBitsOfLetter = 6;
constexpr std::size_t kLettersOfHash = 4;
constexpr std::uint32_t kHashMask = (1U << (kBitsOfLetter * kLettersOfHash)) - 1U;

/// FNV-1a (Fowler, Noll, Vo), folded to 24 bits.
std::uint32_t hash_of(std::string_view name) {
  std::uint32_t hash = 2166136261U;
  for (const char letter : name) {
    hash = (hash ^ static_cast<unsigned char>(letter)) * 16777619U;
  }
  return ((hash >> 24U) ^ hash) & kHashMask;
}

std::string to_letters(std::uint32_t hash) {
  std::string letters(kLettersOfHash, 'A');
  for (std::size_t k = kLettersOfHash; k-- > 0; hash >>= kBitsOfLetter) {
    letters[k] = kLetters[hash % kLetters.size()];
  }
  return letters;
}

std::optional<std::uint32_t> from_letters(std::string_view letters) {
  std::uint32_t hash = 0;
  for (const char letter : letters) {
    const auto value = kLetters.find(letter);
    if (value == std::string_view::npos) {
      return std::nullopt;
    }
    hash = (hash << kBitsOfLetter) | static_cast<std::uint32_t>(value);
  }
  return hash;
}

std::string prefix_text(const Gid& gid) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string text;
  for (std::size_t k = 0; k < kPrefixBytes; ++k) {
    text += kDigits[gid.bytes[k] >> 4U];
    text += kDigits[gid.bytes[k] & 0xFU];
  }
  return text;
}

std::string_view next_part(std::string_view& rest, char separator) {
  const auto end = std::min(rest.find(separator), rest.size());
  const auto part = rest.substr(0, end);
  rest.remove_prefix(std::min(end + 1, rest.size()));
  return part;
}

char letter_of(NameClaim::State state) {
  switch (state) {
    case NameClaim::State::kAsking:
      return 'a';
    case NameClaim::State::kHolding:
      return 'h';
    default:
      return 'g';
  }
}

std::optional<NameClaim::State> state_of(std::string_view letter) {
  for (const auto state :
       {NameClaim::State::kAsking, NameClaim::State::kHolding, NameClaim::State::kGivenUp}) {
    if (letter.size() == 1 && letter.front() == letter_of(state)) {
      return state;
    }
  }
  return std::nullopt;
}

}  // namespace

NameClaim::NameClaim(Gid self, const std::vector<NodeName>& names, Pace pace, SteadyTime now)
    : self_(self), pace_(pace), since_(now), rounds_left_(pace.rounds) {
  for (const auto& name : names) {
    auto full = name.fully_qualified();
    const auto hash = hash_of(full);
    names_.emplace(hash, std::move(full));
  }
}

void NameClaim::hear(const std::map<Gid, std::string>& others, SteadyTime now) {
  std::erase_if(others_, [&](const auto& known) { return !others.contains(known.first); });
  for (const auto& [gid, text] : others) {
    const auto known = others_.find(gid);
    if (known == others_.end() || known->second.text != text) {
      take(gid, text, now);
    }
  }
  if (const auto found = rival(); state_ == State::kHolding && found && found->wins) {
    winner_ = found;
    state_ = State::kGivenUp;
    has_news_ = true;
  }
}

/// A text that is not understood, of a later version for instance, claims nothing.
void NameClaim::take(const Gid& gid, const std::string& text, SteadyTime now) {
  Other& other = others_[gid];
  const bool was_rival = !other.shared.empty();
  const bool is_new = other.text.empty();
  other.text = text;
  other.shared.clear();
  other.is_met = false;
  other.says_older = false;
  std::string_view rest = text;
  const auto version = next_part(rest, ',');
  const auto state = state_of(next_part(rest, ','));
  const auto age_text = next_part(rest, ',');
  std::int64_t age = -1;
  const auto parsed = std::from_chars(age_text.data(), age_text.data() + age_text.size(), age);
  auto hashes = next_part(rest, ',');
  if (version != kVersion || !state || parsed.ec != std::errc{} || age < 0) {
    return;
  }
  other.state = *state;
  other.age = std::chrono::milliseconds(age);
  other.since = is_new ? now - other.age : std::min(other.since, now - other.age);
  if (*state == State::kGivenUp) {
    other.verdict = Verdict::kNone;
    return;
  }
  while (hashes.size() >= kLettersOfHash && other.shared.empty()) {
    const auto hash = from_letters(hashes.substr(0, kLettersOfHash));
    hashes.remove_prefix(kLettersOfHash);
    if (const auto own = hash ? names_.find(*hash) : names_.end(); own != names_.end()) {
      other.shared = own->second;
    }
  }
  if (other.shared.empty()) {
    return;
  }
  const auto self = prefix_text(self_);
  while (!rest.empty()) {
    auto answer = next_part(rest, ',');
    if (next_part(answer, ':') != self) {
      continue;
    }
    const bool says_older = next_part(answer, ':') == std::string_view(&kOlder, 1);
    const auto own = names_.find(hash_of(answer));
    if (own == names_.end() || own->second != answer) {
      other.shared.clear();  // another name with the same hash
      return;
    }
    other.is_met = true;
    other.says_older = says_older;
    other.shared = answer;
  }
  other.heard_at = now;
  other.silent_rounds = 0;
  judge(gid, other);
  has_news_ = true;  // it gets an answer, with each text of its own
  if (!was_rival && state_ == State::kAsking) {
    rounds_left_ = pace_.rounds;
  }
}

void NameClaim::judge(const Gid& gid, Other& other) const {
  const bool is_mine_to_judge = self_ < gid;
  if (!is_mine_to_judge || !other.is_met || other.verdict != Verdict::kNone ||
      other.state != state_) {
    return;
  }
  other.verdict = since_ <= other.since ? Verdict::kOlder : Verdict::kYounger;
}

bool NameClaim::loses_to(const Gid& gid, const Other& other) const {
  if (other.state != state_) {
    return state_ == State::kAsking;
  }
  return self_ < gid ? other.verdict == Verdict::kYounger : other.says_older;
}

/// One that is silent although it is asked has gone, and nobody has told yet.
bool NameClaim::is_live_rival(const Other& other) const {
  return !other.shared.empty() && other.is_met && other.silent_rounds <= pace_.rounds;
}

std::optional<NameClaim::Rival> NameClaim::rival() const {
  if (state_ == State::kGivenUp) {
    return winner_;
  }
  std::optional<Rival> found;
  for (const auto& [gid, other] : others_) {
    if (is_live_rival(other) && (!found || !found->wins)) {
      const bool wins = loses_to(gid, other);
      if (!found || wins) {
        found = {gid, other.shared, wins, other.age};
      }
    }
  }
  return found;
}

/// Something that is to be announced again, for what was said may have been lost.
bool NameClaim::has_open_question() const {
  return state_ == State::kAsking ||
         (state_ == State::kHolding &&
          std::any_of(others_.begin(), others_.end(), [&](const auto& entry) {
            const Other& other = entry.second;
            return !other.shared.empty() && other.silent_rounds < pace_.rounds;
          }));
}

std::optional<SteadyTime> NameClaim::due() const {
  if (!has_news_ && !has_open_question()) {
    return std::nullopt;
  }
  return announced_at_ ? *announced_at_ + pace_.period : SteadyTime{};
}

std::optional<std::string> NameClaim::on_time(SteadyTime now) {
  const auto when = due();
  if (!when || now < *when) {
    return std::nullopt;
  }
  if (state_ == State::kAsking && rounds_left_ == 0 && !rival()) {
    state_ = State::kHolding;
    has_news_ = true;
    for (auto& [gid, other] : others_) {
      judge(gid, other);
    }
  }
  rounds_left_ = std::max(rounds_left_ - 1, 0);
  for (auto& [gid, other] : others_) {
    ++other.silent_rounds;
  }
  has_news_ = false;
  announced_at_ = now;
  return text(now);
}

std::string NameClaim::text(SteadyTime now) const {
  const auto age = std::chrono::duration_cast<std::chrono::milliseconds>(now - since_).count();
  std::string text =
      std::string(kVersion) + ',' + letter_of(state_) + ',' + std::to_string(age) + ',';
  if (state_ == State::kGivenUp) {
    return text;
  }
  for (const auto& [hash, name] : names_) {
    text += to_letters(hash);
  }
  for (const auto& [gid, other] : others_) {
    if (!other.shared.empty() && other.silent_rounds <= pace_.rounds) {
      const bool older = other.verdict == Verdict::kOlder;
      text += ',' + prefix_text(gid) + ':' + (older ? kOlder : kUnjudged) + ':' + other.shared;
    }
  }
  return text;
}

}  // namespace pipescout::host
