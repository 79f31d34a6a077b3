// SPDX-License-Identifier: Apache-2.0
#include "shortcut_transport.hpp"

#include <fastdds/rtps/network/SenderResource.h>
#include <fastdds/rtps/transport/TransportInterface.h>
#include <fastrtps/config.h>
#include <fastrtps/utils/IPLocator.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <fastdds/rtps/common/LocatorList.hpp>

#include <algorithm>
#include <chrono>
#include <memory>
#include <string>
#include <thread>
#include <utility>

namespace pipescout::dds {
namespace {

namespace rtps = eprosima::fastdds::rtps;
using eprosima::fastrtps::rtps::IPLocator;
using eprosima::fastrtps::rtps::LocatorSelector;
using eprosima::fastrtps::rtps::LocatorsIterator;
using eprosima::fastrtps::rtps::PortParameters;
using eprosima::fastrtps::rtps::PropertyPolicy;
using rtps::Locator;
using rtps::LocatorList;
using rtps::Locators;
using rtps::SendResourceList;
using rtps::TransportInterface;

// A probe of a sender can hold the lock of a new port for a moment.
constexpr int kAttemptsToListen = 20;
constexpr auto kPauseBetweenAttempts = std::chrono::milliseconds(1);

constexpr std::uint32_t kPortBits = 16;

// More than a process tells others of its endpoints.
constexpr std::uint32_t kBytesBetweenHeartbeats = 64 * 1024 * 1024;

// The part of a shared memory port that does not come from the UDP port: never 0.
std::uint32_t scope_of_ports() {
  struct stat network {};
  if (stat("/proc/self/ns/net", &network) != 0) {
    network.st_ino = 0;
  }
  // FNV-1a over what tells the scopes apart.
  std::uint32_t hash = 2166136261U;
  for (const std::uint64_t part : {std::uint64_t{network.st_ino}, std::uint64_t{geteuid()},
                                   std::uint64_t{FASTRTPS_VERSION_MAJOR} << 32 |
                                       FASTRTPS_VERSION_MINOR << 16 | FASTRTPS_VERSION_MICRO}) {
    for (unsigned shift = 0; shift < 64; shift += 8) {
      hash = (hash ^ static_cast<std::uint8_t>(part >> shift)) * 16777619U;
    }
  }
  return 1 + (hash ^ hash >> kPortBits) % 0xFFFF;
}

// Of a port, as Fast DDS names them.
std::filesystem::path memory_file(const std::filesystem::path& folder, std::uint32_t port) {
  return folder / ("fastrtps_port" + std::to_string(port));
}
std::filesystem::path lock_file(const std::filesystem::path& folder, std::uint32_t port) {
  return folder / ("fastrtps_port" + std::to_string(port) + "_el");
}

class ShortcutTransport;

/// Sends over the sockets of the UDP transport, or over shared memory.
class ShortcutSender final : public eprosima::fastrtps::rtps::SenderResource {
 public:
  explicit ShortcutSender(ShortcutTransport& transport);

  bool open(const Locator& locator);
  void add_locators_to_list(LocatorList& locators) const override {
    for (const auto& sender : udp_) {
      sender->add_locators_to_list(locators);
    }
  }

 private:
  friend class ShortcutTransport;

  bool send(const std::uint8_t* data, std::uint32_t size, LocatorsIterator& destination,
            const LocatorsIterator& end, const std::chrono::steady_clock::time_point& limit);
  static bool send_to(const SendResourceList& senders, const LocatorList& locators,
                      const std::uint8_t* data, std::uint32_t size,
                      const std::chrono::steady_clock::time_point& limit);

