// SPDX-License-Identifier: Apache-2.0
#include "pipescout/idl/installed_prefixes.hpp"

#include <algorithm>
#include <cstdlib>
#include <set>
#include <sstream>
#include <string>
#include <system_error>

namespace pipescout {
namespace {

namespace fs = std::filesystem;

void add_prefixes_of(const char* variable, std::vector<fs::path>& prefixes) {
  const char* value = std::getenv(variable);
  if (value == nullptr) {
    return;
  }
  std::istringstream list(value);
  for (std::string prefix; std::getline(list, prefix, ':');) {
    if (!prefix.empty()) {
      prefixes.emplace_back(prefix);
    }
  }
}

/// The prefix whose bin/ or lib/<package>/ holds the running executable, and in the isolated layout
/// the prefixes beside it.
void add_prefixes_of_executable(std::vector<fs::path>& prefixes) {
  std::error_code error;
  const fs::path folder = fs::read_symlink("/proc/self/exe", error).parent_path();
  if (error) {
    return;
  }
  fs::path prefix;
  if (folder.filename() == "bin") {
    prefix = folder.parent_path();
  } else if (folder.parent_path().filename() == "lib") {
    prefix = folder.parent_path().parent_path();
  } else {
    return;
  }
  prefixes.push_back(prefix);
  // A prefix of one package bears its name, and the package's manifest stands in it.
  const auto is_of_one_package = [&error](const fs::path& folder_of_package) {
    return fs::exists(folder_of_package / "share" / folder_of_package.filename() / "package.xml",
                      error);
  };
  if (!is_of_one_package(prefix)) {
    return;
  }
  std::vector<fs::path> siblings;
  for (fs::directory_iterator entry(prefix.parent_path(), error), end; !error && entry != end;
       entry.increment(error)) {
    if (entry->path() != prefix && is_of_one_package(entry->path())) {
      siblings.push_back(entry->path());
    }
  }
  std::sort(siblings.begin(), siblings.end());
  prefixes.insert(prefixes.end(), siblings.begin(), siblings.end());
}

}  // namespace

std::vector<fs::path> without_repetitions(const std::vector<fs::path>& folders) {
  std::vector<fs::path> result;
  std::set<fs::path> seen;
  for (const fs::path& folder : folders) {
    std::error_code error;
    const fs::path canonical = fs::canonical(folder, error);
    if (!error && seen.insert(canonical).second) {
      result.push_back(canonical);
    }
  }
  return result;
}

std::vector<fs::path> installed_prefixes() {
  std::vector<fs::path> prefixes;
  add_prefixes_of("AMENT_PREFIX_PATH", prefixes);
  add_prefixes_of("CMAKE_PREFIX_PATH", prefixes);
  add_prefixes_of_executable(prefixes);
  return without_repetitions(prefixes);
}

}  // namespace pipescout
