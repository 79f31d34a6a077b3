// SPDX-License-Identifier: Apache-2.0
// The other end in a process of its own: reads lines, answers each with one line.
//   conformance_peer DOMAIN
#include <exception>
#include <iostream>
#include <string>

#include "peer_end.hpp"
#include "pipescout/dds/dds_transport.hpp"

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: conformance_peer DOMAIN\n";
    return 2;
  }
  try {
    const auto domain = static_cast<std::uint32_t>(std::stoul(argv[1]));
    pipescout::conformance::PeerEnd end(pipescout::Context::create(
        pipescout::create_dds_transport({.domain_id = domain, .localhost_only = true})));
    std::cout << "ready" << std::endl;
    for (std::string line; std::getline(std::cin, line);) {
      std::cout << end.execute(line) << std::endl;
    }
  } catch (const std::exception& error) {
    std::cerr << "conformance_peer: " << error.what() << '\n';
    return 1;
  }
  return 0;
}
