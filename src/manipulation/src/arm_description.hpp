// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <kdl/chain.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "capsule.hpp"
#include "pipescout/manipulation/arm_model.hpp"

namespace pipescout::manipulation::internal {

/// A body on the chain, in the frame after segment `segment` - 1 of the chain; 0: the base.
struct ChainBody {
  unsigned segment = 0;
  int joint = 0;  ///< how many joints are between it and the base: bodies of one number are rigid
  Capsule capsule{};
};

struct ArmDescription {
  std::vector<ArmJoint> joints;
  KDL::Chain chain;
  std::vector<ChainBody> bodies;
};

/// As the constructor of ArmModel.
[[nodiscard]] ArmDescription parse_arm(std::string_view urdf, const std::string& base_link,
                                       const std::string& camera_link,
                                       const ArmModelOptions& options);

}  // namespace pipescout::manipulation::internal
