// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pipescout/thermal/radiometry.hpp"

namespace pipescout::thermal::test {

/// Constants of the FLIR SC660 that took a picture whose temperatures FLIR's own software exported.
[[nodiscard]] CameraConstants sc660(AirPath path = AirPath::kBeforeWindow);

}  // namespace pipescout::thermal::test
