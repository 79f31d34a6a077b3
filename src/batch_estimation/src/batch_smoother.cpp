// SPDX-License-Identifier: Apache-2.0
#include "pipescout/batch_estimation/batch_smoother.hpp"

#include <ceres/covariance.h>
#include <ceres/problem.h>
#include <ceres/solver.h>

#include <algorithm>
#include <cmath>
#include <type_traits>
#include <utility>

#include "cost_functions.hpp"
#include "manifolds.hpp"
#include "recording_factors.hpp"

namespace pipescout::estimation {
namespace {

class Watch final : public ceres::IterationCallback {
 public:
  Watch(const BatchProgressCallback& progress, int reintegrations)
      : progress_(progress), reintegrations_(reintegrations) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary& summary) override {
    if (progress_ && !progress_({.reintegrations = reintegrations_,
                                 .iteration = summary.iteration,
                                 .cost = summary.cost})) {
      stopped_ = true;
      return ceres::SOLVER_TERMINATE_SUCCESSFULLY;
    }
    return ceres::SOLVER_CONTINUE;
  }
  [[nodiscard]] bool stopped() const { return stopped_; }

 private:
  const BatchProgressCallback& progress_;
  int reintegrations_;
  bool stopped_ = false;
};

ceres::Solver::Options solver_options(const BatchSmootherParameters& parameters) {
  ceres::Solver::Options options;
  options.linear_solver_type = parameters.linear_solver == LinearSolver::kSparseSchur
                                   ? ceres::SPARSE_SCHUR
                                   : ceres::SPARSE_NORMAL_CHOLESKY;
  options.sparse_linear_algebra_library_type = ceres::SUITE_SPARSE;
  options.num_threads = 1;
  options.max_num_iterations = parameters.max_iterations;
  options.function_tolerance = parameters.tolerance;
  // The cost alone says when it is enough: gradients and steps have many units.
  options.gradient_tolerance = 0;
  options.parameter_tolerance = 0;
  options.logging_type = ceres::SILENT;
  return options;
}

}  // namespace

class BatchSmoother::Implementation {
 public:
  Implementation(const BatchSmootherParameters& parameters, Recording recording);

  const BatchReport& solve(const BatchProgressCallback& progress);
  [[nodiscard]] const std::vector<NavState>& states() const { return states_; }
  [[nodiscard]] const GlobalStates& globals() const { return globals_; }
  [[nodiscard]] std::vector<StateMatrix> covariances(std::span<const std::size_t> keyframes);
  [[nodiscard]] Eigen::Matrix<double, kGlobalSize, kGlobalSize> global_covariance();

 private:
  /// IMU factors and all motions, with the biases and the scale of the estimate; then the problem
  /// made of them.
  void integrate();
  void build();
  void add_measurement(const PlacedMeasurement& measurement);
  [[nodiscard]] ImuPreintegration motion(std::size_t keyframe, double until);
  [[nodiscard]] ceres::LossFunction* loss(FactorKind kind);
  [[nodiscard]] bool calibration_has_moved() const;
  void take_estimate();
  void report_factors();

  [[nodiscard]] Gravity gravity() const { return {parameters_.gravity, parameters_.earth}; }

  BatchSmootherParameters parameters_;
  Recording recording_;
  BatchReport report_{};
  ImuTimeline imu_;
  ImuIntegration how_;
  std::vector<PlacedMeasurement> measurements_{};
  std::vector<int> estimated_{};  // globals
  bool imu_scaled_ = false;       // the scale of the IMU is estimated, or known not to be one
  std::vector<NavState> states_{};
  GlobalStates globals_;
  std::vector<ImuScale> imu_scales_{};  // with which the IMU is integrated from each keyframe on
  std::vector<ImuFactor> links_{};

  StateManifold state_manifold_{};
  GlobalManifold global_manifold_;
  std::vector<std::unique_ptr<KernelLoss>> losses_{};
  std::vector<StateBlock> state_blocks_{};
  GlobalBlock global_block_{};
  // After the blocks that it points to, so that it goes first.
  std::unique_ptr<ceres::Problem> problem_{};
};

