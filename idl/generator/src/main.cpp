// SPDX-License-Identifier: Apache-2.0
// The program that builds run on definitions.
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
#include "idl_emitter.hpp"
#include "msg_emitter.hpp"
#include "names.hpp"

namespace pipescout::generator {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::string package;
  fs::path folder;
  std::vector<fs::path> roots;
  fs::path output;
  std::string library;
  std::vector<std::string> files;
};

struct MergeOptions {
  std::vector<fs::path> roots;
  fs::path output;
  std::vector<std::string> types;
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
  if (file.has_parent_path()) {
    fs::create_directories(file.parent_path());
  }
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
    // `ros2 interface show` reads no other form; one that the package has itself is as its author
    // wrote it.
    if (fs::path(interface->file).extension() == ".idl") {
      write_if_different(options.output / interface->package / interface->folder /
                             (interface->name + "." + interface->folder),
                         msg_text(*interface));
    }
  }
  write_if_different(options.output / options.package / "type_support.cpp",
                     cpp_type_support(options.package, interfaces, definitions));
  if (!options.library.empty()) {
    std::string list;
    for (const auto* const interface : interfaces) {
      for (const auto& structure : interface->structures) {
        list += structure.name + ";" + options.library + "\n";
      }
    }
    write_if_different(options.output / options.package / "pipescout_messages", list);
  }
}

void merge(const MergeOptions& options) {
  Definitions definitions(options.roots, {});
  std::vector<const Interface*> interfaces;
  for (const auto& type : options.types) {
    interfaces.push_back(&definitions.load(type));
  }
  write_if_different(options.output, merged_idl(interfaces, definitions));
}

}  // namespace
}  // namespace pipescout::generator

int main(int argc, char** argv) {
  using pipescout::generator::MergeOptions;
  using pipescout::generator::Options;
  CLI::App app("Works on message, service and action definitions");
  app.require_subcommand(1);

  Options options;
  auto* const cpp = app.add_subcommand("cpp", "Write the C++ of the definitions of a package");
  cpp->add_option("--package", options.package, "Name of the package")->required();
  cpp->add_option("--folder", options.folder, "Folder with its msg/, srv/ and action/")->required();
  cpp->add_option("--root", options.roots, "Folder with folders of other packages");
  cpp->add_option("--output", options.output,
                  "Where PACKAGE/FOLDER/type.hpp and PACKAGE/type_support.cpp are written, and of "
                  "definitions in IDL PACKAGE/FOLDER/Type.FOLDER")
      ->required();
  cpp->add_option("--library", options.library,
                  "Also write PACKAGE/pipescout_messages, the list for the ament index, in which "
                  "the types are said to be in this library");
  cpp->add_option("files", options.files, "Definitions: msg/Type.msg, srv/Type.idl, ...")
      ->required();

  MergeOptions merging;
  auto* const idl =
      app.add_subcommand("idl", "Write one .idl file of all, for compilers of other vendors");
  idl->add_option("--root", merging.roots, "Folder with folders of packages")->required();
  idl->add_option("--output", merging.output, "File to write")->required();
  idl->add_option("types", merging.types, "package/msg/Type, package/srv/Type, ...")->required();

  CLI11_PARSE(app, argc, argv);
  try {
    if (cpp->parsed()) {
      pipescout::generator::generate(options);
    } else {
      pipescout::generator::merge(merging);
    }
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
  return 0;
}
