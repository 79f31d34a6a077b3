// SPDX-License-Identifier: Apache-2.0
// The main function of all Google tests. rapidcheck seeds itself at random unless told otherwise:
// here property tests draw the same cases on every machine. RC_PARAMS given from outside explores
// further.
#include <gmock/gmock.h>

#include <cstdlib>

int main(int argc, char** argv) {
  // NOLINTNEXTLINE(concurrency-mt-unsafe): there is no other thread yet.
  setenv("RC_PARAMS", "seed=2008 max_success=" PIPESCOUT_PROPERTY_CASES, /*overwrite=*/0);
  testing::InitGoogleMock(&argc, argv);
  return RUN_ALL_TESTS();
}
