// SPDX-License-Identifier: Apache-2.0
#include "pipescout/keystore/keystore.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <string>

#include "pipescout/files/testing/temporary_folder.hpp"

namespace pipescout::keystore {
namespace {

using ::pipescout::testing::content;
using ::pipescout::testing::TemporaryFolder;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
namespace fs = std::filesystem;

constexpr std::time_t kNow = 1'800'000'000;  // 2027-01-15
constexpr std::time_t kDay = 24 * 3600;

class KeystoreTest : public ::testing::Test {
 protected:
  KeystoreTest() { create_keystore(keystore_, 0, 3650, kNow); }

  template <class Call>
  static std::string error_of(const Call& call) {
    try {
      call();
    } catch (const KeystoreError& error) {
      return error.what();
    }
    return "no error";
  }
  void add(const std::string& name) { create_enclave(keystore_, {.name = name}, kNow); }
  [[nodiscard]] std::vector<Finding> worse_than_ok(std::time_t now = kNow) const {
    auto findings = check(keystore_, 30, now);
    std::erase_if(findings, [](const Finding& finding) {
      return finding.severity == Finding::Severity::kOk;
    });
    return findings;
  }

  TemporaryFolder folder_;
  const fs::path keystore_ = folder_.path() / "keystore";
};

TEST_F(KeystoreTest, HasTheLayoutOfSros2) {
  add("/robot_1/arm");
  const fs::path enclave = keystore_ / "enclaves/robot_1/arm";
  for (const char* const name :
       {"cert.pem", "key.pem", "identity_ca.cert.pem", "permissions_ca.cert.pem", "governance.p7s",
        "permissions.p7s", "permissions.xml", "crl.pem"}) {
    EXPECT_TRUE(fs::exists(enclave / name)) << name;
  }
  EXPECT_EQ(fs::read_symlink(enclave / "governance.p7s"), "../../governance.p7s");
  EXPECT_EQ(fs::read_symlink(enclave / "crl.pem"), "../../../public/identity_ca.crl.pem");
  EXPECT_THAT(list_enclaves(keystore_), ElementsAre("/robot_1/arm"));
}

/// The folder of the default enclave holds the governance and the other enclaves.
TEST_F(KeystoreTest, TheRootEnclaveLeavesTheOthersAsTheyAre) {
  const fs::path enclaves = keystore_ / "enclaves";
  const std::string governance = content(enclaves / "governance.p7s");
  const fs::perms permissions = fs::status(enclaves).permissions();
  add("/robot_1");
  add("/");
  create_enclave(keystore_, {.name = "/", .renew = true}, kNow);
  revoke(keystore_, "/robot_1", kNow);
  EXPECT_EQ(content(enclaves / "governance.p7s"), governance);
  EXPECT_EQ(content(enclaves / "robot_1/governance.p7s"), governance);
  EXPECT_EQ(fs::status(enclaves).permissions(), permissions);
  EXPECT_THAT(list_enclaves(keystore_), ElementsAre("/", "/robot_1"));
}

TEST_F(KeystoreTest, KeysAreReadableByTheirOwnerAlone) {
  add("/robot_1");
  for (const char* const name : {"private/identity_ca.key.pem", "private/permissions_ca.key.pem",
                                 "enclaves/robot_1/key.pem"}) {
    EXPECT_EQ(fs::status(keystore_ / name).permissions(),
              fs::perms::owner_read | fs::perms::owner_write)
        << name;
  }
}

TEST_F(KeystoreTest, IdentitiesAndPermissionsHaveDifferentAuthorities) {
  EXPECT_NE(content(keystore_ / "private/identity_ca.key.pem"),
            content(keystore_ / "private/permissions_ca.key.pem"));
  add("/robot_1");
  EXPECT_THAT(worse_than_ok(), ::testing::IsEmpty());
}

TEST_F(KeystoreTest, CheckWarnsOfWhatEndsSoonAndNamesWhatHasEnded) {
  add("/robot_1");
  const auto soon = worse_than_ok(kNow + 340 * kDay);
  ASSERT_EQ(soon.size(), 1U);
  EXPECT_EQ(soon[0].severity, Finding::Severity::kWarning);
  EXPECT_THAT(soon[0].text, HasSubstr("valid for 25 days"));
  const auto ended = worse_than_ok(kNow + 366 * kDay);
  ASSERT_EQ(ended.size(), 1U);
  EXPECT_EQ(ended[0].severity, Finding::Severity::kError);
  EXPECT_THAT(ended[0].text, HasSubstr("expired on " + date_text(kNow + 365 * kDay)));
  EXPECT_THAT(ended[0].file, HasSubstr("robot_1/cert.pem"));
}

TEST_F(KeystoreTest, CheckNamesMissingMalformedAndOpenFiles) {
  add("/robot_1");
  const fs::path enclave = keystore_ / "enclaves/robot_1";
  fs::permissions(enclave / "key.pem", fs::perms::group_read, fs::perm_options::add);
  fs::remove(enclave / "governance.p7s");
  std::ofstream(enclave / "permissions.p7s", std::ios::app) << "x";
  std::ofstream(enclave / "cert.pem") << "nonsense";
  std::string all;
  for (const auto& finding : worse_than_ok()) {
    EXPECT_EQ(finding.severity == Finding::Severity::kError, !finding.file.ends_with("key.pem"));
    all += finding.file + ": " + finding.text + "\n";
  }
  EXPECT_THAT(all, HasSubstr("key.pem: others than its owner"));
  EXPECT_THAT(all, HasSubstr("governance.p7s: No such file"));
  EXPECT_THAT(all, HasSubstr("cert.pem: is no certificate"));
}

TEST_F(KeystoreTest, ChangedPermissionsAreNoLongerSigned) {
  add("/robot_1");
  const fs::path file = keystore_ / "enclaves/robot_1/permissions.p7s";
  std::string text = content(file);
  text.replace(text.find("<default>DENY"), 13, "<default>ALLO");
  std::ofstream(file) << text;
  const auto findings = worse_than_ok();
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_THAT(findings[0].text, HasSubstr("changed since"));
}

TEST_F(KeystoreTest, RevokedEnclaveIsInTheListOfAllEnclaves) {
  add("/robot_1");
  add("/robot_2");
  const std::string before = content(keystore_ / "enclaves/robot_2/crl.pem");
  revoke(keystore_, "/robot_1", kNow);
  EXPECT_NE(content(keystore_ / "enclaves/robot_2/crl.pem"), before);
  const auto findings = worse_than_ok();
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_THAT(findings[0].text, HasSubstr("revoked on"));
  EXPECT_THAT(error_of([&] { revoke(keystore_, "/robot_1", kNow); }), HasSubstr("was revoked on"));
}

TEST_F(KeystoreTest, RenewedEnclaveHasAnotherKeyAndIsNotRevoked) {
  add("/robot_1");
  const std::string before = content(keystore_ / "enclaves/robot_1/key.pem");
  revoke(keystore_, "/robot_1", kNow);
  create_enclave(keystore_, {.name = "/robot_1", .renew = true}, kNow);
  EXPECT_NE(content(keystore_ / "enclaves/robot_1/key.pem"), before);
  EXPECT_THAT(worse_than_ok(), ::testing::IsEmpty());
}

TEST_F(KeystoreTest, RefusesWhatItCannotDo) {
  EXPECT_THAT(error_of([&] { create_keystore(keystore_, 0, 1, kNow); }), HasSubstr("already"));
  EXPECT_THAT(error_of([&] { add("robot"); }), HasSubstr("must begin with '/'"));
  EXPECT_THAT(error_of([&] { add("/../x"); }), HasSubstr("may hold letters"));
  EXPECT_THAT(error_of([&] { add("/a//b"); }), HasSubstr("begin with a letter"));
  add("/a");
  EXPECT_THAT(error_of([&] { add("/a"); }), HasSubstr("exists already"));
  EXPECT_THAT(error_of([&] { create_enclave(keystore_, {.name = "/b", .days = 0}, kNow); }),
              HasSubstr("1..36500"));
  EXPECT_THAT(error_of([&] { create_enclave(keystore_, {.name = "/b"}, kNow + 4000 * kDay); }),
              HasSubstr("authority expired on"));
  EXPECT_THAT(error_of([&] { revoke(keystore_, "/c", kNow); }), HasSubstr("cert.pem"));
  EXPECT_THAT(error_of([&] { (void)list_enclaves(folder_.path()); }), HasSubstr("is no keystore"));
}

TEST(Policy, RoundTripsAndReadsThatOfSros2) {
  Policy policy;
  add_endpoint(policy["/robot_1"], "rt/weld", true);
  add_endpoint(policy["/robot_1"], "rq/robot/getRequest", false);
  add_endpoint(policy["/robot_1"], "rr/robot/getReply", true);
  add_endpoint(policy["/robot_1"], "ros_discovery_info", true);
  EXPECT_EQ(policy["/robot_1"].publish, std::set<std::string>{"/weld"});
  EXPECT_EQ(policy["/robot_1"].reply, std::set<std::string>{"/robot/get"});
  EXPECT_EQ(parse_policy(to_policy_xml(policy), "p.xml"), policy);

  const auto read = parse_policy(R"(<policy version="0.2.0"><enclaves><enclave path="/a"><profiles>
<profile ns="/x" node="n"><topics publish="ALLOW"><topic>t</topic><topic>~/own</topic></topics>
<actions call="ALLOW"><action>/go</action></actions></profile></profiles></enclave></enclaves></policy>)",
                                 "p.xml");
  EXPECT_EQ(read.at("/a").publish, (std::set<std::string>{"/x/t", "/x/n/own"}));
  EXPECT_TRUE(read.at("/a").request.contains("/go/_action/send_goal"));
  EXPECT_TRUE(read.at("/a").subscribe.contains("/go/_action/feedback"));
}

TEST(Policy, RefusesDenialsAndUnknownWordsWithTheLine) {
  const auto error_of = [](const std::string& inside) {
    try {
      (void)parse_policy(
          "<policy><enclaves><enclave path=\"/a\"><profiles>\n<profile ns=\"/\" "
          "node=\"n\">" +
              inside + "</profile></profiles></enclave></enclaves></policy>",
          "p.xml");
    } catch (const KeystoreError& error) {
      return std::string(error.what());
    }
    return std::string("no error");
  };
  EXPECT_THAT(error_of("<topics publish=\"DENY\"/>"), HasSubstr("p.xml:2: <topics>"));
  EXPECT_THAT(error_of("<topics read=\"ALLOW\"/>"), HasSubstr("is no group of rights"));
  EXPECT_THAT(error_of("<topics publish=\"ALLOW\"><topic/></topics>"), HasSubstr("with a name"));
  EXPECT_THAT(error_of("<topics"), HasSubstr("is no XML"));
}

/// A policy in files that include each other, laid out as the samples of SROS 2 are.
class PolicyFiles : public ::testing::Test {
 protected:
  void write(const std::string& name, const std::string& text) const {
    const auto file = folder_.path() / name;
    fs::create_directories(file.parent_path());
    std::ofstream(file) << text;
  }
  static std::string include(const std::string& href, const std::string& pointer) {
    return "<xi:include href=\"" + href + "\" xpointer=\"xpointer(" + pointer + ")\"/>";
  }
  void write_policy(const std::string& name, const std::string& enclaves) const {
    write(name,
          "<policy version=\"0.2.0\" xmlns:xi=\"http://www.w3.org/2001/XInclude\">\n"
          "<enclaves>\n" +
              enclaves + "</enclaves></policy>");
  }
  static std::string enclave(const std::string& path, const std::string& inside) {
    return "<enclave path=\"" + path + "\"><profiles>\n<profile ns=\"/\" node=\"talker\">\n" +
           inside + "</profile></profiles></enclave>\n";
  }
  [[nodiscard]] Policy read(const std::string& name) const {
    return read_policy(folder_.path() / name);
  }
  [[nodiscard]] std::string error_of(const std::string& name) const {
    try {
      (void)read(name);
    } catch (const KeystoreError& error) {
      std::string what = error.what();
      for (const auto root = folder_.path().string() + "/"; what.find(root) != std::string::npos;) {
        what.erase(what.find(root), root.size());
      }
      return what;
    }
    return "no error";
  }

