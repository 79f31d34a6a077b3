// SPDX-License-Identifier: Apache-2.0
// Receives on the UDP port that is the first argument, with the shortcut through shared memory.
// Prints a line when it listens and one for each datagram; runs until it is killed.
#include <fastdds/rtps/transport/TransportInterface.h>
#include <fastdds/rtps/transport/TransportReceiverInterface.h>
#include <fastrtps/utils/IPLocator.h>
#include <unistd.h>

#include <cstdlib>
#include <iostream>
#include <memory>
#include <string>

#include "shortcut_transport.hpp"

namespace {

namespace rtps = eprosima::fastdds::rtps;

class Printer final : public rtps::TransportReceiverInterface {
 public:
  void OnDataReceived(const std::uint8_t* data, std::uint32_t size, const rtps::Locator&,
                      const rtps::Locator&) override {
    std::cout << std::string(data, data + size) << std::endl;
  }
};

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    return EXIT_FAILURE;
  }
  pipescout::dds::ShortcutTransportDescriptor descriptor;
  descriptor.interfaceWhiteList.emplace_back("127.0.0.1");
  descriptor.shared_memory.segment_size(std::uint32_t{1} << 20);
  const std::unique_ptr<rtps::TransportInterface> transport(descriptor.create_transport());
  rtps::Locator locator;
  eprosima::fastrtps::rtps::IPLocator::createLocator(
      LOCATOR_KIND_UDPv4, "127.0.0.1", static_cast<std::uint32_t>(std::stoul(argv[1])), locator);
  Printer printer;
  if (!transport->init() || !transport->OpenInputChannel(locator, &printer, 65500)) {
    return EXIT_FAILURE;
  }
  std::cout << "listening" << std::endl;
  while (true) {
    pause();
  }
}