namespace {

std::vector<int> estimated_places(const GlobalDeviations& known) {
  const GlobalVector deviations = known.tangent();
  std::vector<int> places;
  for (int i = 0; i < kGlobalSize; ++i) {
    if (deviations[i] > 0) {
      places.push_back(i);
    }
  }
  return places;
}

}  // namespace

BatchSmoother::Implementation::Implementation(const BatchSmootherParameters& parameters,
                                              Recording recording)
    : parameters_(parameters),
      recording_(std::move(recording)),
      imu_(timeline_of(recording_.imu, report_.refused_imu)),
      how_{.noise = parameters.imu_noise,
           .coasting = parameters.imu_noise,
           .max_held = parameters.max_held_imu,
           .gravity = parameters.gravity,
           .map_rate = parameters.earth.rate},
      estimated_(estimated_places(parameters.global_deviations)),
      globals_(parameters.globals),
      global_manifold_(estimated_) {
  imu_scaled_ = std::ranges::any_of(estimated_, [](int place) { return place >= kImuScale; }) ||
                ImuScale{}.local(globals_.imu_scale).any();
  how_.coasting.gyro = parameters.coasting_angular_rate;
  how_.coasting_turn = parameters.coasting_turn;
  how_.coasting.accelerometer = parameters.coasting_acceleration;
  static_cast<void>(PriorFactor(recording_.first, recording_.first_covariance));
  for (const AnyFactor& factor : recording_.measurements) {
    measurements_.push_back(placed(factor, recording_.times));
  }
  for (const Robustness& one : parameters.robustness) {
    losses_.push_back(one.kernel == statistics::RobustKernel::kNone
                          ? nullptr
                          : std::make_unique<KernelLoss>(one.kernel, one.width));
  }
  imu_scales_ = recording_.imu_scale_guesses;
  if (imu_scales_.empty()) {
    imu_scales_.assign(recording_.times.size(), globals_.imu_scale);
  }
  states_ = recording_.guesses;
  if (states_.empty()) {
    states_.push_back(recording_.first);
    for (std::size_t k = 0; k + 1 < recording_.times.size(); ++k) {
      const ImuPreintegration to_next = motion(k, recording_.times[k + 1]);
      states_.push_back(to_next.motion().propagate(states_[k], gravity()));
    }
  }
  state_blocks_.resize(states_.size());
  integrate();
  build();
}

ImuPreintegration BatchSmoother::Implementation::motion(std::size_t keyframe, double until) {
  const NavState& from = states_[keyframe];
  ImuPreintegration sum(
      imu_scaled_ ? ImuMotion(from.gyro_bias, from.accelerometer_bias, imu_scales_[keyframe])
                  : ImuMotion(from.gyro_bias, from.accelerometer_bias));
  const double begin = recording_.times[keyframe];
  if (until > begin + kSameTime) {
    report_.coasted += imu_.integrate(how_, from.R_map_body, begin, until, sum);
  }
  return sum;
}

void BatchSmoother::Implementation::integrate() {
  for (PlacedMeasurement& m : measurements_) {
    if (m.factor) {
      m.motions.from = motion(m.from, m.from_time).motion();
      m.motions.to = motion(m.to, m.to_time).motion();
    }
  }
  links_.clear();
  report_.coasted = 0;
  for (std::size_t k = 0; k + 1 < states_.size(); ++k) {
    links_.emplace_back(motion(k, recording_.times[k + 1]), gravity());
  }
}

ceres::LossFunction* BatchSmoother::Implementation::loss(FactorKind kind) {
  return losses_[static_cast<std::size_t>(kind)].get();
}

void BatchSmoother::Implementation::add_measurement(const PlacedMeasurement& m) {
  const AnyFactor& factor = *m.factor;
  const FactorCost::Ties ties{
      .two_keyframes = factor.is_of_two_times() && m.from != m.to,
      .globals = (factor.uses_globals() || imu_scaled_) && !estimated_.empty()};
  std::vector<double*> blocks = {state_blocks_[m.from].data()};
  if (ties.two_keyframes) {
    blocks.push_back(state_blocks_[m.to].data());
  }
  if (ties.globals) {
    blocks.push_back(global_block_.data());
  }
  problem_->AddResidualBlock(
      new FactorCost(factor, m.motions, gravity(), parameters_.globals, ties), loss(factor.kind()),
      blocks);
}