  ShortcutTransport& transport_;
  SendResourceList udp_;
  SendResourceList shared_memory_;
  ReaderProbe probe_;
  // Of the message that is being sent; members only to keep their memory.
  LocatorList over_udp_;
  LocatorList over_shared_memory_;
};

class ShortcutTransport final : public TransportInterface {
 public:
  explicit ShortcutTransport(const ShortcutTransportDescriptor& descriptor)
      : TransportInterface(LOCATOR_KIND_UDPv4),
        descriptor_(descriptor),
        udp_(descriptor.UDPv4TransportDescriptor::create_transport()),
        shared_memory_(descriptor.has_shared_memory ? descriptor.shared_memory.create_transport()
                                                    : nullptr),
        warnings_(descriptor.warnings) {}

  bool init(const PropertyPolicy* properties) override {
    if (!udp_->init(properties)) {
      return false;
    }
    if (shared_memory_ == nullptr) {
      return true;
    }
    if (!shared_memory_->init(properties)) {
      shared_memory_ = nullptr;
      warnings_->add("no shared memory in " + std::string(kSharedMemoryFolder) +
                     ": messages to other processes of this machine are sent over UDP");
      return true;
    }
    LocatorList example;
    shared_memory_->getDefaultUnicastLocators(example, 0);
    shared_memory_locator_ = *example.begin();
    return true;
  }

  bool OpenInputChannel(const Locator& locator, rtps::TransportReceiverInterface* receiver,
                        std::uint32_t max_message_bytes) override {
    if (!udp_->OpenInputChannel(locator, receiver, max_message_bytes)) {
      return false;
    }
    if (shared_memory_ != nullptr && !IPLocator::isMulticast(locator)) {
      listen(shortcut_to(locator), receiver, max_message_bytes);
    }
    return true;
  }

  bool CloseInputChannel(const Locator& locator) override {
    if (shared_memory_ != nullptr && !IPLocator::isMulticast(locator)) {
      shared_memory_->CloseInputChannel(shortcut_to(locator));
    }
    return udp_->CloseInputChannel(locator);
  }

  bool OpenOutputChannel(SendResourceList& senders, const Locator& locator) override {
    if (!IsLocatorSupported(locator)) {
      return false;
    }
    for (const auto& sender : senders) {
      auto* known = dynamic_cast<ShortcutSender*>(sender.get());
      if (known != nullptr && &known->transport_ == this) {
        return known->open(locator);
      }
    }
    auto sender = std::make_unique<ShortcutSender>(*this);
    const bool opened = sender->open(locator);
    if (opened) {
      senders.push_back(std::move(sender));
    }
    return opened;
  }

  // All that is said about locators is said by UDP.
  bool IsInputChannelOpen(const Locator& locator) const override {
    return udp_->IsInputChannelOpen(locator);
  }
  bool IsLocatorSupported(const Locator& locator) const override {
    return udp_->IsLocatorSupported(locator);
  }
  bool is_locator_allowed(const Locator& locator) const override {
    return udp_->is_locator_allowed(locator);
  }
  Locator RemoteToMainLocal(const Locator& remote) const override {
    return udp_->RemoteToMainLocal(remote);
  }
  bool transform_remote_locator(const Locator& remote, Locator& result) const override {
    return udp_->transform_remote_locator(remote, result);
  }
  bool DoInputLocatorsMatch(const Locator& left, const Locator& right) const override {
    return udp_->DoInputLocatorsMatch(left, right);
  }
  LocatorList NormalizeLocator(const Locator& locator) override {
    return udp_->NormalizeLocator(locator);
  }
  void select_locators(LocatorSelector& selector) const override {
    udp_->select_locators(selector);
  }
  bool is_local_locator(const Locator& locator) const override {
    return udp_->is_local_locator(locator);
  }
  // Small datagrams are for a network that loses them: there these heartbeats are what brings the
  // rest soon.
  rtps::TransportDescriptorInterface* get_configuration() override {
    const bool loses = descriptor_.maxMessageSize < rtps::s_maximumMessageSize;
    return loses ? udp_->get_configuration() : &descriptor_;
  }
  void AddDefaultOutputLocator(LocatorList& locators) override {
    udp_->AddDefaultOutputLocator(locators);
  }
  bool getDefaultMetatrafficMulticastLocators(LocatorList& locators,
                                              std::uint32_t port) const override {
    return udp_->getDefaultMetatrafficMulticastLocators(locators, port);
  }
  bool getDefaultMetatrafficUnicastLocators(LocatorList& locators,
                                            std::uint32_t port) const override {
    return udp_->getDefaultMetatrafficUnicastLocators(locators, port);
  }
  bool getDefaultUnicastLocators(LocatorList& locators, std::uint32_t port) const override {
    return udp_->getDefaultUnicastLocators(locators, port);
  }
  bool fillMetatrafficMulticastLocator(Locator& locator, std::uint32_t port) const override {
    return udp_->fillMetatrafficMulticastLocator(locator, port);
  }
  bool fillMetatrafficUnicastLocator(Locator& locator, std::uint32_t port) const override {
    return udp_->fillMetatrafficUnicastLocator(locator, port);
  }
  bool configureInitialPeerLocator(Locator& locator, const PortParameters& ports,
                                   std::uint32_t domain, LocatorList& list) const override {
    return udp_->configureInitialPeerLocator(locator, ports, domain, list);
  }
  bool fillUnicastLocator(Locator& locator, std::uint32_t port) const override {
    return udp_->fillUnicastLocator(locator, port);
  }
  // Others may send larger datagrams than this process does (NetworkProfile).
  std::uint32_t max_recv_buffer_size() const override { return rtps::s_maximumMessageSize; }
  void shutdown() override {
    udp_->shutdown();
    if (shared_memory_ != nullptr) {
      shared_memory_->shutdown();
    }
  }
  void update_network_interfaces() override { udp_->update_network_interfaces(); }

