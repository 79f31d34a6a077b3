// SPDX-License-Identifier: Apache-2.0
#include "pipescout/runtime/names.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

namespace pipescout {
namespace {

template <class Call>
std::optional<InvalidName> refusal_of(const Call& call) {
  try {
    call();
  } catch (const InvalidName& error) {
    return error;
  }
  return std::nullopt;
}

#define EXPECT_REFUSED_AT(position_, call)                                     \
  do {                                                                         \
    const auto refusal = refusal_of([&] { call; });                            \
    ASSERT_TRUE(refusal) << #call;                                             \
    EXPECT_EQ(refusal->position(), std::size_t(position_)) << refusal->what(); \
  } while (false)

TEST(NodeNames, AcceptsLettersDigitsAndUnderscores) {
  for (const char* name : {"a", "_", "node_1", "Leak2", "__x"}) {
    EXPECT_NO_THROW(validate_node_name(name)) << name;
  }
  EXPECT_NO_THROW(validate_node_name(std::string(255, 'a')));
}

TEST(NodeNames, NamesWhatIsWrongAndWhere) {
  EXPECT_REFUSED_AT(0, validate_node_name(""));
  EXPECT_REFUSED_AT(0, validate_node_name("1a"));
  EXPECT_REFUSED_AT(1, validate_node_name("a/b"));
  EXPECT_REFUSED_AT(2, validate_node_name("ab-c"));
  EXPECT_REFUSED_AT(1, validate_node_name("a\xc3\xa4"));
  EXPECT_REFUSED_AT(255, validate_node_name(std::string(256, 'a')));

  const auto refusal = refusal_of([] { validate_node_name("ab-c"); });
  EXPECT_STREQ(refusal->what(),
               "invalid node name 'ab-c': must have only letters, digits and '_' (at position 2)");
  EXPECT_EQ(refusal->name(), "ab-c");
}

TEST(NodeNames, ControlCharactersAreShownEscaped) {
  const auto refusal = refusal_of([] { validate_node_name("a\x1b[2J"); });
  EXPECT_NE(std::string(refusal->what()).find("'a\\x1b[2J'"), std::string::npos);
}

TEST(Namespaces, FollowTheRulesOfRmw) {
  for (const char* name : {"/", "/a", "/a/b_1", "/_"}) {
    EXPECT_NO_THROW(validate_namespace(name)) << name;
  }
  EXPECT_REFUSED_AT(0, validate_namespace(""));
  EXPECT_REFUSED_AT(0, validate_namespace("a"));
  EXPECT_REFUSED_AT(2, validate_namespace("/a/"));
  EXPECT_REFUSED_AT(3, validate_namespace("/a//b"));
  EXPECT_REFUSED_AT(3, validate_namespace("/a/1b"));
  EXPECT_REFUSED_AT(1, validate_namespace("/~a"));
  EXPECT_NO_THROW(validate_namespace("/" + std::string(244, 'a')));
  EXPECT_REFUSED_AT(245, validate_namespace("/" + std::string(245, 'a')));
}

TEST(TopicNames, UnexpandedFormsAreValid) {
  for (const char* name :
       {"a", "a/b", "/a/b", "~", "~/a", "{node}/a", "/a/{ns}_x", "_a", "a_{x1}"}) {
    EXPECT_NO_THROW(validate_topic_name(name)) << name;
  }
}

TEST(TopicNames, NamesWhatIsWrongAndWhere) {
  EXPECT_REFUSED_AT(0, validate_topic_name(""));
  EXPECT_REFUSED_AT(0, validate_topic_name("7a"));
  EXPECT_REFUSED_AT(0, validate_topic_name("/"));
  EXPECT_REFUSED_AT(1, validate_topic_name("a/"));
  EXPECT_REFUSED_AT(2, validate_topic_name("a/7"));
  EXPECT_REFUSED_AT(2, validate_topic_name("a//b"));
  EXPECT_REFUSED_AT(1, validate_topic_name("a b"));
  EXPECT_REFUSED_AT(1, validate_topic_name("a~"));
  EXPECT_REFUSED_AT(1, validate_topic_name("~a"));
  EXPECT_REFUSED_AT(1, validate_topic_name("~~"));
  EXPECT_REFUSED_AT(2, validate_topic_name("a/{b"));
  EXPECT_REFUSED_AT(1, validate_topic_name("a}"));
  EXPECT_REFUSED_AT(1, validate_topic_name("{}"));
  EXPECT_REFUSED_AT(1, validate_topic_name("{{node}}"));
  EXPECT_REFUSED_AT(1, validate_topic_name("{1a}"));
  EXPECT_REFUSED_AT(2, validate_topic_name("{a/b}"));
}

TEST(TopicNames, FullNamesAreAbsoluteAndShortEnough) {
  EXPECT_NO_THROW(validate_full_topic_name("/a/b"));
  EXPECT_REFUSED_AT(0, validate_full_topic_name("a"));
  EXPECT_REFUSED_AT(1, validate_full_topic_name("/{node}"));
  EXPECT_REFUSED_AT(0, validate_full_topic_name("/"));
  EXPECT_NO_THROW(validate_full_topic_name("/" + std::string(246, 'a')));
  EXPECT_REFUSED_AT(247, validate_full_topic_name("/" + std::string(247, 'a')));
}

TEST(NodeNames, FullyQualifiedNamesSplitAndJoin) {
  EXPECT_EQ((NodeName{"/", "n"}).fully_qualified(), "/n");
  EXPECT_EQ((NodeName{"/a/b", "n"}).fully_qualified(), "/a/b/n");
  EXPECT_EQ((NodeName{"/", "n"}).logger_name(), "n");
  EXPECT_EQ((NodeName{"/a/b", "n"}).logger_name(), "a.b.n");
  EXPECT_EQ(NodeName::parse("/a/b/n"), (NodeName{"/a/b", "n"}));
  EXPECT_EQ(NodeName::parse("/n"), (NodeName{"/", "n"}));
  EXPECT_EQ(NodeName::parse("n"), (NodeName{"/", "n"}));
  for (const char* name : {"", "/", "/a/", "a/b", "//n", "/a//n"}) {
    EXPECT_THROW(NodeName::parse(name), InvalidName) << name;
  }
}

TEST(Namespaces, RelativeOnesAreAppended) {
  EXPECT_EQ(join_namespaces("/", "arm"), "/arm");
  EXPECT_EQ(join_namespaces("/robot", "arm/left"), "/robot/arm/left");
  EXPECT_EQ(join_namespaces("/robot", ""), "/robot");
  EXPECT_EQ(join_namespaces("/robot", "/other"), "/other");
  EXPECT_THROW((void)join_namespaces("/robot", "1"), InvalidName);
}

// The table of the ROS 2 design article "Topic and Service name mapping to DDS".
TEST(Expansion, FollowsTheDesignArticle) {
  const NodeName root{"/", "my_node"};
  const NodeName ns{"/my_ns", "my_node"};
  EXPECT_EQ(expand_topic_name("ping", root), "/ping");
  EXPECT_EQ(expand_topic_name("ping", ns), "/my_ns/ping");
  EXPECT_EQ(expand_topic_name("/ping", ns), "/ping");
  EXPECT_EQ(expand_topic_name("~", root), "/my_node");
  EXPECT_EQ(expand_topic_name("~", ns), "/my_ns/my_node");
  EXPECT_EQ(expand_topic_name("~/ping", root), "/my_node/ping");
  EXPECT_EQ(expand_topic_name("~/ping", ns), "/my_ns/my_node/ping");
}

TEST(Expansion, ReplacesSubstitutions) {
  const NodeName node{"/a/b", "n"};
  EXPECT_EQ(expand_topic_name("{node}/x", node), "/a/b/n/x");
  EXPECT_EQ(expand_topic_name("/{node}", node), "/n");
  EXPECT_EQ(expand_topic_name("{ns}/x", node), "/a/b/x");
  EXPECT_EQ(expand_topic_name("{namespace}/{node}_{node}", node), "/a/b/n_n");
  EXPECT_EQ(expand_topic_name("~/{node}", node), "/a/b/n/n");
  EXPECT_EQ(expand_topic_name("{ns}/x", {"/", "n"}), "/x");
  EXPECT_REFUSED_AT(2, (void)expand_topic_name("x_{robot}", node));
}

TEST(Expansion, RefusesAnInvalidNode) {
  EXPECT_THROW((void)expand_topic_name("x", {"a", "n"}), InvalidName);
  EXPECT_THROW((void)expand_topic_name("x", {"/", ""}), InvalidName);
}

TEST(Remapping, ParsesEveryForm) {
  using Kind = RemapRule::Kind;
  EXPECT_EQ(RemapRule::parse("a:=/b"), (RemapRule{Kind::kTopicOrService, "", "a", "/b"}));
  EXPECT_EQ(RemapRule::parse("n:a:=~/b"), (RemapRule{Kind::kTopicOrService, "n", "a", "~/b"}));
  EXPECT_EQ(RemapRule::parse("rostopic://a:=b"), (RemapRule{Kind::kTopic, "", "a", "b"}));
  EXPECT_EQ(RemapRule::parse("rosservice://~/a:=b"), (RemapRule{Kind::kService, "", "~/a", "b"}));
  EXPECT_EQ(RemapRule::parse("n:rosservice://a:=b"), (RemapRule{Kind::kService, "n", "a", "b"}));
  EXPECT_EQ(RemapRule::parse("__node:=m"), (RemapRule{Kind::kNodeName, "", "", "m"}));
  EXPECT_EQ(RemapRule::parse("n:__name:=m"), (RemapRule{Kind::kNodeName, "n", "", "m"}));
  EXPECT_EQ(RemapRule::parse("__ns:=/m"), (RemapRule{Kind::kNamespace, "", "", "/m"}));
}

TEST(Remapping, RefusesMalformedRules) {
  for (const char* rule : {"", "a", "a=b", ":=", ":=b", "a:=", "1:=b", "a:=b/", "n n:a:=b", ":a:=b",
                           "__node:=/a", "__node:=", "__ns:=a", "__ns:=", "rostopic://__node:=a",
                           "rosservice://__ns:=/a", "a:b:c:=d", "a:=b:=c", "/**/a:=b"}) {
    EXPECT_THROW(RemapRule::parse(rule), InvalidName) << rule;
  }
}

RemapRules rules(std::initializer_list<const char*> texts) {
  RemapRules result;
  for (const char* text : texts) {
    result.push_back(RemapRule::parse(text));
  }
  return result;
}

TEST(Remapping, ComparesFullyQualifiedNames) {
  const NodeName node{"/robot", "camera"};
  EXPECT_EQ(resolve_topic_name("image", node, rules({"image:=thermal"})), "/robot/thermal");
  EXPECT_EQ(resolve_topic_name("image", node, rules({"/robot/image:=/x"})), "/x");
  EXPECT_EQ(resolve_topic_name("/robot/image", node, rules({"image:=~/x"})), "/robot/camera/x");
  EXPECT_EQ(resolve_topic_name("~/image", node, rules({"camera/image:=y"})), "/robot/y");
  EXPECT_EQ(resolve_topic_name("image", node, rules({"/image:=/x"})), "/robot/image");
}

TEST(Remapping, TheFirstMatchingRuleAppliesOnce) {
  const NodeName node{"/", "n"};
  EXPECT_EQ(resolve_topic_name("a", node, rules({"a:=b", "b:=c", "a:=d"})), "/b");
}

TEST(Remapping, RulesForOtherNodesDoNotApply) {
  EXPECT_EQ(resolve_topic_name("a", {"/", "n"}, rules({"m:a:=b"})), "/a");
  EXPECT_EQ(resolve_topic_name("a", {"/", "m"}, rules({"m:a:=b"})), "/b");
}

TEST(Remapping, SchemesTellTopicsFromServices) {
  const NodeName node{"/", "n"};
  const RemapRules both = rules({"rostopic://a:=t", "rosservice://a:=s"});
  EXPECT_EQ(resolve_topic_name("a", node, both), "/t");
  EXPECT_EQ(resolve_service_name("a", node, both), "/s");
  EXPECT_EQ(resolve_service_name("a", node, rules({"a:=b"})), "/b");
}

TEST(Remapping, TheResultMustBeValid) {
  const NodeName node{"/" + std::string(200, 'n'), "n"};
  EXPECT_THROW((void)resolve_topic_name("a", node, rules({("a:=" + std::string(60, 'b')).c_str()})),
               InvalidName);
}

TEST(Remapping, RenamesNodesAndThenTheirNamespace) {
  const NodeName node{"/a", "n"};
  EXPECT_EQ(remap_node(node, rules({"__node:=m"})), (NodeName{"/a", "m"}));
  EXPECT_EQ(remap_node(node, rules({"__ns:=/b"})), (NodeName{"/b", "n"}));
  EXPECT_EQ(remap_node(node, rules({"n:__node:=m", "m:__ns:=/b"})), (NodeName{"/b", "m"}));
  EXPECT_EQ(remap_node(node, rules({"n:__node:=m", "n:__ns:=/b"})), (NodeName{"/a", "m"}));
  EXPECT_EQ(remap_node(node, rules({"x:__node:=m"})), node);
}

TEST(Mangling, TopicsAndServicesHaveTheNamesOfRmwFastrtps) {
  EXPECT_EQ(mangle_topic_name("/chatter", DdsTopicKind::kTopic), "rt/chatter");
  EXPECT_EQ(mangle_topic_name("/n/get", DdsTopicKind::kServiceRequest), "rq/n/getRequest");
  EXPECT_EQ(mangle_topic_name("/n/get", DdsTopicKind::kServiceReply), "rr/n/getReply");
  EXPECT_THROW((void)mangle_topic_name("chatter", DdsTopicKind::kTopic), InvalidName);
}

TEST(Mangling, ForeignTopicsAreNotDemangled) {
  for (const char* name : {"", "rt", "rt/", "chatter", "rtx/a", "rq/a", "rq/Request", "rr/aRequest",
                           "ros_discovery_info", "/rt/a"}) {
    EXPECT_FALSE(demangle_topic_name(name)) << name;
  }
}

TEST(Mangling, TypesHaveTheNamesOfRmwFastrtps) {
  EXPECT_EQ(mangle_type_name("sensor_msgs/msg/Image"), "sensor_msgs::msg::dds_::Image_");
  EXPECT_EQ(mangle_type_name("std_srvs/srv/Trigger_Request"),
            "std_srvs::srv::dds_::Trigger_Request_");
  EXPECT_EQ(demangle_type_name("sensor_msgs::msg::dds_::Image_"), "sensor_msgs/msg/Image");
  EXPECT_EQ(demangle_service_type_name("std_srvs::srv::dds_::Trigger_Response_"),
            "std_srvs/srv/Trigger");
  EXPECT_EQ(demangle_service_type_name("a::action::dds_::Go_SendGoal_Request_"),
            "a/action/Go_SendGoal");
  for (const char* name :
       {"", "Image", "sensor_msgs/Image", "/a/b/C", "a/b/", "a/b/c/D", "a/1/C"}) {
    EXPECT_THROW((void)mangle_type_name(name), InvalidName) << name;
  }
  for (const char* name : {"", "HelloWorld", "a::b::C", "a::msg::dds_::", "a::msg::dds_::_",
                           "a::msg::dds_::C", "::msg::dds_::C_", "a::dds_::C_", "::dds_::_"}) {
    EXPECT_FALSE(demangle_type_name(name)) << name;
  }
  EXPECT_FALSE(demangle_service_type_name("a::msg::dds_::C_Request_"));
  EXPECT_FALSE(demangle_service_type_name("a::srv::dds_::C_"));
  EXPECT_FALSE(demangle_service_type_name("a::srv::dds_::_Request_"));
}

TEST(NearestName, FindsSlipsAndNothingElse) {
  const std::vector<std::string> known = {"gain", "max_range", "min_range", "use_sim_time"};
  EXPECT_EQ(nearest_name("gian", known), "gain");
  EXPECT_EQ(nearest_name("maxrange", known), "max_range");
  EXPECT_EQ(nearest_name("min_rnage", known), "min_range");
  EXPECT_EQ(nearest_name("gain", known), "gain");
  EXPECT_EQ(nearest_name("exposure", known), std::nullopt);
  EXPECT_EQ(nearest_name("x", {"y"}), std::nullopt);
  EXPECT_EQ(nearest_name("", known), std::nullopt);
  EXPECT_EQ(nearest_name("gain", {}), std::nullopt);
}

std::string any_token() {
  return *rc::gen::mapcat(rc::gen::inRange(1, 12), [](int length) {
    const auto letter =
        rc::gen::oneOf(rc::gen::inRange('a', static_cast<char>('z' + 1)),
                       rc::gen::inRange('A', static_cast<char>('Z' + 1)), rc::gen::just('_'));
    return rc::gen::container<std::string>(static_cast<std::size_t>(length), letter);
  });
}

std::string any_full_name() {
  std::string name;
  const int parts = *rc::gen::inRange(1, 6);
  for (int i = 0; i < parts; ++i) {
    name += "/" + any_token();
  }
  return name;
}

RC_GTEST_PROP(ManglingProperties, TopicsComeBack, ()) {
  const std::string name = any_full_name();
  const auto kind = *rc::gen::element(DdsTopicKind::kTopic, DdsTopicKind::kServiceRequest,
                                      DdsTopicKind::kServiceReply);
  const auto back = demangle_topic_name(mangle_topic_name(name, kind));
  RC_ASSERT(back.has_value());
  RC_ASSERT(*back == (DemangledTopic{kind, name}));
}

RC_GTEST_PROP(ManglingProperties, TypesComeBack, ()) {
  const std::string name =
      any_token() + "/" + *rc::gen::element<std::string>("msg", "srv") + "/" + any_token();
  RC_ASSERT(demangle_type_name(mangle_type_name(name)) == name);
}

RC_GTEST_PROP(NameProperties, WhatExpandsIsValid, ()) {
  const NodeName node = NodeName::parse(any_full_name());
  const std::string prefix = *rc::gen::element<std::string>("", "/", "~/", "{ns}/", "{node}/");
  const std::string full = resolve_topic_name(prefix + any_token(), node, {});
  validate_full_topic_name(full);
  RC_ASSERT(resolve_topic_name(full, node, {}) == full);
}

RC_GTEST_PROP(NameProperties, AnyTextIsValidatedOrRefused, (const std::string& text)) {
  const auto survives = [&text](const auto& function) {
    try {
      function(text);
    } catch (const InvalidName& error) {
      RC_ASSERT(error.position() <= text.size());
    }
  };
  survives([](const std::string& t) { validate_node_name(t); });
  survives([](const std::string& t) { validate_namespace(t); });
  survives([](const std::string& t) { validate_topic_name(t); });
  survives([](const std::string& t) { validate_full_topic_name(t); });
  survives([](const std::string& t) { (void)mangle_type_name(t); });
  (void)demangle_topic_name(text);
  (void)demangle_type_name(text);
  (void)demangle_service_type_name(text);
}

}  // namespace
}  // namespace pipescout
