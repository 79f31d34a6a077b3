// SPDX-License-Identifier: Apache-2.0
// Cyclone's generated code reads what ours writes, and writes the same bytes.
#include <dds/dds.h>
#include <dds/ddsi/ddsi_cdrstream.h>
#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <golden_file.hpp>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "cyclone_descriptors.hpp"
#include "pipescout/idl/message_type.hpp"

namespace pipescout {
namespace {

constexpr std::size_t kEncapsulation = 4;

/// The bytes read into Cyclone's structure and written again, with our encapsulation header.
std::vector<std::byte> through_cyclone(const dds_topic_descriptor_t& type,
                                       const std::vector<std::byte>& cdr) {
  const auto size = static_cast<std::uint32_t>(cdr.size() - kEncapsulation);
  std::vector<std::byte> input(cdr.begin() + kEncapsulation, cdr.end());
  std::uint32_t offset = 0;
  // Without this check Cyclone trusts every byte.
  if (dds_stream_normalize_data(reinterpret_cast<char*>(input.data()), &offset, size, false, 1,
                                type.m_ops) == nullptr) {
    return {};
  }
  EXPECT_EQ(offset, size) << "Cyclone sees a shorter message";
  const std::unique_ptr<void, decltype(&std::free)> sample(std::calloc(1, type.m_size), &std::free);
  dds_istream_t in;
  dds_istream_init(&in, size, input.data(), 1);
  dds_stream_read(&in, static_cast<char*>(sample.get()), type.m_ops);
  dds_ostreamLE_t out;
  dds_ostreamLE_init(&out, 64, 1);
  EXPECT_NE(dds_stream_writeLE(&out, static_cast<const char*>(sample.get()), type.m_ops), nullptr);
  std::vector<std::byte> bytes(cdr.begin(), cdr.begin() + kEncapsulation);
  const auto* const first = reinterpret_cast<const std::byte*>(out.x.m_buffer);
  bytes.insert(bytes.end(), first, first + out.x.m_index);
  dds_ostreamLE_fini(&out);
  dds_stream_free_sample(sample.get(), type.m_ops);
  return bytes;
}

std::map<std::string_view, const dds_topic_descriptor_t*> descriptors() {
  std::map<std::string_view, const dds_topic_descriptor_t*> result;
  for (const auto& [name, descriptor] : testing::cyclone_types()) {
    result.emplace(name, descriptor);
  }
  return result;
}

TEST(CycloneCdrTest, EveryTypeHasTheSameDefault) {
  const auto cyclone = descriptors();
  for (const MessageType* type : message_types()) {
    SCOPED_TRACE(type->name);
    const auto found = cyclone.find(type->name);
    ASSERT_NE(found, cyclone.end());
    const auto message = type->create();
    std::vector<std::byte> bytes(type->serialized_size(message.get()));
    ASSERT_EQ(type->serialize(message.get(), bytes), bytes.size());
    EXPECT_EQ(through_cyclone(*found->second, bytes), bytes);
  }
}

TEST(CycloneCdrTest, EveryTypeWithContentHasTheSameBytes) {
  const auto cyclone = descriptors();
  for (const auto& golden : testing::read_golden_files(GOLDEN_DIR)) {
    SCOPED_TRACE(golden.type + " " + golden.kind);
    const auto found = cyclone.find(golden.type);
    ASSERT_NE(found, cyclone.end());
    EXPECT_EQ(through_cyclone(*found->second, golden.cdr), golden.cdr);
    const auto* const type = find_message_type(golden.type);
    ASSERT_NE(type, nullptr);
    const auto message = type->create();
    ASSERT_TRUE(type->deserialize(through_cyclone(*found->second, golden.cdr), message.get()));
    std::vector<std::byte> ours(type->serialized_size(message.get()));
    ASSERT_EQ(type->serialize(message.get(), ours), ours.size());
    EXPECT_EQ(ours, golden.cdr);
  }
}

}  // namespace
}  // namespace pipescout
