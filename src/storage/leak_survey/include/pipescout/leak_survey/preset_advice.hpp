// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>

#include "pipescout/leak_survey/survey_settings.hpp"
#include "pipescout/thermal/preset_trial.hpp"

namespace pipescout {

/// What to say where the detector of `settings` found no pipe in any of so many images, of which
/// `trial` has some: what it looks for, which temperatures there are, and which other presets were
/// tried and find pipes. A sentence or two without a line end; empty without a temperature.
[[nodiscard]] std::string preset_advice(const thermal::PresetTrial& trial,
                                        const SurveySettings& settings, std::size_t images);

}  // namespace pipescout
