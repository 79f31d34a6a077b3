// SPDX-License-Identifier: Apache-2.0
#include "arm_cases.hpp"

#include <benchmark/benchmark.h>
#include <time.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "heap_guard.hpp"
#include "pipescout/manipulation/arm_controller.hpp"
#include "pipescout/simulation/pipe_view.hpp"
#include "pipescout/simulation/thermal_camera.hpp"
#include "samples.hpp"

namespace pipescout::benchmarks {
namespace {

using manipulation::ArmCommand;
using manipulation::ArmModel;
using manipulation::JointVector;

constexpr const char* kTracking = "arm: cycle while it tracks";
constexpr const char* kAtTheHull = "arm: cycle where it may hit the hull";
constexpr int kWarmUp = 200;   // cycles
constexpr int kCycles = 2000;  // that are measured
constexpr int kImageEvery = 4;

std::size_t& allocations() {
  static std::size_t count = 0;
  return count;
}

/// What this thread has used: other work on the machine makes nothing slower.
std::int64_t cpu_nanoseconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

ArmModel camera_arm() {
  return {manipulation::camera_arm_urdf(), "base_link", "camera_optical_frame"};
}

/// An arm that is where it was commanded to be, beside a level pipe.
class ArmLoop {
 public:
  /// `sinking`: m/s, of the pipe, after which the camera looks down until it stops at the hull.
  explicit ArmLoop(double sinking)
      : sinking_(sinking),
        arm_(camera_arm()),
        controller_(camera_arm(), {}),
        camera_(simulation::ThermalCameraParameters::qvga().camera),
        positions_(manipulation::ArmControllerParameters{}.ready) {
    controller_.set_camera(camera_);
    for (const manipulation::ArmJoint& joint : arm_.joints()) {
      names_.push_back(joint.name);
    }
  }

  /// ns that the controller takes for a cycle; counts what it allocates when `counts`.
  double cycle(int number, bool counts) {
    const double now = 0.01 * number;
    const double roll = 0.05 * std::sin(10 * now);
    const double roll_rate = 0.5 * std::cos(10 * now);
    const manipulation::VehicleMotion motion{
        .time = now,
        .R_map_base = geometry::SO3::about_x(roll).quaternion(),
        .velocity = {5.5, 0, 0},
        .angular_rate = {roll_rate, 0, 0}};
    const manipulation::PipeSection section = look(now, roll);

    const pipescout::test::HeapGuard guard;
    const std::int64_t start = cpu_nanoseconds();
    controller_.observe({.time = now, .names = names_, .positions = positions_}, now);
    controller_.observe(motion, now);
    if (number % kImageEvery == 0) {
      controller_.observe(section, now);
    }
    const ArmCommand command = controller_.step(now, manipulation::ArmRequest::kTrack);
    const auto took = static_cast<double>(cpu_nanoseconds() - start);
    allocations() += counts ? guard.allocations() : 0;
    if (command.commanded) {
      std::ranges::copy(command.position, positions_.begin());
    }
    return took;
  }

 private:
  manipulation::PipeSection look(double now, double roll) {
    const double height = std::max(-12.0, 2.5 - sinking_ * now);
    const simulation::StraightPipe pipe{
        .from = {-50, 10, height}, .to = {50, 10, height}, .radius = 0.06};
    const JointVector q = Eigen::Map<const Eigen::VectorXd>(positions_.data(), arm_.size());
    const geometry::SE3 T_map_base(geometry::SO3::about_x(roll), Eigen::Vector3d::Zero());
    const auto view = simulation::view_pipe(pipe, camera_, T_map_base * arm_.T_base_camera(q));
    manipulation::PipeSection section{
        .time = now, .width = camera_.parameters().width, .height = camera_.parameters().height};
    section.state = manipulation::TrackState::kCoasting;
    if (view) {
      const Eigen::Vector2d along = view->to - view->from;
      section.state = manipulation::TrackState::kLocked;
      section.u = (view->from.x() + view->to.x()) / 2;
      section.v = (view->from.y() + view->to.y()) / 2;
      section.length = along.norm();
      section.angle = std::atan2(along.y(), along.x());
      section.range = view->range;
    }
    return section;
  }

  double sinking_;
  ArmModel arm_;
  manipulation::ArmController controller_;
  geometry::Camera camera_;
  std::vector<std::string> names_;
  std::vector<double> positions_;
};

void add_case(const char* name, double sinking) {
  benchmark::RegisterBenchmark(name,
                               [=](benchmark::State& state) {
                                 Samples& samples = all_samples()[name];
                                 for (auto _ : state) {
                                   ArmLoop loop(sinking);
                                   double total = 0;
                                   for (int i = 0; i < kWarmUp + kCycles; ++i) {
                                     const double took = loop.cycle(i, i >= kWarmUp);
                                     if (i >= kWarmUp) {
                                       samples.add(took * 1e-3);
                                       total += took;
                                     }
                                   }
                                   state.SetIterationTime(total * 1e-9);
                                 }
                               })
      ->UseManualTime()
      ->Iterations(1)
      ->Repetitions(3)
      ->Unit(benchmark::kMillisecond);
}

}  // namespace

void register_arm_cases() {
  add_case(kTracking, 0);
  add_case(kAtTheHull, 1.5);
}

void add_arm_figures(Figures& figures) {
  using Bound = Figures::Bound;
  double median = 0;
  double slowest = 0;
  for (const char* name : {kTracking, kAtTheHull}) {
    const Samples& samples = all_samples()[name];
    median = std::max(median, samples.median());
    slowest = std::max(slowest, samples.quantile(0.99));
    figures.add_row({{"case", name},
                     {"median_us", samples.median()},
                     {"p99_us", samples.quantile(0.99)},
                     {"samples", samples.size()}});
  }
  figures.add("arm_cycle_us", median, Bound::kAtMost, 50.0);
  figures.add("arm_cycle_p99_us", slowest);
  figures.add("arm_allocations", static_cast<double>(allocations()), Bound::kAtMost, 0.0);
}

}  // namespace pipescout::benchmarks
