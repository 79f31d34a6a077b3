// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>
#include <span>

#include "pipescout/tracking/particle_filter.hpp"

namespace pipescout::benchmarks {

/// The same filter on the Bayesian Filtering Library of Orocos: a bootstrap filter with equations
/// (10) and (14) to (16) as its models. It resamples as ours by draws with replacement; other ways
/// it names, but does not have.
class BflPeer {
 public:
  using Section = tracking::ShapeState<tracking::PipeShape>;

  BflPeer(const tracking::PipeShape& shape,
          const tracking::ParticleFilterParameters<tracking::PipeShape>& parameters,
          const Section& start);
  ~BflPeer();

  void step(double dt, const Section& rate, std::span<const Section> regions);
  /// The weighted mean, without regard of where angles wrap.
  [[nodiscard]] Section mean() const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace pipescout::benchmarks
