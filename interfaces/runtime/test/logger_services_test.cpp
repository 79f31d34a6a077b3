// SPDX-License-Identifier: Apache-2.0
#include "logger_services.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "pipescout/testing/component_harness.hpp"

namespace pipescout {
namespace {

using rcl_interfaces::msg::LoggerLevel;
using rcl_interfaces::srv::GetLoggerLevels;
using rcl_interfaces::srv::SetLoggerLevels;

class Quiet : public Component {
 public:
  explicit Quiet(ComponentOptions options) : Component(std::move(options)) {}
};

class LoggerServicesTest : public ::testing::Test {
 protected:
  std::uint32_t level_of(const std::string& name) {
    GetLoggerLevels::Request request;
    request.names = {name};
    const auto result = harness_.call<GetLoggerLevels>("/quiet/get_logger_levels", request);
    return result && result->levels.size() == 1 && result->levels[0].name == name
               ? result->levels[0].level
               : 999;
  }
  std::vector<std::pair<bool, std::string>> set(
      const std::vector<std::pair<std::string, std::uint32_t>>& levels) {
    SetLoggerLevels::Request request;
    for (const auto& [name, value] : levels) {
      request.levels.emplace_back();
      request.levels.back().name = name;
      request.levels.back().level = value;
    }
    const auto result = harness_.call<SetLoggerLevels>("/quiet/set_logger_levels", request);
    std::vector<std::pair<bool, std::string>> answers;
    for (std::size_t i = 0; result && i < result->results.size(); ++i) {
      answers.emplace_back(result->results[i].successful, result->results[i].reason);
    }
    return answers;
  }

  testing::ComponentHarness harness_;
  Quiet& component_ = harness_.make<Quiet>({.name = "quiet"});
};

TEST_F(LoggerServicesTest, TellAndSetTheLevelOfTheNode) {
  EXPECT_EQ(level_of("quiet"), LoggerLevel::LOG_LEVEL_INFO);
  EXPECT_THAT(set({{"quiet", LoggerLevel::LOG_LEVEL_DEBUG}}),
              ::testing::ElementsAre(::testing::Pair(true, "")));
  EXPECT_EQ(level_of("quiet"), LoggerLevel::LOG_LEVEL_DEBUG);
}

TEST_F(LoggerServicesTest, RefuseWhatTheyDoNotKnow) {
  EXPECT_EQ(level_of("other"), LoggerLevel::LOG_LEVEL_UNKNOWN);
  EXPECT_THAT(
      set({{"other", 20}, {"quiet", 25}, {"quiet", 40}}),
      ::testing::ElementsAre(::testing::Pair(false, "there is no logger 'other' here, but 'quiet'"),
                             ::testing::Pair(false, ::testing::StartsWith("unknown level 25")),
                             ::testing::Pair(true, "")));
  EXPECT_EQ(level_of("quiet"), LoggerLevel::LOG_LEVEL_ERROR);
}

}  // namespace
}  // namespace pipescout
