// SPDX-License-Identifier: Apache-2.0
// rapidcheck seeds itself at random unless told otherwise before its first property: here property
// tests draw the same cases on every machine. RC_PARAMS given from outside explores further. No
// header of Google Test: this file is compiled into every test executable.
#include <cstdlib>

namespace {

// NOLINTNEXTLINE(concurrency-mt-unsafe, cert-err58-cpp): there is no other thread yet.
[[maybe_unused]] const int kIsSet =
    setenv("RC_PARAMS", "seed=2008 max_success=" PIPESCOUT_PROPERTY_CASES, /*overwrite=*/0);

}  // namespace
