// SPDX-License-Identifier: Apache-2.0
// Secured participants, and strangers that try to listen to them and to talk to them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <optional>
#include <string>

#include "dds_profile.hpp"
#include "secured.hpp"

namespace pipescout::security {
namespace {

using ::pipescout::testing::content;
using ::testing::AllOf;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

constexpr const char* kStranger = "stranger";

TEST_F(Secured, ParticipantsOfOneKeystoreTalk) {
  Peer first(options(keystore_, "/robot_1"));
  Peer second(options(keystore_, "/robot_2"));
  ASSERT_TRUE(first.written.await_matched(1));
  ASSERT_TRUE(second.read.await_matched(1));
  first.say("hello");
  ASSERT_TRUE(second.read.await_messages(1));
  EXPECT_EQ(second.read.text(0), "hello");
}

/// Whether Fast DDS's segments of shared memory hold the text.
bool is_in_shared_memory(const std::string& text) {
  for (const auto& entry : fs::directory_iterator("/dev/shm")) {
    const std::string name = entry.path().filename().string();
    // Segments have a name of 16 digits; the others are ports and locks.
    constexpr std::size_t kSegmentName = 9 + 16;
    if (name.starts_with("fastrtps_") && name.size() == kSegmentName &&
        content(entry.path()).find(text) != std::string::npos) {
      return true;
    }
  }
  return false;
}

TEST_F(Secured, SharedMemoryHoldsNoPlainText) {
  for (const bool secured : {false, true}) {
    const std::string marker = "marker of " + std::to_string(getpid()) + std::to_string(secured);
    const auto plain = dds_test::local_options();
    Peer first(secured ? options(keystore_, "/robot_1") : plain);
    Peer second(secured ? options(keystore_, "/robot_2") : plain);
    ASSERT_TRUE(first.written.await_matched(1));
    ASSERT_TRUE(second.read.await_matched(1));
    // Long enough that what follows does not cover all of it.
    std::string text;
    for (int times = 0; times < 100; ++times) {
      text += marker;
    }
    first.say(text);
    ASSERT_TRUE(second.read.await_messages(1));
    // Plain text is found, so that it would be.
    EXPECT_EQ(is_in_shared_memory(marker), !secured);
  }
}

/// A stranger who has files of the robots.
class WithStranger : public Secured {
 protected:
  /// A file of one enclave in place of that of another.
  static void put(const fs::path& from, const fs::path& to) {
    const std::string bytes = content(from);
    fs::remove(to);
    std::ofstream(to, std::ios::binary) << bytes;
    fs::permissions(to, fs::perms::owner_read | fs::perms::owner_write);
  }
  /// All files of an enclave, for a keystore of a stranger.
  fs::path stolen(const std::string& enclave) {
    const fs::path folder = folder_.path() / "stranger/enclaves/x";
    fs::remove_all(folder.parent_path());
    fs::create_directories(folder);
    for (const auto& entry : fs::directory_iterator(keystore_ / "enclaves" / enclave)) {
      put(entry.path(), folder / entry.path().filename());
    }
    return folder;
  }
  DdsOptions stranger() { return options(folder_.path() / "stranger", "/x"); }
};

/// Two robots that talk; strangers come one after the other.
class Strangers : public WithStranger {
 protected:
  Strangers() {
    add(keystore_, "/robot_4");
    keystore::revoke(keystore_, "/robot_4", std::time(nullptr));
    first_.emplace(options(keystore_, "/robot_1"));
    second_.emplace(options(keystore_, "/robot_2"));
    EXPECT_TRUE(first_->written.await_matched(1));
    EXPECT_TRUE(second_->written.await_matched(1));
  }

  /// By the time that a robot which came later than the stranger has been heard, and has heard,
  /// the stranger has had its chance.
  void expect_shut_out(const std::string& kind, const DdsOptions& options) {
    ++tries_;
    std::optional<Peer> stranger;
    try {
      stranger.emplace(options);
    } catch (const TransportError& error) {
      std::cout << kind << ": refused: " << error.what() << "\n";
      return;
    }
    {
      Peer control(this->options(keystore_, "/robot_3"));
      ASSERT_TRUE(control.written.await_matched(2)) << kind;
      ASSERT_TRUE(control.read.await_matched(2)) << kind;
      ASSERT_TRUE(first_->written.await_matched(2)) << kind;
      stranger->say(kStranger);
      first_->say("secret");
      ASSERT_TRUE(control.read.await_messages(1)) << kind;
      control.say("control");
      ++controls_;
      ASSERT_TRUE(second_->read.monitor.await([&] {
        return std::ranges::count_if(second_->read.messages, [](const auto& received) {
                 return static_cast<const std_msgs::msg::String*>(received.message.get())->data ==
                        "control";
               }) == controls_;
      })) << kind;
    }
    reads_ += stranger->read.monitor.copy(stranger->read.messages).size();
    EXPECT_EQ(reads_, 0U) << kind;
    EXPECT_EQ(first_->heard(kStranger) + second_->heard(kStranger), 0U) << kind;
    std::cout << kind << ": shut out\n";
  }

