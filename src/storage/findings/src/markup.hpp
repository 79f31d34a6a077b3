// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "pipescout/thermal/leak_detector.hpp"

/// What goes into HTML, SVG and KML.
namespace pipescout {

/// As the content of an element or of an attribute in quotation marks. Bytes that are no UTF-8 and
/// control characters become U+FFFD.
[[nodiscard]] std::string escaped(std::string_view text);

/// "12.50"; "-" for what is not finite; never "-0".
[[nodiscard]] std::string fixed(double value, int decimals);

/// "data:image/png;base64,..."
[[nodiscard]] std::string png_uri(std::span<const std::uint8_t> png);

/// "#rrggbb"
[[nodiscard]] std::string severity_colour(thermal::Severity severity);

/// A round number, 1, 2 or 5 times a power of ten, that divides `span` into at most `most` steps.
/// `span` is positive and `most` at least 1.
[[nodiscard]] double round_step(double span, int most);

}  // namespace pipescout
