// SPDX-License-Identifier: Apache-2.0
#include "pipescout/simulation/eddy_current_signal.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>

#include "pipescout/statistics/draw.hpp"
#include "pipescout/validation/check.hpp"
#include "pipescout/validation/number_text.hpp"

namespace pipescout::simulation {
namespace {

using Complex = std::complex<double>;
constexpr double kTwoPi = 2.0 * std::numbers::pi;
constexpr double kReachDeviations = 6.0;  // a bell is below 2e-8 of its peak beyond

using statistics::normal;
using statistics::uniform;

/// Height of the larger extreme of bell(u + s) - bell(u - s).
double doublet_peak(double s) {
  double peak = 0.0;
  for (double u = 0.0; u <= s + 2.0; u += 0.01) {
    peak = std::max(peak, std::exp(-(u - s) * (u - s) / 2) - std::exp(-(u + s) * (u + s) / 2));
  }
  return peak;
}

PipeFeature make_dent(double position, std::mt19937_64& engine, const PipeParameters& pipe) {
  PipeFeature dent = make_weld(position, {.peak = pipe.weld_peak * uniform(engine, 0.5, 4.0),
                                          .phase = uniform(engine, 0.0, kTwoPi),
                                          .lobe_distance = uniform(engine, 0.12, 0.5),
                                          .slenderness = uniform(engine, 1.0, 1.5),
                                          .asymmetry = uniform(engine, -0.3, 0.3)});
  dent.kind = FeatureKind::kDent;
  return dent;
}

PipeFeature make_valve(double position, std::mt19937_64& engine, const PipeParameters& pipe) {
  PipeFeature valve{.kind = FeatureKind::kValve, .position = position, .lobes = {}};
  const double half = uniform(engine, 0.2, 0.6);
  const int lobes = 4 + static_cast<int>(uniform(engine, 0.0, 5.0));
  for (int i = 0; i < lobes; ++i) {
    const double offset = uniform(engine, -half, half);
    const double deviation = uniform(engine, 0.03, 0.2);
    const double peak = pipe.weld_peak * uniform(engine, 1.0, 5.0);
    const double phase = uniform(engine, 0.0, kTwoPi);
    valve.lobes.push_back({offset, deviation, std::polar(peak, phase)});
  }
  return valve;
}

PipeFeature make_bend(double position, std::mt19937_64& engine, const PipeParameters& pipe) {
  PipeFeature bend{.kind = FeatureKind::kBend, .position = position, .lobes = {}};
  const double length = uniform(engine, 1.0, 6.0);
  const double phase = uniform(engine, 0.0, kTwoPi);
  const double peak = pipe.weld_peak * uniform(engine, 0.5, 3.0);
  bend.lobes.push_back({0.0, length / 4.0, std::polar(peak, phase)});
  return bend;
}

/// Positions of a Poisson process along the pipe.
std::vector<double> draw_positions(double per_km, double length, std::mt19937_64& engine) {
  std::vector<double> positions;
  if (per_km > 0.0) {
    const double spacing = 1000.0 / per_km;
    for (double at = spacing * statistics::exponential(engine); at < length;
         at += spacing * statistics::exponential(engine)) {
      positions.push_back(at);
    }
  }
  return positions;
}

PipeFeature draw_weld(double at, std::mt19937_64& engine, const PipeParameters& parameters) {
  const double peak = parameters.weld_peak * std::exp(parameters.peak_spread * normal(engine));
  const double phase = parameters.weld_phase + parameters.phase_spread * normal(engine);
  const double lobe_distance =
      uniform(engine, parameters.smallest_lobe_distance, parameters.largest_lobe_distance);
  const double slenderness = uniform(engine, 1.0, 1.8);
  const double asymmetry = parameters.largest_asymmetry * uniform(engine, -1.0, 1.0);
  const double quadrature = parameters.largest_quadrature * uniform(engine, -1.0, 1.0);
  return make_weld(at, {.peak = peak,
                        .phase = phase,
                        .lobe_distance = lobe_distance,
                        .slenderness = slenderness,
                        .asymmetry = asymmetry,
                        .quadrature = quadrature});
}

/// Valves, bends and dents; sorts all by position. `welds` rise.
void draw_others(std::vector<PipeFeature>& features, std::span<const double> welds,
                 std::mt19937_64& engine, const PipeParameters& parameters) {
  for (const double at : draw_positions(parameters.valves_per_km, parameters.length, engine)) {
    const auto next = std::lower_bound(welds.begin(), welds.end(), at);
    const bool clear = (next == welds.end() || *next - at >= 1.0) &&
                       (next == welds.begin() || at - *std::prev(next) >= 1.0);
    if (clear) {
      features.push_back(make_valve(at, engine, parameters));
    }
  }
  for (const double at : draw_positions(parameters.bends_per_km, parameters.length, engine)) {
    features.push_back(make_bend(at, engine, parameters));
  }
  for (const double at : draw_positions(parameters.dents_per_km, parameters.length, engine)) {
    features.push_back(make_dent(at, engine, parameters));
  }
  std::stable_sort(features.begin(), features.end(),
                   [](const auto& a, const auto& b) { return a.position < b.position; });
}

}  // namespace

PipeFeature make_weld(double position, const WeldPulse& pulse) {
  PipeFeature weld{.kind = FeatureKind::kWeld, .position = position, .lobes = {}};
  const double half = pulse.lobe_distance / 2.0;
  const double deviation = half / pulse.slenderness;
  const Complex lobe = std::polar(pulse.peak / doublet_peak(pulse.slenderness), pulse.phase);
  weld.lobes.push_back({-half, deviation, lobe * (1.0 + pulse.asymmetry)});
  weld.lobes.push_back({half, deviation, -lobe * (1.0 - pulse.asymmetry)});
  if (pulse.quadrature != 0.0) {
    // Real passes (var_peq_07): at right angles to the lobes, and twice as fast.
    const Complex aside =
        std::polar(pulse.peak * pulse.quadrature, pulse.phase) * Complex(0.0, 1.0);
    weld.lobes.push_back({-1.5 * half, deviation / 2.0, -aside});
    weld.lobes.push_back({-0.5 * half, deviation / 2.0, aside});
    weld.lobes.push_back({0.5 * half, deviation / 2.0, -aside});
    weld.lobes.push_back({1.5 * half, deviation / 2.0, aside});
  }
  return weld;
}

void PipeParameters::validate() const {
  validation::require("length", length, length > 0, "(0, inf)");
  validation::check_within("length", length, 0.0, 1e6);
  validation::check_within("joint_length", joint_length, 0.5, std::max(0.5, length));
  validation::check_within("joint_spread", joint_spread, 0.0, 0.2);
  validation::require("weld_peak", weld_peak, weld_peak > 0, "(0, inf)");
  validation::check_within("peak_spread", peak_spread, 0.0, 1.0);
  validation::require("smallest_lobe_distance", smallest_lobe_distance, smallest_lobe_distance > 0,
                      "(0, inf)");
  validation::check_within("largest_lobe_distance", largest_lobe_distance, smallest_lobe_distance,
                           1.0);
  validation::check_within("weld_phase", weld_phase, -1e3, 1e3);
  validation::check_within("phase_spread", phase_spread, 0.0, 1e3);
  validation::check_within("largest_asymmetry", largest_asymmetry, 0.0, 0.9);
  validation::check_within("largest_quadrature", largest_quadrature, 0.0, 1.0);
  validation::check_within("valves_per_km", valves_per_km, 0.0, 100.0);
  validation::check_within("bends_per_km", bends_per_km, 0.0, 100.0);
  validation::check_within("dents_per_km", dents_per_km, 0.0, 100.0);
}

std::vector<PipeFeature> draw_features(const PipeParameters& parameters, std::uint64_t seed) {
  parameters.validate();
  std::mt19937_64 engine(seed);
  std::vector<PipeFeature> features;
  std::vector<double> welds;
  for (double at = uniform(engine, 0.0, 1.0) * parameters.joint_length; at < parameters.length;) {
    features.push_back(draw_weld(at, engine, parameters));
    welds.push_back(at);
    const double joint = parameters.joint_length * (1.0 + parameters.joint_spread * normal(engine));
    at += std::max(joint, 0.1 * parameters.joint_length);
  }
  draw_others(features, welds, engine, parameters);
  return features;
}

std::vector<PipeFeature> draw_features(const PipeParameters& parameters,
                                       std::span<const double> welds, std::uint64_t seed) {
  parameters.validate();
  std::mt19937_64 engine(seed);
  std::vector<PipeFeature> features;
  for (std::size_t k = 0; k < welds.size(); ++k) {
    if (!std::isfinite(welds[k]) || (k > 0 && welds[k] <= welds[k - 1])) {
      throw std::invalid_argument("welds[" + std::to_string(k) +
                                  "] = " + validation::number_text(welds[k]) +
                                  " must be finite and above the one before");
    }
    features.push_back(draw_weld(welds[k], engine, parameters));
  }
  draw_others(features, welds, engine, parameters);
  return features;
}

void EddyCurrentParameters::validate() const {
  validation::check_within("sample_rate", sample_rate, 1.0, 1e6);
  validation::require("weld_peak", weld_peak, weld_peak > 0, "(0, inf)");
  validation::check_within("peak_snr", peak_snr, -20.0, 400.0);
  validation::check_within("pink_share", pink_share, 0.0, 1.0);
  validation::check_within("amplitude_drift", amplitude_drift, 0.0, 2.0);
  validation::check_within("baseline_drift", baseline_drift, 0.0, 100.0);
  validation::check_within("lift_off_loss", lift_off_loss, 0.0, 3.0);
  validation::check_within("lift_off_rotation", lift_off_rotation, -std::numbers::pi,
                           std::numbers::pi);
  validation::check_within("lift_off_baseline", lift_off_baseline, 0.0, 100.0);
  validation::check_within("lift_off_direction", lift_off_direction, -1e3, 1e3);
  validation::check_within("hum", hum, 0.0, 100.0);
  validation::check_within("hum_frequency", hum_frequency, 0.0, 1e6);
  validation::check_within("spikes_per_second", spikes_per_second, 0.0, sample_rate);
  validation::check_within("spike_peak", spike_peak, 0.0, 1e3);
  validation::check_within("dropouts_per_second", dropouts_per_second, 0.0, sample_rate);
  validation::check_within("longest_dropout", longest_dropout, 0.0, 60.0);
}

EddyCurrentParameters undisturbed() {
  return {.peak_snr = 400.0,
          .amplitude_drift = 0.0,
          .baseline_drift = 0.0,
          .lift_off_loss = 0.0,
          .lift_off_rotation = 0.0,
          .lift_off_baseline = 0.0,
          .hum = 0.0,
          .spikes_per_second = 0.0,
          .dropouts_per_second = 0.0};
}

PinkNoise::PinkNoise(std::mt19937_64& engine) {
  double corner = 0.25;  // cycles per sample
  for (std::size_t i = 0; i < kPoles; ++i, corner /= 4.0) {
    poles_[i] = std::exp(-kTwoPi * corner);
    gains_[i] = std::sqrt(1.0 - poles_[i]);
  }
  double variance = 0.0;
  for (std::size_t i = 0; i < kPoles; ++i) {
    for (std::size_t j = 0; j < kPoles; ++j) {
      variance += gains_[i] * gains_[j] / (1.0 - poles_[i] * poles_[j]);
    }
  }
  for (std::size_t i = 0; i < kPoles; ++i) {
    gains_[i] /= std::sqrt(variance);
    states_[i] = normal(engine) / std::sqrt(1.0 - poles_[i] * poles_[i]);
  }
}

double PinkNoise::next(std::mt19937_64& engine) {
  const double white = normal(engine);
  double sum = 0.0;
  for (std::size_t i = 0; i < kPoles; ++i) {
    states_[i] = poles_[i] * states_[i] + white;
    sum += gains_[i] * states_[i];
  }
  return sum;
}

Wander::Wander(double shortest_period, double longest_period, std::mt19937_64& engine) {
  for (std::size_t i = 0; i < kWaves; ++i) {
    const double log_period = uniform(engine, std::log(shortest_period), std::log(longest_period));
    rates_[i] = kTwoPi / std::exp(log_period);
    phases_[i] = uniform(engine, 0.0, kTwoPi);
  }
}

double Wander::at(double argument) const noexcept {
  double sum = 0.0;
  for (std::size_t i = 0; i < kWaves; ++i) {
    sum += std::sin(rates_[i] * argument + phases_[i]);
  }
  return sum / static_cast<double>(kWaves);
}

EddyCurrentSignal::EddyCurrentSignal(const EddyCurrentParameters& parameters,
                                     std::vector<PipeFeature> features, std::uint64_t seed)
    : parameters_((parameters.validate(), parameters)),
      features_(std::move(features)),
      noise_deviation_(parameters.weld_peak * std::pow(10.0, -parameters.peak_snr / 20.0)),
      engine_(seed),
      gain_(60.0, 1000.0, engine_),
      baseline_x_(20.0, 600.0, engine_),
      baseline_y_(20.0, 600.0, engine_),
      lift_off_(2.0, 50.0, engine_),
      pink_x_(engine_),
      pink_y_(engine_),
      hum_phase_(uniform(engine_, 0.0, kTwoPi)) {
  for (const auto& feature : features_) {
    validation::check_within("features: position", feature.position, -1e9, 1e9);
    for (const auto& lobe : feature.lobes) {
      validation::check_within("features: offset", lobe.offset, -1e6, 1e6);
      validation::require("features: deviation", lobe.deviation, lobe.deviation > 0, "(0, inf)");
      validation::check_within("features: amplitude", std::abs(lobe.amplitude), 0.0, 1e9);
      reach_ = std::max(reach_, std::abs(lobe.offset) + kReachDeviations * lobe.deviation);
    }
  }
  std::stable_sort(features_.begin(), features_.end(),
                   [](const auto& a, const auto& b) { return a.position < b.position; });
}

Complex EddyCurrentSignal::pulses_at(double distance) const {
  Complex sum{};
  auto feature =
      std::lower_bound(features_.begin(), features_.end(), distance - reach_,
                       [](const auto& candidate, double at) { return candidate.position < at; });
  for (; feature != features_.end() && feature->position <= distance + reach_; ++feature) {
    for (const auto& lobe : feature->lobes) {
      const double u = (distance - feature->position - lobe.offset) / lobe.deviation;
      if (std::abs(u) < kReachDeviations) {
        sum += lobe.amplitude * std::exp(-u * u / 2.0);
      }
    }
  }
  return sum;
}

double EddyCurrentSignal::lift_off_at(double distance) const noexcept {
  return 0.5 + 0.5 * lift_off_.at(distance);
}

Complex EddyCurrentSignal::noise() {
  const double white = std::sqrt(1.0 - parameters_.pink_share);
  const double pink = std::sqrt(parameters_.pink_share);
  const double x = white * normal(engine_) + pink * pink_x_.next(engine_);
  const double y = white * normal(engine_) + pink * pink_y_.next(engine_);
  return noise_deviation_ * Complex(x, y);
}

bool EddyCurrentSignal::happens(double per_second) {
  return uniform(engine_, 0.0, 1.0) * parameters_.sample_rate < per_second;
}

void EddyCurrentSignal::disturb(EddyCurrentSample& sample) {
  if (spike_samples_ == 0 && happens(parameters_.spikes_per_second)) {
    const double peak = parameters_.weld_peak * parameters_.spike_peak * uniform(engine_, 0.2, 1.0);
    spike_ = std::polar(peak, uniform(engine_, 0.0, kTwoPi));
    spike_samples_ = 1 + static_cast<int>(uniform(engine_, 0.0, 3.0));
  }
  if (spike_samples_ > 0) {
    sample.value += spike_;
    sample.fault = SampleFault::kSpike;
    spike_ *= -0.5;  // rings
    --spike_samples_;
  }
  if (dropout_samples_ == 0 && happens(parameters_.dropouts_per_second)) {
    const double longest = parameters_.longest_dropout * parameters_.sample_rate;
    dropout_samples_ = 1 + static_cast<std::int64_t>(uniform(engine_, 0.0, longest));
    dropout_ = static_cast<SampleFault>(2 + static_cast<int>(uniform(engine_, 0.0, 4.0)));
  }
  if (dropout_samples_ > 0) {
    --dropout_samples_;
    sample.fault = dropout_;
    constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
    if (dropout_ == SampleFault::kMissing || dropout_ == SampleFault::kNotANumber) {
      sample.value = {kNaN, kNaN};
    } else {
      sample.value = dropout_ == SampleFault::kHeld ? last_value_ : Complex{};
    }
    return;
  }
  last_value_ = sample.value;
}

EddyCurrentSample EddyCurrentSignal::next(double distance) {
  const auto& p = parameters_;
  EddyCurrentSample sample{.time = static_cast<double>(count_++) / p.sample_rate,
                           .distance = distance,
                           .value = {},
                           .fault = SampleFault::kNone};
  const double lift_off = lift_off_at(distance);
  const Complex gain =
      std::polar(std::exp(p.amplitude_drift * gain_.at(sample.time) - p.lift_off_loss * lift_off),
                 p.lift_off_rotation * lift_off);
  const Complex baseline =
      p.baseline_drift * Complex(baseline_x_.at(sample.time), baseline_y_.at(sample.time)) +
      std::polar(p.lift_off_baseline * lift_off, p.lift_off_direction);
  const double hum = p.hum * std::sin(kTwoPi * p.hum_frequency * sample.time + hum_phase_);
  sample.value =
      gain * pulses_at(distance) + p.weld_peak * (baseline + Complex(hum, hum)) + noise();
  disturb(sample);
  return sample;
}

const char* to_string(FeatureKind kind) noexcept {
  switch (kind) {
    case FeatureKind::kWeld:
      return "weld";
    case FeatureKind::kValve:
      return "valve";
    case FeatureKind::kBend:
      return "bend";
    case FeatureKind::kDent:
      return "dent";
  }
  return "unknown";
}

}  // namespace pipescout::simulation
