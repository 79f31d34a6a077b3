// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "pipescout/tracking/trackable_shape.hpp"

/// The shapes of pipes, valves and vessels. x to the right, y down, from the middle of the upper
/// left pixel; angles from x towards y.
namespace pipescout::tracking {

/// A detected straight section of a pipe: its axis between two ends.
struct PipeRegion {
  Eigen::Vector2d start = Eigen::Vector2d::Zero();
  Eigen::Vector2d end = Eigen::Vector2d::Zero();
  double half_width = 0;   ///< px, >= 0: from the axis to the edge
  bool cut_along = false;  ///< the border cuts it lengthwise: the axis is that of the visible part
};

/// A straight section of a pipe: x, y of its middle, length, direction of its axis. Equation (14):
/// lambda |position| + beta dl^2 + gamma dalpha^2.
///
/// A region gives four readings: the distance of its middle from the predicted axis, its direction,
/// and the position of each end along the axis. An end at the border of the image is a lower bound:
/// it is a reading only if the prediction ends before it. An end within the image may be caused by
/// a post in front of the pipe.
struct PipeShape {
  using Region = PipeRegion;
  using State = Eigen::Matrix<double, 4, 1>;
  using Covariance = Eigen::Matrix<double, 4, 4>;
  static constexpr std::size_t kSize = 4;
  static constexpr std::array<double, kSize> kPeriods{0, 0, 0, std::numbers::pi};
  enum : std::size_t { kX, kY, kLength, kAngle };

  static constexpr std::array<double, kSize> kStartDeviation{3, 3, 5, 0.03};
  static constexpr std::array<double, kSize> kProcessDeviation{6, 6, 10, 0.02};
  static constexpr std::array<double, kSize> kRateWalk{800, 800, 40, 3};

  double lambda = 1;    ///< 1/px, > 0
  double beta = 0.1;    ///< 1/px^2, > 0
  double gamma = 6000;  ///< 1/rad^2, > 0

  double edge_deviation = 0.5;  ///< px, > 0: of the outline, common to half of the pipe's length
  double end_deviation = 1.5;   ///< px, > 0: of an end along the axis
  double border = 2.0;          ///< px, >= 0: an end this close to the border is cut by it
  /// Share of the image's longer side, [0, 0.5]: smallest detectable piece of a pipe. An end this
  /// close to the border is that of the pipe only if it was predicted there: the pipe may continue
  /// behind a post.
  double least_piece = 0.06;

  /// In (-pi/2, pi/2], as all angles of sections.
  [[nodiscard]] static State state_of(const PipeRegion& region);
  [[nodiscard]] static double size_of(const PipeRegion& region);
  /// Behind a post the pipe goes on up to the border, where it did before. Another end may be
  /// clutter's: the likelier one's is taken.
  [[nodiscard]] PipeRegion joined(const PipeRegion& likelier, const PipeRegion& other,
                                  const ImageSize& image, const Ends& censored) const;
  void observe(const PipeRegion& region, const State& predicted, const Covariance& covariance,
               const ImageSize& image, ObservationRows<kSize>& rows) const;
  /// An unobserved end stays beyond the border for any motion of the image.
  void keep_open(const State& predicted, const Covariance& covariance, const ImageSize& image,
                 ObservationRows<kSize>& rows) const;
  [[nodiscard]] static ShapeInView<kSize> in_view(const State& state, const ImageSize& image);
  [[nodiscard]] static State moved_by(const State& state, const ImageMotion& motion);
  [[nodiscard]] static State scaled(const State& state, double factor);

  template <class T>
  [[nodiscard]] T distance(const std::array<T, kSize>& d) const {
    return static_cast<T>(lambda) * std::sqrt(d[kX] * d[kX] + d[kY] * d[kY]) +
           static_cast<T>(beta) * d[kLength] * d[kLength] +
           static_cast<T>(gamma) * d[kAngle] * d[kAngle];
  }
  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

/// A valve seen as a circle: x, y of its middle, radius.
struct ValveShape {
  using State = Eigen::Matrix<double, 3, 1>;
  using Covariance = Eigen::Matrix<double, 3, 3>;
  using Region = State;  ///< all its numbers
  static constexpr std::size_t kSize = 3;
  static constexpr std::array<double, kSize> kPeriods{0, 0, 0};
  enum : std::size_t { kX, kY, kRadius };