void BatchSmoother::Implementation::build() {
  ceres::Problem::Options options;
  options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  problem_ = std::make_unique<ceres::Problem>(options);
  for (std::size_t k = 0; k < states_.size(); ++k) {
    pack(states_[k], state_blocks_[k].data());
    problem_->AddParameterBlock(state_blocks_[k].data(), kStateNumbers, &state_manifold_);
  }
  pack(globals_, global_block_.data());
  problem_->AddResidualBlock(
      new PriorCost(PriorFactor(recording_.first, recording_.first_covariance)), nullptr,
      state_blocks_[0].data());
  if (!estimated_.empty()) {
    problem_->AddParameterBlock(global_block_.data(), kGlobalNumbers, &global_manifold_);
    problem_->AddResidualBlock(
        new GlobalPriorCost(parameters_.globals, parameters_.global_deviations.tangent(),
                            estimated_),
        nullptr, global_block_.data());
  }
  for (std::size_t k = 0; k < links_.size(); ++k) {
    std::vector<double*> blocks = {state_blocks_[k].data(), state_blocks_[k + 1].data()};
    const bool estimated = !estimated_.empty();
    if (estimated && imu_scaled_) {
      blocks.push_back(global_block_.data());
    }
    problem_->AddResidualBlock(new ImuCost(links_[k], parameters_.globals, estimated), nullptr,
                               blocks);
  }
  for (const PlacedMeasurement& m : measurements_) {
    if (m.factor) {
      add_measurement(m);
    }
  }
}

bool BatchSmoother::Implementation::calibration_has_moved() const {
  constexpr double kGyro = 1e-4;           // rad/s
  constexpr double kAccelerometer = 1e-3;  // m/s^2
  constexpr double kScale = 1e-4;
  for (std::size_t k = 0; k < links_.size(); ++k) {
    const ImuMotion& integrated = links_[k].motion();
    if ((states_[k].gyro_bias - integrated.gyro_bias()).norm() > kGyro ||
        (states_[k].accelerometer_bias - integrated.accelerometer_bias()).norm() > kAccelerometer ||
        (imu_scaled_ && integrated.scale().local(globals_.imu_scale).norm() > kScale)) {
      return true;
    }
  }
  return false;
}

void BatchSmoother::Implementation::take_estimate() {
  for (std::size_t k = 0; k < states_.size(); ++k) {
    states_[k] = unpack_state(state_blocks_[k].data());
  }
  globals_ = unpack_globals(global_block_.data());
}

const BatchReport& BatchSmoother::Implementation::solve(const BatchProgressCallback& progress) {
  report_.iterations = 0;
  report_.reintegrations = 0;
  ceres::Solver::Options options = solver_options(parameters_);
  while (true) {
    Watch watch(progress, report_.reintegrations);
    options.callbacks = {&watch};
    ceres::Solver::Summary summary;
    ceres::Solve(options, problem_.get(), &summary);
    take_estimate();
    if (report_.reintegrations == 0) {
      report_.first_cost = summary.initial_cost;
    }
    report_.cost = summary.final_cost;
    report_.iterations += static_cast<int>(summary.iterations.size()) - 1;
    report_.converged = summary.termination_type == ceres::CONVERGENCE;
    report_.message = summary.message;
    if (watch.stopped() || !summary.IsSolutionUsable() ||
        report_.reintegrations == parameters_.max_reintegrations || !calibration_has_moved()) {
      break;
    }
    imu_scales_.assign(states_.size(), globals_.imu_scale);
    integrate();
    build();
    ++report_.reintegrations;
  }
  report_factors();
  return report_;
}

