// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "pipescout/geometry/se3.hpp"

namespace pipescout::manipulation {

/// Where a link is in the link that carries it.
struct LinkTransform {
  std::string parent;
  std::string child;
  geometry::SE3 T_parent_child;
};

/// The tree of links of a robot description (URDF), and where joints put them: for whole robots
/// what ArmModel is for one chain. Values only; const members may be called by several threads at
/// once.
class RobotTree {
 public:
  /// `urdf`: the text of a robot description. Throws std::invalid_argument naming the joint: the
  /// text is no robot description, an origin is not finite, a joint that moves has no axis or
  /// mimics one that is not there.
  explicit RobotTree(std::string_view urdf);

  [[nodiscard]] const std::string& root() const noexcept { return root_; }
  /// Links that never move against the one that carries them.
  [[nodiscard]] const std::vector<LinkTransform>& fixed() const noexcept { return fixed_; }
  /// Names of joints of more than one degree of freedom (planar, floating): one number does not say
  /// where they are, somebody else must.
  [[nodiscard]] const std::vector<std::string>& left_out() const noexcept { return left_out_; }

  /// The links that the named joints move, and those that mimic them. `positions`: rad, or m of
  /// prismatic joints, one for each name. Names that are not in the description are passed over.
  /// Throws std::invalid_argument when the sizes differ, or naming the joint whose position is not
  /// finite.
  [[nodiscard]] std::vector<LinkTransform> moving(std::span<const std::string> names,
                                                  std::span<const double> positions) const;

 private:
  struct Joint {
    LinkTransform at_zero;
    Eigen::Vector3d axis;  // unit, in the frame of the child at zero
    bool turns = true;     // else it slides
    double multiplier = 1;
    double offset = 0;  // rad or m
  };

  std::string root_;
  std::vector<LinkTransform> fixed_;
  std::vector<std::string> left_out_;
  std::multimap<std::string, Joint> joints_;  // by the name of the joint whose position moves it
};

}  // namespace pipescout::manipulation