  static constexpr std::array<double, kSize> kStartDeviation{3, 3, 2};
  static constexpr std::array<double, kSize> kProcessDeviation{10, 10, 5};
  static constexpr std::array<double, kSize> kRateWalk{800, 800, 100};

  double lambda = 0.5;  ///< 1/px, > 0
  double beta = 0.2;    ///< 1/px^2, > 0

  double edge_deviation = 1.0;  ///< px, > 0: of the outline

  [[nodiscard]] static State state_of(const Region& region);
  [[nodiscard]] static double size_of(const Region& region);
  /// The likelier one: an outline has no parts.
  [[nodiscard]] Region joined(const Region& likelier, const Region& /*other*/,
                              const ImageSize& /*image*/, const Ends& /*censored*/) const {
    return likelier;
  }
  void observe(const Region& region, const State& predicted, const Covariance& covariance,
               const ImageSize& image, ObservationRows<kSize>& rows) const;
  /// No bounds.
  void keep_open(const State& /*predicted*/, const Covariance& /*covariance*/,
                 const ImageSize& /*image*/, ObservationRows<kSize>& rows) const {
    rows.clear();
  }
  [[nodiscard]] static ShapeInView<kSize> in_view(const State& state, const ImageSize& image);
  [[nodiscard]] static State moved_by(const State& state, const ImageMotion& motion);
  [[nodiscard]] static State scaled(const State& state, double factor);

  template <class T>
  [[nodiscard]] T distance(const std::array<T, kSize>& d) const {
    return static_cast<T>(lambda) * std::sqrt(d[kX] * d[kX] + d[kY] * d[kY]) +
           static_cast<T>(beta) * d[kRadius] * d[kRadius];
  }
  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

/// A vessel seen as a rectangle: x, y of its middle, length along its axis, width, direction of the
/// axis.
struct VesselShape {
  using State = Eigen::Matrix<double, 5, 1>;
  using Covariance = Eigen::Matrix<double, 5, 5>;
  using Region = State;  ///< all its numbers
  static constexpr std::size_t kSize = 5;
  static constexpr std::array<double, kSize> kPeriods{0, 0, 0, 0, std::numbers::pi};
  enum : std::size_t { kX, kY, kLength, kWidth, kAngle };

  static constexpr std::array<double, kSize> kStartDeviation{3, 3, 4, 4, 0.03};
  static constexpr std::array<double, kSize> kProcessDeviation{10, 10, 10, 10, 0.05};
  static constexpr std::array<double, kSize> kRateWalk{800, 800, 200, 200, 3};

  double lambda = 0.5;  ///< 1/px, > 0
  double beta = 0.02;   ///< 1/px^2, > 0: of length and width
  double gamma = 600;   ///< 1/rad^2, > 0

  double edge_deviation = 1.0;  ///< px, > 0: of the outline

  [[nodiscard]] static State state_of(const Region& region);
  [[nodiscard]] static double size_of(const Region& region);
  /// The likelier one: an outline has no parts.
  [[nodiscard]] Region joined(const Region& likelier, const Region& /*other*/,
                              const ImageSize& /*image*/, const Ends& /*censored*/) const {
    return likelier;
  }
  void observe(const Region& region, const State& predicted, const Covariance& covariance,
               const ImageSize& image, ObservationRows<kSize>& rows) const;
  /// No bounds.
  void keep_open(const State& /*predicted*/, const Covariance& /*covariance*/,
                 const ImageSize& /*image*/, ObservationRows<kSize>& rows) const {
    rows.clear();
  }
  [[nodiscard]] static ShapeInView<kSize> in_view(const State& state, const ImageSize& image);
  [[nodiscard]] static State moved_by(const State& state, const ImageMotion& motion);
  [[nodiscard]] static State scaled(const State& state, double factor);

  template <class T>
  [[nodiscard]] T distance(const std::array<T, kSize>& d) const {
    return static_cast<T>(lambda) * std::sqrt(d[kX] * d[kX] + d[kY] * d[kY]) +
           static_cast<T>(beta) * (d[kLength] * d[kLength] + d[kWidth] * d[kWidth]) +
           static_cast<T>(gamma) * d[kAngle] * d[kAngle];
  }
  /// Throws std::invalid_argument naming the field, the value and the range.
  void validate() const;
};

}  // namespace pipescout::tracking