void BatchSmoother::Implementation::report_factors() {
  report_.factors.clear();
  for (const PlacedMeasurement& m : measurements_) {
    FactorReport one = m.report;
    if (m.factor) {
      one.chi_square =
          chi_square(*m.factor, m.motions, states_[m.from], states_[m.to], globals_, gravity());
      const Robustness& robustness = parameters_.robustness[static_cast<std::size_t>(one.kind)];
      one.weight =
          std::isfinite(one.chi_square)
              ? evaluate(robustness.kernel, std::sqrt(one.chi_square), robustness.width).weight
              : 0;
    }
    report_.factors.push_back(one);
  }
  for (std::size_t k = 0; k < links_.size(); ++k) {
    report_.factors.push_back(
        {.kind = FactorKind::kImu,
         .time = recording_.times[k + 1],
         .chi_square = links_[k].evaluate(states_[k], states_[k + 1], globals_).squaredNorm(),
         .degrees = ImuFactor::kRows});
  }
}

namespace {

ceres::Covariance::Options covariance_options() {
  ceres::Covariance::Options options;
  options.algorithm_type = ceres::SPARSE_QR;
  options.sparse_linear_algebra_library_type = ceres::SUITE_SPARSE;
  options.num_threads = 1;
  return options;
}

}  // namespace

std::vector<StateMatrix> BatchSmoother::Implementation::covariances(
    std::span<const std::size_t> keyframes) {
  std::vector<std::pair<const double*, const double*>> blocks;
  for (const std::size_t k : keyframes) {
    blocks.emplace_back(state_blocks_[k].data(), state_blocks_[k].data());
  }
  // Ceres wants each block once.
  std::sort(blocks.begin(), blocks.end());
  blocks.erase(std::unique(blocks.begin(), blocks.end()), blocks.end());
  ceres::Covariance covariance(covariance_options());
  std::vector<StateMatrix> all;
  if (blocks.empty() || !covariance.Compute(blocks, problem_.get())) {
    return all;
  }
  for (const std::size_t k : keyframes) {
    const double* const block = state_blocks_[k].data();
    StateMatrix& one = all.emplace_back();  // symmetric: rows may be columns
    covariance.GetCovarianceBlockInTangentSpace(block, block, one.data());
  }
  return all;
}

Eigen::Matrix<double, kGlobalSize, kGlobalSize> BatchSmoother::Implementation::global_covariance() {
  Eigen::Matrix<double, kGlobalSize, kGlobalSize> all;
  all.setZero();
  ceres::Covariance covariance(covariance_options());
  const std::vector<std::pair<const double*, const double*>> blocks = {
      {global_block_.data(), global_block_.data()}};
  if (estimated_.empty() || !covariance.Compute(blocks, problem_.get())) {
    return all;
  }
  const auto size = static_cast<Eigen::Index>(estimated_.size());
  Eigen::MatrixXd part(size, size);
  covariance.GetCovarianceBlockInTangentSpace(global_block_.data(), global_block_.data(),
                                              part.data());
  for (Eigen::Index i = 0; i < size; ++i) {
    for (Eigen::Index j = 0; j < size; ++j) {
      all(estimated_[static_cast<std::size_t>(i)], estimated_[static_cast<std::size_t>(j)]) =
          part(i, j);
    }
  }
  return all;
}

BatchSmoother::BatchSmoother(const BatchSmootherParameters& parameters, Recording recording) {
  parameters.validate();
  require_sound(recording);
  implementation_ = std::make_unique<Implementation>(parameters, std::move(recording));
}
BatchSmoother::~BatchSmoother() = default;
BatchSmoother::BatchSmoother(BatchSmoother&&) noexcept = default;
BatchSmoother& BatchSmoother::operator=(BatchSmoother&&) noexcept = default;

const BatchReport& BatchSmoother::solve(const BatchProgressCallback& progress) {
  return implementation_->solve(progress);
}
const std::vector<NavState>& BatchSmoother::states() const noexcept {
  return implementation_->states();
}
const GlobalStates& BatchSmoother::globals() const noexcept {
  return implementation_->globals();
}
std::vector<StateMatrix> BatchSmoother::covariances(std::span<const std::size_t> keyframes) const {
  return implementation_->covariances(keyframes);
}
Eigen::Matrix<double, kGlobalSize, kGlobalSize> BatchSmoother::global_covariance() const {
  return implementation_->global_covariance();
}

}  // namespace pipescout::estimation
