// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "pipescout/runtime/parameter_value.hpp"

namespace pipescout {

/// The double or double array that a text means. `ros2 param load` sends 4.0e-09 as the text
/// "4e-09", since it writes the numbers of a file in Python's form and then reads that by YAML 1.1,
/// which sees no number without a '.'; an array with such an element comes as an array of texts or
/// as one text,
/// "[4e-09, 1.0]". Nothing for any other `type`, and for a text that is not wholly a number.
[[nodiscard]] std::optional<ParameterValue> numbers_from_text(const ParameterValue& value,
                                                              ParameterType type);

}  // namespace pipescout
