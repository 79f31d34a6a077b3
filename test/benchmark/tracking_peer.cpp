// SPDX-License-Identifier: Apache-2.0
#include "tracking_peer.hpp"

#include <bfl/filter/bootstrapfilter.h>
#include <bfl/model/measurementmodel.h>
#include <bfl/model/systemmodel.h>
#include <bfl/pdf/mcpdf.h>
#include <bfl/wrappers/rng/rng.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

namespace pipescout::benchmarks {
namespace {

using MatrixWrapper::ColumnVector;
using tracking::PipeShape;
using Section = BflPeer::Section;
using Parameters = tracking::ParticleFilterParameters<PipeShape>;

constexpr unsigned kSize = PipeShape::kSize;

ColumnVector vector_of(const Section& section) {
  ColumnVector result(kSize);
  for (unsigned i = 0; i < kSize; ++i) {
    result(i + 1) = section[i];
  }
  return result;
}

/// What is measured: the regions of a picture.
using Regions = std::span<const Section>;

/// Equation (10).
class Motion : public BFL::ConditionalPdf<ColumnVector, ColumnVector> {
 public:
  explicit Motion(const Section& deviation) : ConditionalPdf(kSize, 1), deviation_(deviation) {}

  void set(double dt, const Section& rate) {
    shift_ = dt * rate;
    spread_ = std::sqrt(dt) * deviation_;
  }
  bool SampleFrom(BFL::Sample<ColumnVector>& sample, int /*method*/,
                  void* /*arguments*/) const override {
    ColumnVector state = ConditionalArgumentGet(0);
    for (unsigned i = 0; i < kSize; ++i) {
      state(i + 1) += shift_[i] + BFL::rnorm(0, spread_[i]);
    }
    sample.ValueSet(state);
    return true;
  }
  Motion* Clone() const override { return new Motion(*this); }

 private:
  Section deviation_;
  Section shift_ = Section::Zero();
  Section spread_ = Section::Zero();
};

/// Equations (14) to (16).
class Likelihood : public BFL::ConditionalPdf<Regions, ColumnVector> {
 public:
  explicit Likelihood(const PipeShape& shape) : ConditionalPdf(kSize, 1), shape_(shape) {}

  BFL::Probability ProbabilityGet(const Regions& regions) const override {
    const ColumnVector& state = ConditionalArgumentGet(0);
    double nearest = std::numeric_limits<double>::max();
    for (const Section& region : regions) {
      std::array<double, kSize> difference;
      for (unsigned i = 0; i < kSize; ++i) {
        const double d = state(i + 1) - region[i];
        difference[i] = PipeShape::kPeriods[i] > 0 ? std::remainder(d, PipeShape::kPeriods[i]) : d;
      }
      nearest = std::min(nearest, shape_.distance(difference));
    }
    return std::exp(-nearest);
  }
  Likelihood* Clone() const override { return new Likelihood(*this); }

 private:
  PipeShape shape_;
};

}  // namespace

struct BflPeer::Implementation {
  Implementation(const PipeShape& shape, const Parameters& parameters, const Section& start)
      : motion(parameters.process_deviation),
        likelihood(shape),
        system(&motion),
        measurement(&likelihood),
        prior(static_cast<unsigned>(parameters.particles), kSize) {
    std::vector<BFL::Sample<ColumnVector>> samples(parameters.particles,
                                                   BFL::Sample<ColumnVector>(kSize));
    for (auto& sample : samples) {
      Section drawn;
      for (unsigned i = 0; i < kSize; ++i) {
        drawn[i] = BFL::rnorm(start[i], parameters.start_deviation[i]);
      }
      sample.ValueSet(vector_of(drawn));
    }
    prior.ListOfSamplesSet(samples);
    filter = std::make_unique<BFL::BootstrapFilter<ColumnVector, Regions>>(
        &prior, 0, parameters.resample_share * static_cast<double>(parameters.particles),
        MULTINOMIAL_RS);
  }

  Motion motion;
  Likelihood likelihood;
  BFL::SystemModel<ColumnVector> system;
  BFL::MeasurementModel<Regions, ColumnVector> measurement;
  BFL::MCPdf<ColumnVector> prior;
  std::unique_ptr<BFL::BootstrapFilter<ColumnVector, Regions>> filter;
};

BflPeer::BflPeer(const PipeShape& shape, const Parameters& parameters, const Section& start)
    : implementation_(std::make_unique<Implementation>(shape, parameters, start)) {}

BflPeer::~BflPeer() = default;

void BflPeer::step(double dt, const Section& rate, std::span<const Section> regions) {
  implementation_->motion.set(dt, rate);
  implementation_->filter->Update(&implementation_->system, &implementation_->measurement, regions);
}

Section BflPeer::mean() const {
  const ColumnVector mean = implementation_->filter->PostGet()->ExpectedValueGet();
  Section result;
  for (unsigned i = 0; i < kSize; ++i) {
    result[i] = mean(i + 1);
  }
  return result;
}

}  // namespace pipescout::benchmarks
