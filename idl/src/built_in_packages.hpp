// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "pipescout/idl/support/type_support.hpp"

namespace pipescout::idl {

/// Gives the types of one package.
using ListTypes = PackageTypes (*)();

/// The packages that this library holds; written by the build.
std::span<const ListTypes> built_in_packages() noexcept;

}  // namespace pipescout::idl
