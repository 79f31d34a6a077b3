// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>

/// The shared memory segments of Fast DDS on this machine.
namespace pipescout::dds {

/// Where Linux keeps POSIX shared memory.
inline constexpr const char* kSharedMemoryFolder = "/dev/shm";

/// What the names of the blocks of large messages begin with, see shared_payloads.hpp.
inline constexpr const char* kPayloadPrefix = "pipescout_payload_";

/// The size of a segment that the folder has room for, at most `wanted`. Fast DDS touches every
/// page of its segment at start and dies of SIGBUS when the folder is too small (64 MB in a
/// container by default), so each process takes at most an eighth of what is free: several may
/// start at once.
/// Nothing when even a small segment does not fit.
[[nodiscard]] std::optional<std::uint32_t> fitting_segment_bytes(
    std::size_t wanted, const std::filesystem::path& folder = kSharedMemoryFolder);

/// Whether somebody holds the lock of an open file exclusively, as Fast DDS does for each port that
/// has a reader. Looks without keeping it: it is taken together with others for a moment.
[[nodiscard]] bool is_locked(int descriptor);

/// Removes the segments and blocks of processes that were killed; Fast DDS leaves those in place,
/// each as large as the process had asked for. A living owner is known by the lock that it holds on
/// the segment's "_el" file, or on the block itself. Young files are left alone: their owner may be
/// about to lock them.
void remove_abandoned_segments(const std::filesystem::path& folder = kSharedMemoryFolder);

}  // namespace pipescout::dds
