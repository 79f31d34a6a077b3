// SPDX-License-Identifier: Apache-2.0
#include "parameter_services.hpp"

#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <vector>

#include "pipescout/runtime/conversions.hpp"
#include "pipescout/runtime/standard_topics.hpp"
#include "pipescout/testing/component_harness.hpp"

namespace pipescout {
namespace {

namespace srv = rcl_interfaces::srv;
using testing::ComponentHarness;

class Tuned : public Component {
 public:
  explicit Tuned(ComponentOptions options) : Component(std::move(options)) {
    ParameterDescriptor gain;
    gain.description = "of the controller";
    gain.floating_point_range = FloatingPointRange{0.0, 10.0};
    parameters().declare<double>("gain", 1.0, gain);
    parameters().declare<std::int64_t>("window.size", 5);
    parameters().declare<std::string>("window.kind", "median");
    ParameterDescriptor serial;
    serial.read_only = true;
    parameters().declare<std::string>("serial", "A1", serial);
    refusal_ = parameters().on_validate([](const std::vector<NamedParameter>& proposed) {
      for (const NamedParameter& parameter : proposed) {
        if (parameter.name == "window.size" && parameter.value == ParameterValue(4)) {
          return SetResult::refuse("the window must be odd");
        }
        if (parameter.name == "window.size" && parameter.value == ParameterValue(-1)) {
          throw std::runtime_error("a window of less than nothing");
        }
      }
      return SetResult::accept();
    });
  }

 private:
  ParameterCallbackHandle refusal_;
};

class ParameterServicesTest : public ::testing::Test {
 protected:
  template <class S>
  typename S::Response call(const std::string& name, typename S::Request request) {
    const auto result = harness_.call<S>("/tuned/" + name, std::move(request));
    EXPECT_TRUE(result) << name << ": " << (result ? "" : to_string(result.error()));
    return result ? *result.shared() : typename S::Response();
  }

  std::vector<ParameterValue> get(const std::vector<std::string>& names) {
    srv::GetParameters::Request request;
    request.names = names;
    const auto response = call<srv::GetParameters>("get_parameters", request);
    std::vector<ParameterValue> values;
    for (const auto& value : response.values) {
      values.push_back(from_message(value));
    }
    return values;
  }

  std::vector<SetResult> set(const std::vector<NamedParameter>& parameters) {
    srv::SetParameters::Request request;
    request.parameters = to_message(parameters);
    const auto response = call<srv::SetParameters>("set_parameters", request);
    std::vector<SetResult> results;
    for (const auto& result : response.results) {
      results.push_back(from_message(result));
    }
    return results;
  }

  SetResult set_atomically(const std::vector<NamedParameter>& parameters) {
    srv::SetParametersAtomically::Request request;
    request.parameters = to_message(parameters);
    return from_message(
        call<srv::SetParametersAtomically>("set_parameters_atomically", request).result);
  }

