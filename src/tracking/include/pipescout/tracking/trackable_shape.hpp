// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <concepts>
#include <cstddef>
#include <span>

#include "pipescout/tracking/image_motion.hpp"
#include "pipescout/tracking/shape_model.hpp"

namespace pipescout::tracking {

struct ImageSize {
  int width = 0;   ///< px
  int height = 0;  ///< px
  friend bool operator==(const ImageSize&, const ImageSize&) = default;
};

template <ShapeModel Model>
using ShapeCovariance =
    Eigen::Matrix<double, static_cast<int>(Model::kSize), static_cast<int>(Model::kSize)>;

// The following are templates over the size of a shape, because shapes use them in their own
// definition.

/// One reading of a region, as a function of the shape to first order.
template <std::size_t kSize>
struct ObservationRow {
  using Gradient = Eigen::Matrix<double, static_cast<int>(kSize), 1>;
  Gradient gradient = Gradient::Zero();  ///< derivative of the reading with respect to the shape
  double residual = 0;                   ///< measured minus predicted
  double variance = 0;                   ///< of the reading
  double span = 1;                       ///< range over which readings of clutter are uniform
  /// May be caused by another object although the region is of the shape, such as an end of a pipe
  /// at a post.
  bool doubtful = false;
  /// A bound by the border of the image, without information on the association of the region.
  bool bound = false;
  /// Inflation of the shape's covariance before the update, one standard deviation.
  Gradient slack = Gradient::Zero();
};

template <std::size_t kSize>
class ObservationRows {
 public:
  void clear() noexcept { count_ = 0; }
  /// Throws std::out_of_range beyond `kSize` rows.
  void add(const ObservationRow<kSize>& row) { rows_.at(count_++) = row; }
  [[nodiscard]] std::span<const ObservationRow<kSize>> all() const noexcept {
    return {rows_.data(), count_};
  }

 private:
  std::array<ObservationRow<kSize>, kSize> rows_{};
  std::size_t count_ = 0;
};

/// The visible part of a shape.
template <std::size_t kSize>
struct ShapeInView {
  using State = Eigen::Matrix<double, static_cast<int>(kSize), 1>;
  State shape = State::Zero();
  bool in_view = false;  ///< otherwise `shape` is the whole shape, outside the image
  /// it continues beyond the border; for a pipe at the end opposite to its direction (cos alpha,
  /// sin alpha): the left one, of an upright pipe the upper one
  bool start_censored = false;
  bool end_censored = false;  ///< the same at the other end
};

/// Ends, as of `ShapeInView`.
struct Ends {
  bool start = false;
  bool end = false;
};

/// A shape for `ShapeTracker`: in addition to the members for the particle filter,
///
///   Region      as it is found in a picture
///   state_of    the numbers of a region, as they are seen: what particles are compared with
///   size_of     px: of several regions the largest is taken up first; 0: it makes no sense
///   joined      of two regions that are parts of one shape, likelier one first: the region of
///   both,
///               of a shape with these ends beyond the border not long ago
///   observe     the readings of a region, beside the prediction and its covariance
///   keep_open   the readings of a picture in which the shape is not found: bounds only
///   in_view     the part of a shape that is in the picture
///   moved_by    rates of the numbers, 1/s, when the picture moves
///   scaled      the shape in the picture scaled by a factor
///   kStartDeviation, kProcessDeviation  of particles; as in ParticleFilterParameters
///   kRateWalk   by how much rates change, per square root of a second, without camera motion
template <class Model>
concept TrackableShape = ShapeModel<Model> &&
    requires(const Model& model, const typename Model::Region& region,
             const ShapeState<Model>& state, const ShapeCovariance<Model>& covariance,
             const ImageSize& image, const ImageMotion& motion,
             ObservationRows<Model::kSize>& rows) {
  { Model::state_of(region) } -> std::same_as<ShapeState<Model>>;
  { Model::size_of(region) } -> std::same_as<double>;
  { model.joined(region, region, image, Ends{}) } -> std::same_as<typename Model::Region>;
  { model.observe(region, state, covariance, image, rows) } -> std::same_as<void>;
  { model.keep_open(state, covariance, image, rows) } -> std::same_as<void>;
  { Model::in_view(state, image) } -> std::same_as<ShapeInView<Model::kSize>>;
  { Model::moved_by(state, motion) } -> std::same_as<ShapeState<Model>>;
  { Model::scaled(state, 1.0) } -> std::same_as<ShapeState<Model>>;
  { Model::kStartDeviation[0] } -> std::convertible_to<double>;
  { Model::kProcessDeviation[0] } -> std::convertible_to<double>;
  { Model::kRateWalk[0] } -> std::convertible_to<double>;
};

}  // namespace pipescout::tracking
