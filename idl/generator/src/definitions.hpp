// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "model.hpp"

namespace pipescout::generator {

/// A structure of which every byte in memory, and in CDR behind the alignment of the first, belongs
/// to a number of the same size: its bytes are copied at once, and those of an array of it too.
struct UniformLayout {
  std::size_t number_size = 0;
  std::size_t count = 0;
};

/// What one file defines as the interface of that name ("std_srvs/srv/Trigger"), of an action with
/// the structures that ROS 2 derives. The types of its fields need not exist. Throws
/// DefinitionError, std::invalid_argument when the file cannot be read.
[[nodiscard]] Interface read_definition(std::string_view interface_name,
                                        const std::filesystem::path& file);

/// The definitions that files in a set of folders make, each read when it is first needed.
class Definitions {
 public:
  /// `roots`: folders with PACKAGE/{msg,srv,action}/Name.{idl,msg,srv,action}, the first one that
  /// has a file counts. `packages`: for single packages the folder that holds msg, srv and action.
  Definitions(std::vector<std::filesystem::path> roots,
              std::map<std::string, std::filesystem::path> packages);

  /// "std_srvs/srv/Trigger", with all that it uses: afterwards every type that it names is known.
  /// Throws DefinitionError for what is wrong in any of the files, std::invalid_argument when there
  /// is no file of that name.
  const Interface& load(std::string_view interface_name);

  /// Of a loaded interface: "std_srvs/srv/Trigger_Request". Throws std::invalid_argument.
  [[nodiscard]] const Structure& structure(std::string_view name) const;

  /// Of a loaded structure.
  [[nodiscard]] std::optional<UniformLayout> uniform_layout(const Structure& structure) const;
  /// Of a field, unless it is a sequence.
  [[nodiscard]] std::optional<UniformLayout> uniform_layout(const Field& field) const;

 private:
  [[nodiscard]] std::optional<std::filesystem::path> find_file(
      std::string_view interface_name) const;
  const Interface& parse(std::string_view interface_name, const std::filesystem::path& file);
  void link(const Structure& structure, std::vector<std::string>& within);

  std::vector<std::filesystem::path> roots_;
  std::map<std::string, std::filesystem::path> packages_;
  std::map<std::string, Interface, std::less<>> interfaces_;
  std::map<std::string, const Structure*, std::less<>> structures_;
  std::set<std::string, std::less<>> linked_;
};

}  // namespace pipescout::generator
