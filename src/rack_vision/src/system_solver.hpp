// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "feature_system.hpp"

/// Operations on the systems of a pose problem, whose size is known at run time only: compiled
/// once.
namespace pipescout::rack_vision {

/// A^-1 b and A^-1 B of a symmetric semidefinite system.
[[nodiscard]] SystemVector solve_system(const SystemMatrix& a, const SystemVector& b);
[[nodiscard]] SystemMatrix solve_columns(const SystemMatrix& a, const SystemMatrix& b);

/// A^-1, and its `count` columns from `first` on.
[[nodiscard]] SystemMatrix inverse_system(const SystemMatrix& a);
[[nodiscard]] SystemMatrix inverse_columns(const SystemMatrix& a, int first, int count);

/// A^-1 of a symmetric positive definite system; nothing when it is none.
[[nodiscard]] std::optional<SystemMatrix> inverse_positive(const SystemMatrix& a);

/// A B
[[nodiscard]] SystemMatrix product(const SystemMatrix& a, const SystemMatrix& b);

}  // namespace pipescout::rack_vision
