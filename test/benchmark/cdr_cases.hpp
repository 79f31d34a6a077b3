// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "figures.hpp"

/// What writing and reading messages as CDR costs, beside the code that Cyclone's idlc generates.
namespace pipescout::benchmarks {

void register_cdr();

/// `cdr_encode_ratio` and `cdr_decode_ratio`: ours / Cyclone's, the largest of an Image,
/// an Odometry and a DiagnosticArray of 50; each message's own ratios are rows. (An Image is one
/// memcpy on either side: its ratio is 1 within the noise.)
///
/// Writing: the size first, then into a buffer that is there, as the transport does; Cyclone's
/// grows its own buffer once and keeps it. Reading: into a message that is there; Cyclone checks
/// the bytes first (`dds_stream_normalize`), as it does with whatever it receives, since its
/// reading trusts them, and ours checks as it reads. The rows have Cyclone's reading without the
/// check too.
void add_cdr_figures(Figures& figures);

}  // namespace pipescout::benchmarks
