// SPDX-License-Identifier: Apache-2.0
// Writes the C++ of the definitions of one package.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include "cpp_emitter.hpp"
#include "definitions.hpp"
#include "names.hpp"

namespace pipescout::generator {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::string package;
  fs::path folder;
  std::vector<fs::path> roots;
  fs::path output;
  std::vector<std::string> files;
};

/// Leaves a file alone that has this content already, so that nothing is compiled again for it.
void write_if_different(const fs::path& file, const std::string& content) {
  {
    std::ifstream stream(file, std::ios::binary);
    const std::string present{std::istreambuf_iterator<char>(stream),
                              std::istreambuf_iterator<char>()};
    if (stream.is_open() && present == content) {
      return;
    }
  }
  fs::create_directories(file.parent_path());
  std::ofstream stream(file, std::ios::binary);
  stream << content;
  stream.close();
  if (!stream) {
    throw std::runtime_error(file.string() + ": cannot be written");
  }
}

/// "msg/Type.idl" -> "package/msg/Type". Throws std::invalid_argument.
std::string interface_name(const std::string& package, const std::string& file) {
  const fs::path path(file);
  const auto folder = path.parent_path().string();
  const auto extension = path.extension().string();
  if (folder != "msg" && folder != "srv" && folder != "action") {
    throw std::invalid_argument(file + ": a definition stands in msg/, srv/ or action/");
  }
  if (extension != ".idl" && extension != "." + folder) {
    throw std::invalid_argument(file + ": a definition in " + folder + "/ is named Type." + folder +
                                " or Type.idl");
  }
  return package + "/" + folder + "/" + path.stem().string();
}

void generate(const Options& options) {
  Definitions definitions(options.roots, {{options.package, options.folder}});
  std::vector<const Interface*> interfaces;
  for (const auto& file : options.files) {
    const auto& interface = definitions.load(interface_name(options.package, file));
    if (fs::path(interface.file) != options.folder / file) {
      throw std::invalid_argument(file + ": " + interface.file + " defines the same type");
    }
    interfaces.push_back(&interface);
  }
  std::ranges::sort(interfaces, {}, [](const Interface* interface) {
    return std::pair(interface->folder, interface->name);
  });
  for (const auto* const interface : interfaces) {
    write_if_different(options.output / interface->package / interface->folder /
                           (snake_case(interface->name) + ".hpp"),
                       cpp_header(*interface));
  }
  write_if_different(options.output / options.package / "type_support.cpp",
                     cpp_type_support(options.package, interfaces, definitions));
}

}  // namespace
}  // namespace pipescout::generator

int main(int argc, char** argv) {
  pipescout::generator::Options options;
  CLI::App app("Writes the C++ of the message, service and action definitions of one package");
  app.add_option("--package", options.package, "Name of the package")->required();
  app.add_option("--folder", options.folder, "Folder with its msg/, srv/ and action/")->required();
  app.add_option("--root", options.roots, "Folder with folders of other packages");
  app.add_option("--output", options.output,
                 "Where PACKAGE/FOLDER/type.hpp and PACKAGE/type_support.cpp are written")
      ->required();
  app.add_option("files", options.files, "Definitions: msg/Type.msg, srv/Type.idl, ...")
      ->required();
  CLI11_PARSE(app, argc, argv);
  try {
    pipescout::generator::generate(options);
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
  return 0;
}
