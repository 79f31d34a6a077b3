// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation/state_estimator.hpp"

#include "estimator_implementation.hpp"

namespace pipescout::estimation {

StateEstimator::StateEstimator(const StateEstimatorParameters& parameters) {
  parameters.validate();
  implementation_ = std::make_unique<Implementation>(parameters);
}
StateEstimator::~StateEstimator() = default;
StateEstimator::StateEstimator(StateEstimator&&) noexcept = default;
StateEstimator& StateEstimator::operator=(StateEstimator&&) noexcept = default;

Outcome StateEstimator::add(const ImuReading& reading) noexcept {
  return implementation_->add(reading);
}
Outcome StateEstimator::add(const OdometerReading& reading) noexcept {
  return implementation_->add(reading);
}
Outcome StateEstimator::add(const WheelTurn& turn) noexcept {
  return implementation_->add(turn);
}
Outcome StateEstimator::add(const GpsMeasurement& m) noexcept {
  return implementation_->add_measurement(m);
}
Outcome StateEstimator::add(const HeadingMeasurement& m) noexcept {
  return implementation_->add_measurement(m);
}
Outcome StateEstimator::add(const VisualPoseMeasurement& m) noexcept {
  return implementation_->add_measurement(m);
}
Outcome StateEstimator::add(const WeldMeasurement& m) noexcept {
  return implementation_->add_measurement(m);
}
Outcome StateEstimator::add(const RelativePoseMeasurement& m) noexcept {
  return implementation_->add_measurement(m);
}
Outcome StateEstimator::add(const AnyFactor& factor) noexcept {
  return implementation_->add(factor);
}
Outcome StateEstimator::add(const GivenPose& pose) noexcept {
  return implementation_->add(pose);
}
void StateEstimator::restart() noexcept {
  implementation_->restart();
}
void StateEstimator::set_earth(const Earth& earth) {
  implementation_->set_earth(earth);
}
std::optional<Estimate> StateEstimator::estimate() const noexcept {
  return implementation_->estimate();
}
StateMatrix StateEstimator::covariance() const noexcept {
  return implementation_->covariance();
}
std::uint64_t StateEstimator::updates() const noexcept {
  return implementation_->updates();
}
const UpdateReport& StateEstimator::last_update() const noexcept {
  return implementation_->last_update();
}
const FixedLagSmoother& StateEstimator::smoother() const noexcept {
  return implementation_->smoother();
}
EstimatorStatus StateEstimator::status() const {
  return implementation_->status();
}
CorrelationFinding StateEstimator::correlation_of(Source source) const noexcept {
  return implementation_->correlation_of(source);
}

}  // namespace pipescout::estimation
