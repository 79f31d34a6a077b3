// SPDX-License-Identifier: Apache-2.0
#include "pipescout/thermal_parameters/survey_parameters.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <stdexcept>
#include <string>
#include <vector>

#include "pipescout/thermal_parameters/detection_parameters.hpp"
#include "pipescout/thermal_parameters/findings_parameters.hpp"

namespace pipescout {
namespace {

using ::testing::StartsWith;
using ::testing::ThrowsMessage;

struct Settings {
  thermal::LeakDetectorParameters detector;
  leak_findings::LeakFindingsParameters findings;
};

Settings read(const std::string& text,
              thermal::DetectorPreset preset = thermal::DetectorPreset::kCollectors) {
  Settings result;
  read_survey_parameters(YAML::Load(text), "survey.yaml", preset, result.detector, result.findings);
  return result;
}

TEST(SurveyParameters, AreThoseOfTheInspectorOnTopOfThePreset) {
  const Settings s =
      read("{threshold: 90.0, leak_delta: [60.0], raise_probability: 0.95, severe_delta: 140.0}",
           thermal::DetectorPreset::kHotPipes);
  EXPECT_EQ(s.detector.threshold, 90);
  EXPECT_EQ(s.detector.profile.leak_delta, 60);
  EXPECT_EQ(s.detector.threshold_rule,
            thermal::LeakDetectorParameters::of(thermal::DetectorPreset::kHotPipes).threshold_rule);
  EXPECT_EQ(s.findings.raise_probability, 0.95);
  EXPECT_EQ(s.findings.severity.severe_delta, 140) << "as the detector";
}

TEST(SurveyParameters, OfAnInspectorAreReadBackAsTheyWere) {
  const std::vector<ParameterOverride> told{
      {.name = "preset", .value = "hot_pipes"},
      {.name = "threshold", .value = 50 + 100.0 / 3},
      {.name = "leak_delta", .value = std::vector<double>{}},
      {.name = "maximum_temperature", .value = std::vector<double>{250.1}},
      {.name = "max_pipes", .value = 3},
      {.name = "polarity", .value = "hot"},
      {.name = "threshold_rule", .value = "scene"},
      {.name = "split_creeping", .value = false}};
  Parameters inspector(told);
  const DetectionParameters detection(inspector);
  const FindingsParameters findings(inspector);
  const Settings s = read(survey_parameters(inspector), thermal::DetectorPreset::kHotPipes);
  EXPECT_EQ(s.detector.threshold, 50 + 100.0 / 3);
  EXPECT_FALSE(s.detector.profile.leak_delta.has_value());
  EXPECT_EQ(s.detector.profile.maximum_temperature, 250.1);
  EXPECT_EQ(s.detector.max_pipes, 3U);
  EXPECT_EQ(s.detector.polarity, thermal::Polarity::kHot);
  EXPECT_EQ(s.detector.threshold_rule, thermal::ThresholdRule::kScene);
  EXPECT_FALSE(s.detector.profile.split_creeping);
}

TEST(SurveyParameters, ErrorsNameFileAndLine) {
  const auto throws = [](const char* begin) {
    return ThrowsMessage<std::runtime_error>(StartsWith(begin));
  };
  EXPECT_THAT([] { (void)read("\nthreshhold: 90.0"); }, throws("survey.yaml:2: "));
  EXPECT_THAT([] { (void)read("threshold: hot"); }, throws("survey.yaml:1: "));
  EXPECT_THAT([] { (void)read("object.distance: 3.0"); },
              throws("survey.yaml:1: parameter 'object.distance' has a separate entry"));
}

}  // namespace
}  // namespace pipescout
