// SPDX-License-Identifier: Apache-2.0
#include "pipescout/simulation/crawler.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>
#include <utility>

#include "pipescout/statistics/draw.hpp"
#include "pipescout/validation/check.hpp"

namespace pipescout::simulation {
namespace {

using statistics::exponential;
using statistics::make_engine;
using statistics::normal;
using statistics::uniform;
using validation::check_above;
using validation::check_within;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::uint64_t kFaultDraws = 5;
constexpr std::uint64_t kNoiseDraws = 100;    // + wheel
constexpr std::uint64_t kChannelDraws = 200;  // + wheel
constexpr double kCountTolerance = 1e-9;      // of a count, for what rounding leaves

void check_wheel(const std::string& prefix, const WheelParameters& wheel) {
  check_above(prefix + "period", wheel.period, 0.0, kInfinity);
  check_within(prefix + "start", wheel.start, 0.0, kInfinity);
  check_above(prefix + "resolution", wheel.resolution, 0.0, kInfinity);
  check_within(prefix + "counter_start", wheel.counter_start, -kInfinity, kInfinity);
  check_within(prefix + "scale_error", wheel.scale_error, -0.3, 0.3);
  check_within(prefix + "wear_per_metre", wheel.wear_per_metre, -1e-3, 1e-3);
  check_within(prefix + "noise_per_sqrt_metre", wheel.noise_per_sqrt_metre, 0.0, kInfinity);
  check_within(prefix + "gravity_slip", wheel.gravity_slip, 0.0, 0.5);
  check_within(prefix + "dropped_share", wheel.dropped_share, 0.0, 1.0);
  check_within(prefix + "nan_share", wheel.nan_share, 0.0, 1.0);
  check_within(prefix + "clock", wheel.clock, -kInfinity, kInfinity);
  check_within(prefix + "ahead", wheel.ahead, -10.0, 10.0);
}

void check_faults(const std::vector<WheelFault>& faults, std::size_t wheels) {
  for (std::size_t i = 0; i < faults.size(); ++i) {
    const std::string prefix = "faults[" + std::to_string(i) + "].";
    check_within(prefix + "wheel", static_cast<double>(faults[i].wheel), 0.0,
                 static_cast<double>(wheels) - 1.0);
    check_within(prefix + "begin", faults[i].begin, 0.0, kInfinity);
    check_within(prefix + "length", faults[i].length, 0.0, kInfinity);
    check_within(prefix + "ratio", faults[i].ratio, 0.0, 1.0);
  }
}

}  // namespace

void CrawlerParameters::validate() const {
  check_within("wheels", static_cast<double>(wheels.size()), 1, 64);
  for (std::size_t i = 0; i < wheels.size(); ++i) {
    check_wheel("wheels[" + std::to_string(i) + "].", wheels[i]);
  }
  check_within("slip_spacing", slip_spacing, 0.0, kInfinity);
  check_above("slip_shortest", slip_shortest, 0.0, kInfinity);
  check_within("slip_longest", slip_longest, slip_shortest, kInfinity);
  check_within("slip_least", slip_least, 0.0, 1.0);
  check_within("slip_most", slip_most, slip_least, 1.0);
  check_within("slip_together_share", slip_together_share, 0.0, 1.0);
  check_within("stick_spacing", stick_spacing, 0.0, kInfinity);
  check_above("stick_shortest", stick_shortest, 0.0, kInfinity);
  check_within("stick_longest", stick_longest, stick_shortest, kInfinity);
  check_within("roll", roll, -kInfinity, kInfinity);
  check_within("roll_per_metre", roll_per_metre, -10.0, 10.0);
  if (fittings) {
    fittings->validate();
  }
}

Crawler::Crawler(JointedPipe pipe, Motion motion, CrawlerParameters parameters, std::uint64_t seed)
    : pipe_(std::move(pipe)), motion_(std::move(motion)), parameters_(std::move(parameters)) {
  parameters_.validate();
  draw_faults(seed);
  start(seed);
}

Crawler::Crawler(JointedPipe pipe, Motion motion, CrawlerParameters parameters, std::uint64_t seed,
                 std::vector<WheelFault> faults)
    : pipe_(std::move(pipe)),
      motion_(std::move(motion)),
      parameters_(std::move(parameters)),
      faults_(std::move(faults)) {
  parameters_.validate();
  check_faults(faults_, parameters_.wheels.size());
  start(seed);
}

/// Slips and sticks come one after the other, as often as their spacings say.
void Crawler::draw_faults(std::uint64_t seed) {
  auto engine = make_engine(seed, kFaultDraws);
  const double slip_rate = parameters_.slip_spacing > 0.0 ? 1.0 / parameters_.slip_spacing : 0.0;
  const double stick_rate = parameters_.stick_spacing > 0.0 ? 1.0 / parameters_.stick_spacing : 0.0;
  const double rate = slip_rate + stick_rate;
  if (rate == 0.0) {
    return;
  }
  const double path = motion_.path(motion_.duration());
  const auto wheels = static_cast<double>(parameters_.wheels.size());
  double begin = exponential(engine) / rate;
  while (begin < path) {
    WheelFault fault{.begin = begin};
    fault.wheel = static_cast<std::size_t>(uniform(engine) * wheels);
    if (uniform(engine) * rate < slip_rate) {
      fault.length = uniform(engine, parameters_.slip_shortest, parameters_.slip_longest);
      fault.ratio = uniform(engine, parameters_.slip_least, parameters_.slip_most);
      if (parameters_.wheels.size() > 1 && uniform(engine) < parameters_.slip_together_share) {
        WheelFault other = fault;
        const auto step = 1 + static_cast<std::size_t>(uniform(engine) * (wheels - 1.0));
        other.wheel = (fault.wheel + step) % parameters_.wheels.size();
        faults_.push_back(other);
      }
    } else {
      fault.kind = WheelFaultKind::kStick;
      fault.length = uniform(engine, parameters_.stick_shortest, parameters_.stick_longest);
      fault.ratio = 1.0;
    }
    faults_.push_back(fault);
    begin += fault.length + exponential(engine) / rate;
  }
}

void Crawler::start(std::uint64_t seed) {
  for (std::size_t i = 0; i < parameters_.wheels.size(); ++i) {
    Wheel wheel{.noise = make_engine(seed, kNoiseDraws + i),
                .channel = make_engine(seed, kChannelDraws + i)};
    std::copy_if(faults_.begin(), faults_.end(), std::back_inserter(wheel.faults),
                 [i](const WheelFault& fault) { return fault.wheel == i; });
    std::stable_sort(wheel.faults.begin(), wheel.faults.end(),
                     [](const WheelFault& a, const WheelFault& b) { return a.begin < b.begin; });
    wheels_.push_back(std::move(wheel));
  }
}

double Crawler::due(std::size_t wheel) const {
  const WheelParameters& parameters = parameters_.wheels[wheel];
  return parameters.start + static_cast<double>(wheels_[wheel].sent) * parameters.period;
}

std::optional<WheelSample> Crawler::next() {
  while (true) {
    std::size_t first = 0;
    for (std::size_t i = 1; i < wheels_.size(); ++i) {
      first = due(i) < due(first) ? i : first;
    }
    const double time = due(first);
    if (!(time <= motion_.duration())) {
      return std::nullopt;
    }
    const WheelParameters& parameters = parameters_.wheels[first];
    Wheel& wheel = wheels_[first];
    ++wheel.sent;
    turn(first, time);
    const bool dropped = uniform(wheel.channel) < parameters.dropped_share;
    const bool not_a_number = uniform(wheel.channel) < parameters.nan_share;
    const double counted =
        parameters.resolution * std::floor(wheel.turned / parameters.resolution + kCountTolerance);
    const double value = parameters.incremental ? counted - std::exchange(wheel.shown, counted)
                                                : parameters.counter_start + counted;
    if (!dropped) {
      return WheelSample{.wheel = first,
                         .time = time,
                         .value = not_a_number ? std::numeric_limits<double>::quiet_NaN() : value,
                         .distance = motion_.distance(time),
                         .path = motion_.path(time),
                         .speed = motion_.speed(time)};
    }
  }
}

/// Turns a wheel up to a time, piece by piece of the motion, fault by fault within each.
void Crawler::turn(std::size_t index, double time) {
  const WheelParameters& parameters = parameters_.wheels[index];
  Wheel& wheel = wheels_[index];
  const double path_before = motion_.path(wheel.time);
  while (wheel.time < time) {
    const MotionPiece& piece = motion_.pieces()[motion_.piece_at(wheel.time)];
    const double piece_end = piece.begin + piece.duration;
    const double until = piece_end > wheel.time ? std::min(time, piece_end) : time;
    const double from = motion_.path(wheel.time);
    const double to = motion_.path(until);
    if (to > from) {
      const double middle = 0.5 * (wheel.time + until);
      const double direction = motion_.speed(middle) < 0.0 ? -1.0 : 1.0;
      const double place = motion_.distance(middle);
      const auto rise =
          parameters_.fittings ? pitch_on_rise(*parameters_.fittings, place) : std::nullopt;
      const double uphill = direction * std::sin(rise.value_or(pipe_.pitch(place)));
      wheel.turned +=
          direction * (1.0 - parameters.gravity_slip * uphill) *
          turning(parameters, wheel, {from, to, motion_.distance(wheel.time), direction});
    }
    wheel.time = until;
  }
  const double path = motion_.path(time);
  // Drawn whether the wheel moves or not, so that its rate alone decides how many are drawn.
  wheel.turned += parameters.noise_per_sqrt_metre * std::sqrt(std::max(0.0, path - path_before)) *
                  normal(wheel.noise);
  while (wheel.first_fault < wheel.faults.size() &&
         wheel.faults[wheel.first_fault].begin + wheel.faults[wheel.first_fault].length <= path) {
    ++wheel.first_fault;
  }
}

/// Integral of (1 + scale error + wear * path) * product of (1 - ratio) over the path, exactly; in
/// bends, over the way on the wall, with the mean scale of each piece.
double Crawler::turning(const WheelParameters& parameters, const Wheel& wheel,
                        const Stretch& stretch) const {
  const auto way = [&](double begin, double end) {
    if (!parameters_.fittings) {
      return end - begin;
    }
    const double a = stretch.distance + stretch.direction * (begin - stretch.from);
    const double b = stretch.distance + stretch.direction * (end - stretch.from);
    // The roll counts from the crawler's centre, the wall from where the wheel is.
    const WallLine line{.angle = parameters.clock + parameters_.roll -
                                 parameters_.roll_per_metre * parameters.ahead,
                        .turn_per_metre = parameters_.roll_per_metre};
    return wall_distance(*parameters_.fittings, line, std::min(a, b) + parameters.ahead,
                         std::max(a, b) + parameters.ahead);
  };
  double sum = 0.0;
  for (double begin = stretch.from; begin < stretch.to;) {
    double end = stretch.to;
    double share = 1.0;
    for (std::size_t i = wheel.first_fault; i < wheel.faults.size(); ++i) {
      const WheelFault& fault = wheel.faults[i];
      const double over = fault.begin + fault.length;
      if (fault.begin > begin) {
        end = std::min(end, fault.begin);
        break;
      }
      if (over > begin) {
        share *= 1.0 - fault.ratio;
        end = std::min(end, over);
      }
    }
    sum += share * way(begin, end) *
           (1.0 + parameters.scale_error + 0.5 * parameters.wear_per_metre * (begin + end));
    begin = end;
  }
  return sum;
}

std::vector<double> Crawler::weld_times() const {
  std::vector<double> times;
  std::size_t weld = 0;
  const auto chainage = [this](std::size_t i) {
    return i < pipe_.joints().size() ? pipe_.joints()[i].begin : pipe_.length();
  };
  for (const MotionPiece& piece : motion_.pieces()) {
    const double end = piece.begin + piece.duration;
    while (weld <= pipe_.joints().size() && motion_.distance(end) >= chainage(weld)) {
      // The distance does not fall within a piece that reaches a new weld: halve the interval.
      double low = piece.begin;
      double high = end;
      for (int i = 0; i < 100 && high - low > 1e-12 * (1.0 + high); ++i) {
        const double middle = 0.5 * (low + high);
        (motion_.distance(middle) >= chainage(weld) ? high : low) = middle;
      }
      times.push_back(motion_.distance(low) >= chainage(weld) ? low : high);
      ++weld;
    }
  }
  return times;
}

}  // namespace pipescout::simulation
