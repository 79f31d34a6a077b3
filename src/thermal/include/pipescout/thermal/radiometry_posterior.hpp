// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "pipescout/thermal/radiometry.hpp"
#include "pipescout/thermal/temperature_interval.hpp"

namespace pipescout::thermal {

/// Temperatures, degC, that the sound pipe may have. It falls off outside over some 10 K.
struct PipeTemperatureRange {
  double least = -60;  ///< above absolute zero
  double most = 600;   ///< above `least`, below 2000
  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

/// 100 to 400 degC: absorber tubes of parabolic troughs with oil.
[[nodiscard]] PipeTemperatureRange collector_temperatures() noexcept;

/// What is known of emissivity, reflected temperature, air, window and calibration, all of which
/// are told with a standard deviation, after the sound pipe has been in view of many images.
///
/// The priors: emissivity log-normal about the told one and not above 1; all others normal, within
/// the range of their field. The posterior is a fixed number of draws from the priors with weights
/// (importance sampling; Robert and Casella, Monte Carlo Statistical Methods, 2nd ed. 2004, section
/// 3.3): a draw counts as far as it gives the pipe a temperature that a pipe may have. The same
/// calls give the same bits. Emissivity and reflected temperature can be exchanged for each other
/// in images of one pipe, so that the interval of a temperature is as wide as the priors leave it:
/// the draws keep the exchange, which a first-order propagation loses.
class RadiometryPosterior {
 public:
  /// Throws std::invalid_argument as Radiometry, ParameterDeviations and PipeTemperatureRange.
  RadiometryPosterior(const CameraConstants& camera, const ObjectParameters& told,
                      const ParameterDeviations& deviations, const PipeTemperatureRange& pipe);

  /// The sound pipe in one image: its apparent temperature, degC, that of a black body with the
  /// same counts. Not finite: ignored.
  void observe(double apparent);

  /// Of an object with this apparent temperature, degC; deviation, low and high are those of the
  /// posterior: 95 % between its quantiles, which need not be symmetric. NaN where no draw gives a
  /// temperature.
  [[nodiscard]] TemperatureInterval temperature(double apparent) const;
  /// Of the difference of two, K. Common errors cancel as far as they do.
  [[nodiscard]] TemperatureInterval difference(double apparent, double base) const;
  /// Of the sound pipe, over all images.
  [[nodiscard]] TemperatureInterval pipe_temperature() const;
  /// Posterior of two of the parameters. As `temperature`.
  [[nodiscard]] TemperatureInterval emissivity() const;
  [[nodiscard]] TemperatureInterval reflected_temperature() const;

  [[nodiscard]] std::size_t images() const noexcept { return images_; }
  /// Whether what is told, within its deviations, gives the pipe no temperature that it may have;
  /// the posterior is then the prior.
  [[nodiscard]] bool contradicted() const noexcept { return contradicted_; }

 private:
  struct Draw {
    Radiometry radiometry;
    double offset = 0;  // counts, of the calibration
    double weight = 1;
  };
  [[nodiscard]] double counts(double apparent) const noexcept;
  void weigh();
  template <class Value>
  [[nodiscard]] TemperatureInterval interval(const Value& value) const;

  PlanckConstants planck_;
  PipeTemperatureRange pipe_;
  std::vector<Draw> draws_;
  double mean_ = 0;  // counts, of the sound pipe
  std::size_t images_ = 0;
  bool contradicted_ = false;
};

}  // namespace pipescout::thermal