  ComponentHarness harness_;
  Tuned& component_ = harness_.make<Tuned>({.name = "tuned"});
};

TEST_F(ParameterServicesTest, GetsValuesInTheOrderOfTheQuestion) {
  EXPECT_EQ(get({"window.kind", "gain"}), (std::vector<ParameterValue>{"median", 1.0}));
}

TEST_F(ParameterServicesTest, AnUndeclaredParameterEmptiesTheAnswer) {
  EXPECT_TRUE(get({"gain", "gian"}).empty());
  srv::GetParameterTypes::Request types;
  types.names = {"gian"};
  EXPECT_TRUE(call<srv::GetParameterTypes>("get_parameter_types", types).types.empty());
  srv::DescribeParameters::Request descriptions;
  descriptions.names = {"gian"};
  EXPECT_TRUE(
      call<srv::DescribeParameters>("describe_parameters", descriptions).descriptors.empty());
}

TEST_F(ParameterServicesTest, TellsTypesAndDescriptions) {
  srv::GetParameterTypes::Request types;
  types.names = {"gain", "window.size", "window.kind"};
  EXPECT_EQ(call<srv::GetParameterTypes>("get_parameter_types", types).types,
            (std::vector<std::uint8_t>{3, 2, 4}));

  srv::DescribeParameters::Request request;
  request.names = {"gain"};
  const auto response = call<srv::DescribeParameters>("describe_parameters", request);
  ASSERT_EQ(response.descriptors.size(), 1U);
  const ParameterDescriptor descriptor = from_message(response.descriptors.front());
  EXPECT_EQ(descriptor.name, "gain");
  EXPECT_EQ(descriptor.type, ParameterType::kDouble);
  EXPECT_EQ(descriptor.description, "of the controller");
  EXPECT_EQ(descriptor.floating_point_range, (FloatingPointRange{0.0, 10.0}));
}

TEST_F(ParameterServicesTest, ListsByPrefix) {
  srv::ListParameters::Request request;
  request.prefixes = {"window"};
  const auto response = call<srv::ListParameters>("list_parameters", request);
  EXPECT_EQ(response.result.names, (std::vector<std::string>{"window.kind", "window.size"}));
  EXPECT_EQ(response.result.prefixes, (std::vector<std::string>{"window"}));
}

TEST_F(ParameterServicesTest, SetsOneByOne) {
  const auto results = set({{"gain", 2.5}, {"gain", 11.0}, {"window.kind", "mean"}});
  ASSERT_EQ(results.size(), 3U);
  EXPECT_TRUE(results[0].successful);
  EXPECT_FALSE(results[1].successful);
  EXPECT_TRUE(results[2].successful);
  EXPECT_EQ(get({"gain", "window.kind"}), (std::vector<ParameterValue>{2.5, "mean"}));
}

TEST_F(ParameterServicesTest, RefusesWithAReason) {
  const auto results = set({{"gain", 1},
                            {"gain", 10.5},
                            {"gian", 1.0},
                            {"window.size", 4},
                            {"window.size", -1},
                            {"serial", "B2"}});
  ASSERT_EQ(results.size(), 6U);
  const std::vector<std::string> reasons{"double", "10", "gian", "odd", "less than nothing",
                                         "read"};
  for (std::size_t i = 0; i < results.size(); ++i) {
    EXPECT_FALSE(results[i].successful) << i;
    EXPECT_NE(results[i].reason.find(reasons[i]), std::string::npos) << results[i].reason;
  }
  EXPECT_EQ(get({"gain", "window.size", "serial"}), (std::vector<ParameterValue>{1.0, 5, "A1"}));
}

TEST_F(ParameterServicesTest, RefusesATypeThatDoesNotExist) {
  srv::SetParameters::Request request;
  request.parameters = to_message({{"gain", 2.0}, {"gain", 3.0}});
  request.parameters[1].value.type = 77;
  const auto response = call<srv::SetParameters>("set_parameters", request);
  ASSERT_EQ(response.results.size(), 2U);
  EXPECT_TRUE(response.results[0].successful);
  EXPECT_FALSE(response.results[1].successful);
  EXPECT_NE(response.results[1].reason.find("77"), std::string::npos);

  srv::SetParametersAtomically::Request atomic;
  atomic.parameters = request.parameters;
  EXPECT_FALSE(
      call<srv::SetParametersAtomically>("set_parameters_atomically", atomic).result.successful);
}

TEST_F(ParameterServicesTest, SetsAllOrNothing) {
  EXPECT_FALSE(set_atomically({{"gain", 3.0}, {"window.size", 4}}).successful);
  EXPECT_EQ(get({"gain"}), (std::vector<ParameterValue>{1.0}));
  EXPECT_TRUE(set_atomically({{"gain", 3.0}, {"window.size", 7}}).successful);
  EXPECT_EQ(get({"gain", "window.size"}), (std::vector<ParameterValue>{3.0, 7}));
}

TEST_F(ParameterServicesTest, TellsTheWorldOfChanges) {
  const auto events = harness_.collect(topics::kParameterEvents);
  ASSERT_TRUE(set_atomically({{"gain", 4.0}}).successful);
  ASSERT_FALSE(set_atomically({{"gain", 40.0}}).successful);
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(events.back().node, "/tuned");
  EXPECT_GT(from_message(events.back().stamp), Time{});
  EXPECT_TRUE(events.back().new_parameters.empty());
  EXPECT_TRUE(events.back().deleted_parameters.empty());
  ASSERT_EQ(events.back().changed_parameters.size(), 1U);
  EXPECT_EQ(from_message(events.back().changed_parameters.front()), (NamedParameter{"gain", 4.0}));
}

TEST_F(ParameterServicesTest, TellsTheWorldOfDeclarations) {
  const auto events = harness_.collect(topics::kParameterEvents);
  component_.parameters().declare<bool>("verbose", true);
  harness_.spin();
  ASSERT_EQ(events.size(), 1U);
  ASSERT_EQ(events.back().new_parameters.size(), 1U);
  EXPECT_EQ(from_message(events.back().new_parameters.front()), (NamedParameter{"verbose", true}));
}

TEST_F(ParameterServicesTest, ServesInEveryLifecycleState) {
  ASSERT_TRUE(harness_.shutdown(component_).success);
  EXPECT_EQ(get({"gain"}), (std::vector<ParameterValue>{1.0}));
}

}  // namespace
}  // namespace pipescout
