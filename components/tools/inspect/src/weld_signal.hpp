// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "pipescout/odometry/weld_detector.hpp"
#include "signal_columns.hpp"

/// The signal of an eddy-current probe along the distance, from files.
namespace pipescout::inspect {

/// Takes the samples of a signal in their order.
struct SignalSink {
  /// Called once, before the first sample: 1 to `kMaxEddyCurrentChannels`.
  std::function<void(std::size_t channels)> begin;
  /// Distance in m. Missing values are NaN.
  std::function<void(double distance, std::span<const odometry::Impedance> channels)> sample;
};

/// A CSV file. Throws CsvError, "file:line: column 'x': ...", for what is not a number; empty cells
/// and nan are missing values. Returns how the file was read, where that is a guess.
std::vector<std::string> read_signal_table(const std::string& path, const SignalColumns& columns,
                                           const SignalSink& sink);

/// What of a bag did not become samples of the signal.
struct BagRemainder {
  std::size_t passed_over = 0;  ///< samples before the first or after the last fused distance
  std::string damage;           ///< why the bag could not be read to its end; empty when it could
};

/// A bag with messages of the types pipescout_msgs/EddyCurrentSamples and
/// pipescout_msgs/FusedOdometer; of a damaged one, what stands before the damage. Topics: empty
/// where the bag has one of the type only. Throws CommandError and BagError naming the bag.
[[nodiscard]] BagRemainder read_signal_bag(const std::string& bag, const std::string& samples_topic,
                                           const std::string& odometer_topic,
                                           const SignalSink& sink);

}  // namespace pipescout::inspect
