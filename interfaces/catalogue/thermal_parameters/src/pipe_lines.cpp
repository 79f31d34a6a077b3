// SPDX-License-Identifier: Apache-2.0
#include "pipescout/thermal_parameters/pipe_lines.hpp"

#include <stdexcept>
#include <string>

namespace pipescout {

std::vector<leak_findings::PipeLine> pipe_lines(const Parameter<std::vector<double>>& parameter) {
  const auto values = parameter.share();
  if (values->size() % 6 != 0) {
    throw std::invalid_argument("parameter '" + parameter.name() +
                                "' must have six numbers per line, not " +
                                std::to_string(values->size()) + " in all");
  }
  std::vector<leak_findings::PipeLine> result;
  for (std::size_t i = 0; i < values->size(); i += 6) {
    result.push_back({.from = Eigen::Map<const Eigen::Vector3d>(values->data() + i),
                      .to = Eigen::Map<const Eigen::Vector3d>(values->data() + i + 3)});
  }
  return result;
}

}  // namespace pipescout
