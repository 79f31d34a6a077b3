// SPDX-License-Identifier: Apache-2.0
#include "camera_helpers.hpp"

namespace pipescout::thermal::test {

CameraConstants sc660(AirPath path) {
  return {.planck = {.r1 = 21106.76953125, .r2 = 0.012545257806778, .b = 1501, .f = 1, .o = -7340},
          .path = path};
}

}  // namespace pipescout::thermal::test
