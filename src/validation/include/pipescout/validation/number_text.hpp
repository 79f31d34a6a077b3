// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace pipescout::validation {

/// A number for a message to people: nine significant digits at most, none that say nothing, and a
/// point whatever the locale of the program: "0.5", "1e-09", "nan". std::to_string follows the
/// locale, and has six places of every number.
[[nodiscard]] std::string number_text(double value);

/// With that many digits behind the point, 0 to 15: "0.50"; a value that is rounded to zero has no
/// sign.
[[nodiscard]] std::string fixed_text(double value, int decimals);

}  // namespace pipescout::validation