  /// Of each kind one.
  void try_all() {
    expect_shut_out("no enclave", dds_test::local_options());
    expect_shut_out("other authorities", options(other_, "/robot_1"));

    fs::path folder = stolen("robot_1");
    for (const char* const file : {"cert.pem", "key.pem", "identity_ca.cert.pem", "crl.pem"}) {
      put(other_ / "enclaves/robot_1" / file, folder / file);
    }
    expect_shut_out("identity of its own authority, permissions of a robot", stranger());

    folder = stolen("robot_3");
    for (const char* const file :
         {"permissions_ca.cert.pem", "permissions.p7s", "governance.p7s"}) {
      put(other_ / "enclaves/robot_3" / file, folder / file);
    }
    expect_shut_out("a robot that signs its own permissions", stranger());

    folder = stolen("robot_4");
    expect_shut_out("revoked", stranger());
    fs::remove(folder / "crl.pem");
    expect_shut_out("revoked, and does not know", stranger());

    folder = stolen("robot_3");
    put(keystore_ / "enclaves/robot_1/permissions.p7s", folder / "permissions.p7s");
    expect_shut_out("permissions of another robot", stranger());

    folder = stolen("robot_3");
    std::string governance = content(folder / "governance.p7s");
    governance.replace(governance.find("_participants>false"), 19, "_participants>true ");
    std::ofstream(folder / "governance.p7s") << governance;
    expect_shut_out("tampered governance", stranger());

    expect_shut_out("expired", options(keystore_, "/robot_5"));
    expect_shut_out("a robot without a right to the topic", options(keystore_, "/robot_6"));
  }

