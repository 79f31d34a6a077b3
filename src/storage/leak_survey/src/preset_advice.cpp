// SPDX-License-Identifier: Apache-2.0
#include "pipescout/leak_survey/preset_advice.hpp"

#include "pipescout/validation/number_text.hpp"

namespace pipescout {
namespace {

std::string sought(const thermal::LeakDetectorParameters& detector) {
  const bool hot = detector.polarity == thermal::Polarity::kHot;
  switch (detector.threshold_rule) {
    case thermal::ThresholdRule::kFixed:
      return std::string("what is ") + (hot ? "above " : "below ") +
             validation::number_text(detector.threshold) + " degC";
    case thermal::ThresholdRule::kScene:
    case thermal::ThresholdRule::kLocal:
      return std::string("what is ") + (hot ? "warmer" : "colder") + " than its surroundings";
    case thermal::ThresholdRule::kContrast:
      return "the longest straight ridge";
  }
  return "pipes";
}

}  // namespace

std::string preset_advice(const thermal::PresetTrial& trial, const SurveySettings& settings,
                          std::size_t images) {
  const auto range = trial.temperatures();
  if (!range) {
    return {};
  }
  std::string text = "no pipe in " + std::to_string(images) + (images == 1 ? " image" : " images") +
                     " with preset " + std::string(to_string(settings.preset)) +
                     ", which looks for " + sought(settings.detector) + "; the images are from " +
                     validation::fixed_text(range->low, 1) + " to " +
                     validation::fixed_text(range->high, 1) + " degC. Tried on " +
                     std::to_string(trial.images()) + " of them: ";
  const auto outcomes = trial.try_others(settings.preset);
  for (const thermal::PresetTrial::Outcome& outcome : outcomes) {
    text += (&outcome == &outcomes.front() ? "" : ", ") + std::string("--preset ") +
            std::string(to_string(outcome.preset)) + " finds pipes in " +
            std::to_string(outcome.with_pipes);
  }
  return text + (outcomes.empty() ? "no other preset finds pipes either" : "");
}

}  // namespace pipescout
