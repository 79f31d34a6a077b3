// SPDX-License-Identifier: Apache-2.0
#include "pipescout/estimation/robustness.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>

namespace pipescout::estimation {
namespace {

using statistics::RobustKernel;

TEST(RobustnessTest, IsValidated) {
  EXPECT_NO_THROW(Robustness{}.validate());
  EXPECT_THROW(Robustness{.width = 0}.validate(), std::invalid_argument);
  EXPECT_THROW(Robustness{.gate_probability = 0}.validate(), std::invalid_argument);
  EXPECT_THROW(Robustness{.gate_probability = 1.1}.validate(), std::invalid_argument);
  EXPECT_THROW(Robustness{.width = std::numeric_limits<double>::quiet_NaN()}.validate(),
               std::invalid_argument);
  EXPECT_THROW(Robustness{.kernel = RobustKernel::kTukey}.validate(), std::invalid_argument);
  EXPECT_THROW(Robustness{.kernel = static_cast<RobustKernel>(9)}.validate(),
               std::invalid_argument);
}

}  // namespace
}  // namespace pipescout::estimation