  TemporaryFolder folder_;
};

TEST_F(PolicyFiles, IncludePartsOfEachOther) {
  // The inner files bind the prefix to the namespace of a draft, as some of SROS 2 do.
  write("common/node.xml", "<profile xmlns:xi=\"http://www.w3.org/2003/XInclude\">" +
                               include("node/time.xml", "/profile/*") +
                               "<services reply=\"ALLOW\"><service>~get_parameters</service>"
                               "</services></profile>");
  write("common/node/time.xml",
        "<profile><topics subscribe=\"ALLOW\"><topic>/clock</topic></topics></profile>");
  write_policy("talker.policy.xml",
               enclave("/talker", include("common/node.xml", "/profile/*") +
                                      "<topics publish=\"ALLOW\"><topic>chatter</topic></topics>"));
  write_policy("all.policy.xml",
               include("talker.policy.xml", "/policy/enclaves/*") +
                   "<enclave path=\"/one\"><profiles>" +
                   include("talker.policy.xml", "/policy/enclaves/enclave/profiles/*") +
                   "</profiles></enclave>");
  const auto policy = read("all.policy.xml");
  ASSERT_EQ(policy.size(), 2U);
  for (const auto& [name, rights] : policy) {
    EXPECT_EQ(rights.publish, std::set<std::string>{"/chatter"}) << name;
    EXPECT_EQ(rights.subscribe, std::set<std::string>{"/clock"}) << name;
    EXPECT_EQ(rights.reply, std::set<std::string>{"/talker/get_parameters"}) << name;
  }
  // Without a pointer: the root element.
  write("topics.xml", "<topics publish=\"ALLOW\"><topic>whole</topic></topics>");
  write_policy("root.xml", enclave("/r", "<xi:include href=\"topics.xml\" parse=\"xml\"/>"));
  EXPECT_EQ(read("root.xml").at("/r").publish, std::set<std::string>{"/whole"});
}

TEST_F(PolicyFiles, WhatIsWrongIsSaidWithTheFileItIsIn) {
  const auto error_with = [&](const std::string& inside) {
    write_policy("p.xml", enclave("/a", inside));
    return error_of("p.xml");
  };
  EXPECT_EQ(error_with(include("none.xml", "/profile/*")),
            "p.xml:5: <xi:include>: none.xml: No such file or directory");
  write("own.xml", "<profile>\n<topics publish=\"DENY\"/></profile>");
  EXPECT_THAT(error_with(include("own.xml", "/profile/*")), HasSubstr("own.xml:2: <topics>"));
  EXPECT_THAT(error_with(include("own.xml", "/policy/*")), HasSubstr("has nothing at /policy/*"));
  EXPECT_THAT(error_with(include("own.xml", "id('a')")), HasSubstr("only paths of names"));
  EXPECT_THAT(error_with("<xi:include parse=\"text\" href=\"own.xml\"/>"),
              HasSubstr("only \"xml\" is understood"));
  EXPECT_THAT(error_with("<xi:include/>"), HasSubstr("'href' is missing"));
  EXPECT_THAT(error_with("<xj:include href=\"own.xml\"/>"), HasSubstr("XInclude\" is missing"));
  write("loop.xml", "<profile xmlns:xi=\"http://www.w3.org/2001/XInclude\">" +
                        include("loop.xml", "/profile/*") + "</profile>");
  EXPECT_THAT(error_with(include("loop.xml", "/profile/*")), HasSubstr("includes itself"));
}

TEST(Documents, HaveTheirDomains) {
  EXPECT_EQ(domains_in(to_governance_xml(7)), (std::vector<DomainRange>{{7, 7}}));
  EXPECT_EQ(domains_in(to_permissions_xml("/a", nullptr, 3, kNow, kNow + kDay)),
            (std::vector<DomainRange>{{3, 3}}));
  const auto several = domains_in(
      "<dds><permissions><grant><deny_rule><domains><id>9</id></domains></deny_rule><allow_rule>"
      "<domains><id> 0 </id><id_range><min>5</min><max>7</max></id_range><id_range><min>100</min>"
      "</id_range></domains></allow_rule></grant></permissions></dds>");
  EXPECT_EQ(to_string(several), "0, 5 to 7, 100 and above");
  EXPECT_EQ(to_string(std::vector<DomainRange>{}), "none");
  EXPECT_THROW((void)domains_in("<d><allow_rule><domains><id>x</id></domains></allow_rule></d>"),
               KeystoreError);
}

TEST(Policy, PermissionsGrantNoMoreThanThePolicy) {
  EnclavePolicy policy;
  policy.publish = {"/weld"};
  policy.request = {"/get"};
  const auto xml = to_permissions_xml("/a", &policy, 7, kNow, kNow + kDay);
  EXPECT_THAT(xml, HasSubstr("<subject_name>CN=/a</subject_name>"));
  EXPECT_THAT(xml, HasSubstr("<id>7</id>"));
  EXPECT_THAT(xml, HasSubstr("<topic>rt/weld</topic>"));
  EXPECT_THAT(xml, HasSubstr("<topic>rq/getRequest</topic>"));
  EXPECT_THAT(xml, HasSubstr("<topic>rr/getReply</topic>"));
  EXPECT_THAT(xml, Not(HasSubstr("<topic>*")));
  EXPECT_THAT(xml, HasSubstr("<default>DENY</default>"));
}

TEST(Policy, PermissionsGrantTheTopicsInEveryPartition) {
  EXPECT_TRUE(grants_any_partition(to_permissions_xml("/a", nullptr, 7, kNow, kNow + kDay)));
  EXPECT_FALSE(grants_any_partition("<publish><topics><topic>*</topic></topics></publish>"));
  EXPECT_FALSE(grants_any_partition("<partitions><partition>a</partition></partitions>"));
}

}  // namespace
}  // namespace pipescout::keystore