 private:
  friend class ShortcutSender;

  [[nodiscard]] Locator shortcut_to(const Locator& locator) const {
    Locator result = shared_memory_locator_;
    result.port = shared_memory_port(IPLocator::getPhysicalPort(locator));
    return result;
  }

  void listen(const Locator& shortcut, rtps::TransportReceiverInterface* receiver,
              std::uint32_t max_message_bytes) {
    for (int attempt = 0; attempt < kAttemptsToListen; ++attempt) {
      if (attempt > 0) {
        std::this_thread::sleep_for(kPauseBetweenAttempts);
      }
      if (shared_memory_->OpenInputChannel(shortcut, receiver, max_message_bytes)) {
        if (note_memory(shortcut.port)) {
          return;
        }
        break;
      }
    }
    warnings_->add("cannot listen on shared memory port " + std::to_string(shortcut.port) + " of " +
                   kSharedMemoryFolder +
                   ": messages from other processes of this machine are received over UDP");
  }

  ShortcutTransportDescriptor descriptor_;
  std::unique_ptr<TransportInterface> udp_;
  std::unique_ptr<TransportInterface> shared_memory_;  // null: there is no room for it
  Locator shared_memory_locator_;                      // of this machine, without a port
  const std::shared_ptr<Warnings> warnings_;
};

ShortcutSender::ShortcutSender(ShortcutTransport& transport)
    : SenderResource(transport.kind()), transport_(transport) {
  send_lambda_ = [this](const std::uint8_t* data, std::uint32_t size, LocatorsIterator* begin,
                        LocatorsIterator* end, const std::chrono::steady_clock::time_point& limit) {
    return send(data, size, *begin, *end, limit);
  };
}

bool ShortcutSender::open(const Locator& locator) {
  if (transport_.shared_memory_ != nullptr && shared_memory_.empty()) {
    transport_.shared_memory_->OpenOutputChannel(shared_memory_, transport_.shared_memory_locator_);
  }
  return transport_.udp_->OpenOutputChannel(udp_, locator);
}

bool ShortcutSender::send(const std::uint8_t* data, std::uint32_t size,
                          LocatorsIterator& destination, const LocatorsIterator& end,
                          const std::chrono::steady_clock::time_point& limit) {
  over_udp_.clear();
  over_shared_memory_.clear();
  for (; destination != end; ++destination) {
    const Locator& locator = *destination;
    if (!transport_.IsLocatorSupported(locator)) {
      continue;
    }
    if (!shared_memory_.empty() && !IPLocator::isMulticast(locator) &&
        transport_.is_local_locator(locator)) {
      const Locator shortcut = transport_.shortcut_to(locator);
      if (probe_.has_reader(shortcut.port)) {
        over_shared_memory_.push_back(shortcut);  // once, however many addresses the process has
        continue;
      }
    }
    over_udp_.push_back(locator);
  }
  const bool by_udp = send_to(udp_, over_udp_, data, size, limit);
  const bool by_memory = send_to(shared_memory_, over_shared_memory_, data, size, limit);
  return by_udp && by_memory;
}

bool ShortcutSender::send_to(const SendResourceList& senders, const LocatorList& locators,
                             const std::uint8_t* data, std::uint32_t size,
                             const std::chrono::steady_clock::time_point& limit) {
  bool sent = true;
  if (!locators.empty()) {
    for (const auto& sender : senders) {
      Locators begin(locators.begin());
      Locators end(locators.end());
      sent &= sender->send(data, size, &begin, &end, limit);
    }
  }
  return sent;
}

}  // namespace

rtps::TransportInterface* ShortcutTransportDescriptor::create_transport() const {
  return new ShortcutTransport(*this);
}

std::uint32_t ShortcutTransportDescriptor::min_send_buffer_size() const {
  return kBytesBetweenHeartbeats;
}

std::uint32_t shared_memory_port(std::uint16_t udp_port) {
  static const std::uint32_t scope = scope_of_ports();
  return scope << kPortBits | udp_port;
}

bool note_memory(std::uint32_t port, const std::filesystem::path& folder) {
  struct stat memory {};
  if (stat(memory_file(folder, port).c_str(), &memory) != 0) {
    return false;
  }
  const int lock = open(lock_file(folder, port).c_str(), O_WRONLY | O_CLOEXEC);
  if (lock < 0) {
    return false;
  }
  const bool noted = pwrite(lock, &memory.st_ino, sizeof memory.st_ino, 0) ==
                     static_cast<ssize_t>(sizeof memory.st_ino);
  close(lock);
  return noted;
}

ReaderProbe::ReaderProbe(std::filesystem::path folder) : folder_(std::move(folder)) {}

ReaderProbe::~ReaderProbe() {
  for (const Port& port : open_) {
    close(port.lock);
    close(port.memory);
  }
}

int ReaderProbe::open_memory(std::uint32_t port, int lock) {
  ino_t noted = 0;
  if (pread(lock, &noted, sizeof noted, 0) != sizeof noted) {
    return -1;
  }
  const int memory = open(memory_file(folder_, port).c_str(), O_RDONLY | O_CLOEXEC);
  struct stat found {};
  if (memory >= 0 && fstat(memory, &found) == 0 && found.st_ino == noted &&
      first_memory_.try_emplace(port, noted).first->second == noted) {
    return memory;
  }
  if (memory >= 0) {
    close(memory);
  }
  return -1;
}

bool ReaderProbe::has_reader(std::uint32_t port) {
  const auto is_in_place = [](int descriptor) {
    struct stat memory {};
    return fstat(descriptor, &memory) == 0 && memory.st_nlink > 0;
  };
  const auto known = std::find_if(open_.begin(), open_.end(),
                                  [port](const Port& each) { return each.number == port; });
  if (known != open_.end()) {
    if (is_locked(known->lock) && is_in_place(known->memory)) {
      return true;
    }
    // The reader or its memory is gone; new ones have other files.
    close(known->lock);
    close(known->memory);
    open_.erase(known);
  }
  const int lock = open(lock_file(folder_, port).c_str(), O_RDONLY | O_CLOEXEC);
  if (lock < 0) {
    return false;
  }
  const int memory = is_locked(lock) ? open_memory(port, lock) : -1;
  if (memory < 0) {
    close(lock);
    return false;
  }
  open_.push_back({port, lock, memory});
  return true;
}

}  // namespace pipescout::dds
