// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "pipescout/thermal/radiometry.hpp"

namespace pipescout::thermal {

/// An invalid or implausible parameter with the reason.
struct Doubt {
  std::string field;
  double value = 0;
  std::string reason;
  /// No temperature can be computed with it.
  bool fatal = false;
};

/// "relative_humidity 50: outside [0, 1]: a percentage?"
[[nodiscard]] std::string to_string(const Doubt& doubt);

/// Checks the parameters of a file or of an operator. Those that `validate` refuses are fatal.
/// Implausible are:
///   - an emissivity below 0.8: reflections make more than a fifth of the signal;
///   - a distance of 0, or above 1 km;
///   - a reflected temperature outside [-80, 300] degC, an air outside [-40, 60] degC;
///   - a window with a transmission below one half;
///   - air with a transmission below one half;
///   - Planck constants with which a black body of 20 degC gives no counts within 16 bits, or a
///     kelvin more not one of them more, or with b outside [1200, 1700] K, f outside [0.5, 2];
///   - an emissivity of 0.95, 1 m, 20 degC all over and a humidity of 0.5, all at once: unchanged
///   factory defaults.
/// The emissivity of `ibarguren2013_object` is reported as implausible, which is intended.
[[nodiscard]] std::vector<Doubt> doubts(const CameraConstants& camera,
                                        const ObjectParameters& object);

}  // namespace pipescout::thermal
