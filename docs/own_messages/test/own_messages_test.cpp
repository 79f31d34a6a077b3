// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <own_messages/action/close_section.hpp>
#include <own_messages/msg/valve_state.hpp>
#include <own_messages/srv/turn_valve.hpp>
#include <pipescout/idl/field_access.hpp>
#include <stdexcept>
#include <vector>

namespace {

namespace fs = std::filesystem;
using own_messages::msg::ValveState;

static_assert(pipescout::Message<ValveState>);
static_assert(pipescout::ServiceTag<own_messages::srv::TurnValve>);
static_assert(pipescout::ActionTag<own_messages::action::CloseSection>);

TEST(OwnMessages, AreStructs) {
  ValveState state;
  state.header.frame_id = "map";
  state.name = "V12";
  EXPECT_EQ(state.state, ValveState::MOVING);
  EXPECT_EQ(state.opening, 0.5);
  state.flanges.resize(4);
  EXPECT_THROW(state.flanges.emplace_back(), std::length_error);
}

TEST(OwnMessages, GoOverTheWire) {
  const auto& type = pipescout::message_type<ValveState>();
  EXPECT_EQ(type.dds_name, "own_messages::msg::dds_::ValveState_");
  ValveState state;
  state.name = "V12";
  state.flanges = {geometry_msgs::msg::Point{.x = 1.0, .y = 2.0, .z = 3.0}};
  std::vector<std::byte> bytes(type.serialized_size(&state));
  ASSERT_EQ(type.serialize(&state, bytes), bytes.size());
  ValveState copy;
  ASSERT_TRUE(type.deserialize(bytes, &copy));
  EXPECT_EQ(copy, state);
  state.name.assign(33, 'x');
  bytes.resize(type.serialized_size(&state));
  EXPECT_EQ(type.serialize(&state, bytes), 0u) << "longer than its bound";
}

/// As tools do that were built without them: by the list in the ament index.
TEST(OwnMessages, AreFoundAtRunTime) {
  auto name = (fs::temp_directory_path() / "own_messages_XXXXXX").string();
  ASSERT_NE(mkdtemp(name.data()), nullptr);
  const fs::path prefix(name);
  const auto index = prefix / "share/ament_index/resource_index/pipescout_messages";
  fs::create_directories(index);
  fs::copy_file(INDEX_ENTRY, index / "own_messages");
  fs::create_directories(prefix / LIBRARY_FOLDER);
  fs::copy_file(LIBRARY, prefix / LIBRARY_FOLDER / fs::path(LIBRARY).filename());
  setenv("AMENT_PREFIX_PATH", prefix.c_str(), 1);
  const auto& type = pipescout::load_message_type("own_messages/msg/ValveState");
  EXPECT_EQ(type.name, "own_messages/msg/ValveState");
  EXPECT_TRUE(type.definition.starts_with("# What a valve says of itself.\n\nuint8 CLOSED=0\n"));
  ASSERT_EQ(type.fields.size(), 5u);
  EXPECT_EQ(type.fields[1].string_length, 32u);
  const auto message = type.create();
  pipescout::FieldEditor(type.fields[1], message.get()).set(0, "V7");
  EXPECT_EQ(static_cast<const ValveState*>(message.get())->name, "V7");
  fs::remove_all(prefix);
}

}  // namespace
