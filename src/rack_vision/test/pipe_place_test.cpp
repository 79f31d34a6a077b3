// SPDX-License-Identifier: Apache-2.0
#include "pipe_place.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace pipescout::rack_vision {
namespace {

constexpr double kHalfWidth = 0.004;
constexpr double kLeast = 0.6;

std::vector<PlaceVote> votes_at(const std::vector<std::vector<double>>& samples) {
  std::vector<PlaceVote> votes;
  for (std::uint32_t i = 0; i < samples.size(); ++i) {
    for (const double offset : samples[i]) {
      votes.push_back({offset, kHalfWidth, i});
    }
  }
  return votes;
}

TEST(AgreedPlace, IsTheMeanOfWhatMostSamplesSay) {
  const auto votes =
      votes_at({{0.014, -0.03}, {0.016}, {0.015, 0.02}, {0.015}, {-0.02}, {0.001, 0.015}});
  const auto place = agreed_place(votes, 6, kLeast);
  ASSERT_TRUE(place);
  EXPECT_NEAR(*place, 0.015, 1e-9);
}

TEST(AgreedPlace, CountsEachSampleOnce) {
  // Many votes of one sample are not many samples.
  const auto votes = votes_at({{0.015, 0.0151, 0.0152, 0.0153}, {-0.01}, {0.03}});
  EXPECT_FALSE(agreed_place(votes, 3, kLeast));
}

TEST(AgreedPlace, IsNoneWhereTooFewAgree) {
  const auto votes = votes_at({{0.015}, {0.015}, {0.015}, {}, {}, {}});
  EXPECT_FALSE(agreed_place(votes, 6, kLeast));
  EXPECT_TRUE(agreed_place(votes, 5, kLeast)) << "three of five are enough";
}

TEST(AgreedPlace, IsNoneBetweenTwoThatDoAboutAsWell) {
  const std::vector<std::vector<double>> alike{{0.015, -0.02}, {0.015, -0.02}, {0.015, -0.02},
                                               {0.015, -0.02}, {0.015, -0.02}, {0.015, -0.02},
                                               {0.015}};
  EXPECT_FALSE(agreed_place(votes_at(alike), 7, 0.8)) << "seven against six";
  const std::vector<std::vector<double>> clear{{0.015, -0.02}, {0.015, -0.02}, {0.015}, {0.015}};
  EXPECT_TRUE(agreed_place(votes_at(clear), 4, 0.8));
  const std::vector<std::vector<double>> beside{{0.015, 0.022}, {0.015, 0.022}, {0.015, 0.022}};
  EXPECT_TRUE(agreed_place(votes_at(beside), 3, 0.8)) << "within three half widths it is no other";
}

TEST(AgreedPlace, IsNoneWithoutVotes) {
  EXPECT_FALSE(agreed_place({}, 0, kLeast));
  EXPECT_FALSE(agreed_place({}, 20, kLeast));
}

}  // namespace
}  // namespace pipescout::rack_vision
