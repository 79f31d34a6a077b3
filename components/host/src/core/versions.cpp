// SPDX-License-Identifier: Apache-2.0
#include "core/versions.hpp"

#include <sys/utsname.h>

#include <fstream>
#include <iterator>

#include "pipescout/dds/dds_transport.hpp"
#include "pipescout/runtime/parameter_value.hpp"

namespace pipescout::host {
namespace {

namespace fs = std::filesystem;

std::string system_text() {
  utsname names{};
  if (uname(&names) != 0) {
    return "unknown";
  }
  return std::string(names.sysname) + " " + names.release + " " + names.machine;
}

/// Text between the first <version> and its end.
std::string version_of(const std::string& package, const std::vector<fs::path>& prefixes) {
  for (const fs::path& prefix : prefixes) {
    std::ifstream stream(prefix / "share" / package / "package.xml");
    const std::string xml{std::istreambuf_iterator<char>(stream), {}};
    constexpr std::string_view kBegin = "<version>";
    const auto begin = xml.find(kBegin);
    const auto end = xml.find("</version>", begin == std::string::npos ? 0 : begin);
    if (begin != std::string::npos && end != std::string::npos) {
      return xml.substr(begin + kBegin.size(), end - begin - kBegin.size());
    }
  }
  return "unknown";
}

}  // namespace

std::string versions_yaml(const std::set<std::string>& packages,
                          const std::vector<fs::path>& prefixes) {
  std::string out;
  const auto add = [&out](const std::string& name, const std::string& value) {
    out += name + ": " + to_yaml(ParameterValue(value)) + "\n";
  };
  add("pipescout", PIPESCOUT_VERSION);
  add("revision", PIPESCOUT_REVISION);
#ifdef __clang__
  add("compiler", __VERSION__);
#else
  add("compiler", std::string("GCC ") + __VERSION__);
#endif
  add("fast_dds", fast_dds_version());
  add("system", system_text());
  out += packages.empty() ? "packages: {}\n" : "packages:\n";
  for (const std::string& package : packages) {
    add("  " + package, version_of(package, prefixes));
  }
  return out;
}

}  // namespace pipescout::host