  const fs::path other_ = folder_.path() / "other";
  std::optional<Peer> first_;
  std::optional<Peer> second_;
  std::ptrdiff_t controls_ = 0;
  std::size_t reads_ = 0;
  int tries_ = 0;
};

TEST_F(Strangers, ReadAndWriteNothing) {
  make_keystore(other_);
  add(other_, "/robot_1");
  add(other_, "/robot_3");
  add(keystore_, "/robot_5", std::time(nullptr) - 400 * kDay);
  keystore::EnclavePolicy elsewhere;
  elsewhere.publish = {"/weather"};
  keystore::create_enclave(keystore_, {.name = "/robot_6", .domain = domain(), .policy = elsewhere},
                           std::time(nullptr));
  try_all();
  try_all();
  const std::size_t writes = first_->heard(kStranger) + second_->heard(kStranger);
  std::cout << "stranger_tries " << tries_ << "\nstranger_reads " << reads_ << "\nstranger_writes "
            << writes << "\n";
}

using SecurityFiles = WithStranger;

TEST_F(SecurityFiles, MissingOnesAreNamed) {
  EXPECT_THAT(error_of(options(keystore_, "/nobody")), HasSubstr("no enclave '/nobody'"));
  EXPECT_THAT(error_of(options("", "/robot_1")), HasSubstr("ROS_SECURITY_KEYSTORE"));
  for (const char* const file : {"cert.pem", "key.pem", "permissions.p7s", "governance.p7s",
                                 "identity_ca.cert.pem", "permissions_ca.cert.pem"}) {
    fs::remove(stolen("robot_1") / file);
    EXPECT_THAT(error_of(stranger()), HasSubstr(std::string("/x/") + file));
  }
}

TEST_F(SecurityFiles, PermissiveRunsWithoutSecurityOnlyWhenFilesAreMissing) {
  auto permissive = options(keystore_, "/nobody");
  permissive.security.enforce = false;
  const auto transport = create_dds_transport(permissive);
  EXPECT_THAT(transport->warnings(), ::testing::Contains(HasSubstr("WITHOUT security")));
}

// SROS 2 makes them so.
TEST_F(SecurityFiles, APrivateKeyThatOthersCanReadIsAWarningUnlessKeysAreStrict) {
  fs::permissions(keystore_ / "enclaves/robot_1/key.pem", fs::perms::others_read,
                  fs::perm_options::add);
  auto robot = options(keystore_, "/robot_1");
  const auto transport = create_dds_transport(robot);
  EXPECT_THAT(transport->warnings(),
              ::testing::Contains(HasSubstr("robot_1/key.pem: others than its owner")));
  robot.security.strict_keys = true;
  EXPECT_THAT(error_of(robot), AllOf(HasSubstr("robot_1/key.pem: others than its owner"),
                                     HasSubstr("PIPESCOUT_STRICT_KEYS")));
}

TEST_F(SecurityFiles, AnotherDomainIsNamed) {
  keystore::create_enclave(keystore_, {.name = "/elsewhere", .domain = domain() + 1},
                           std::time(nullptr));
  EXPECT_THAT(error_of(options(keystore_, "/elsewhere")),
              HasSubstr("elsewhere/permissions.p7s: is for domain " + std::to_string(domain() + 1) +
                        ", and this process joins domain " + std::to_string(domain()) +
                        " (ROS_DOMAIN_ID)"));
  auto robot = options(keystore_, "/robot_1");
  robot.domain_id = domain() + 1;
  EXPECT_THAT(error_of(robot), HasSubstr("governance.p7s: is for domain"));
}

TEST_F(SecurityFiles, ExpiredAndFutureOnesAreNamedWithTheDate) {
  const std::time_t now = std::time(nullptr);
  add(keystore_, "/old", now - 400 * kDay);
  EXPECT_THAT(error_of(options(keystore_, "/old")), HasSubstr("old/cert.pem: expired on 20"));
  add(keystore_, "/future", now + 10 * kDay);
  EXPECT_THAT(error_of(options(keystore_, "/future")), HasSubstr("cert.pem: not valid before 20"));
  const fs::path folder = stolen("robot_1");
  const fs::path old = keystore_ / "enclaves/old";
  put(old / "permissions.p7s", folder / "permissions.p7s");
  EXPECT_THAT(error_of(stranger()), HasSubstr("permissions.p7s: expired on 20"));
}

TEST_F(SecurityFiles, UnusableOnesAreNamed) {
  const auto spoilt = [&](const char* file, const std::string& with) {
    std::ofstream(stolen("robot_1") / file) << with;
    return error_of(stranger());
  };
  EXPECT_THAT(spoilt("cert.pem", "x"), HasSubstr("cert.pem: is no certificate"));
  EXPECT_THAT(spoilt("key.pem", "x"), HasSubstr("key.pem: is no private key of cert.pem"));
  EXPECT_THAT(spoilt("governance.p7s", ""), HasSubstr("governance.p7s: is empty"));
  EXPECT_THAT(spoilt("permissions.p7s", "x"), HasSubstr("permissions.p7s: not signed"));
  EXPECT_THAT(spoilt("crl.pem", "x"), HasSubstr("crl.pem: is no certificate revocation list"));
}

/// Who runs the tests may be root, for whom permissions hide nothing; a folder cannot be read
/// either.
TEST_F(SecurityFiles, UnreadableOnesAreNamed) {
  for (const char* const file : {"cert.pem", "key.pem", "permissions.p7s", "governance.p7s",
                                 "identity_ca.cert.pem", "permissions_ca.cert.pem"}) {
    const fs::path unreadable = stolen("robot_1") / file;
    fs::remove(unreadable);
    fs::create_directory(unreadable);
    fs::permissions(unreadable, fs::perms::owner_all);
    EXPECT_THAT(error_of(stranger()), AllOf(HasSubstr(std::string("/x/") + file),
                                            HasSubstr("cannot be read: Is a directory")));
  }
}

TEST_F(SecurityFiles, RevokedRobotDoesNotStart) {
  keystore::revoke(keystore_, "/robot_1", std::time(nullptr));
  EXPECT_THAT(error_of(options(keystore_, "/robot_1")), HasSubstr("was revoked on 20"));
}

TEST_F(SecurityFiles, OverrideCountsBeforeTheEnclave) {
  auto overridden = options(keystore_, "/robot_1");
  overridden.security.enclave_override = "/nobody";
  EXPECT_THAT(error_of(overridden), HasSubstr("no enclave '/nobody'"));
}

TEST_F(SecurityFiles, RunningProcessHearsOfARevocation) {
  dds_test::Monitor monitor;
  bool heard = false;
  auto watching = options(keystore_, "/robot_1");
  watching.security.on_revocations_changed = [&] { monitor.change([&] { heard = true; }); };
  const auto transport = create_dds_transport(watching);
  keystore::revoke(keystore_, "/robot_2", std::time(nullptr));
  EXPECT_TRUE(monitor.await([&] { return heard; }));
}

}  // namespace
}  // namespace pipescout::security
