// SPDX-License-Identifier: Apache-2.0
#include "pipescout/runtime/component_registry.hpp"

#include <algorithm>
#include <cctype>
#include <class_loader/class_loader.hpp>
#include <fstream>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <sstream>
#include <utility>

#include "pipescout/idl/installed_prefixes.hpp"
#include "pipescout/runtime/hint.hpp"
#include "pipescout/runtime/names.hpp"

namespace pipescout {

namespace {

namespace fs = std::filesystem;

// The third field of a line, which most have not.
constexpr std::string_view kSeesWholeGraph = "sees_whole_graph";

constexpr std::string_view kIndex = "share/ament_index/resource_index/pipescout_components";

/// class_loader reports what it also throws, and warns of what is decided here.
class QuietClassLoader {
 public:
  QuietClassLoader() : before_(console_bridge::getLogLevel()) {
    console_bridge::setLogLevel(console_bridge::CONSOLE_BRIDGE_LOG_NONE);
  }
  QuietClassLoader(const QuietClassLoader&) = delete;
  QuietClassLoader& operator=(const QuietClassLoader&) = delete;
  ~QuietClassLoader() { console_bridge::setLogLevel(before_); }

 private:
  const console_bridge::LogLevel before_;
};

/// The libraries that this process has loaded. Never destroyed, so that none is unloaded.
class LoadedLibraries {
 public:
  static LoadedLibraries& instance() {
    static auto* const libraries = new LoadedLibraries;
    return *libraries;
  }

  std::shared_ptr<const ComponentFactory> factory(const ComponentType& type) {
    const std::lock_guard lock(mutex_);
    const QuietClassLoader quiet;
    class_loader::ClassLoader& loader = load(type);
    const std::string factory_name = "pipescout::ComponentFactoryFor<" + type.class_name + ">";
    if (!loader.isClassAvailable<ComponentFactory>(factory_name)) {
      throw ComponentLoadError("library '" + type.library.string() +
                               "' registers no component class '" + type.class_name +
                               "' (PIPESCOUT_REGISTER_COMPONENT)");
    }
    try {
      return loader.createInstance<ComponentFactory>(factory_name);
    } catch (const class_loader::ClassLoaderException& error) {
      throw ComponentLoadError("component class '" + type.class_name + "' in library '" +
                               type.library.string() + "': " + error.what());
    }
  }

 private:
  class_loader::ClassLoader& load(const ComponentType& type) {
    auto& loader = loaders_[type.library.string()];
    if (!loader) {
      try {
        loader = std::make_unique<class_loader::ClassLoader>(type.library.string());
      } catch (const class_loader::ClassLoaderException& error) {
        throw ComponentLoadError("library '" + type.library.string() + "' of component class '" +
                                 type.class_name + "' cannot be loaded: " + error.what());
      }
    }
    return *loader;
  }

  std::mutex mutex_;
  std::map<std::string, std::unique_ptr<class_loader::ClassLoader>> loaders_;
};

std::string_view own_name(std::string_view class_name) {
  const auto colon = class_name.rfind(':');
  return colon == std::string_view::npos ? class_name : class_name.substr(colon + 1);
}

/// The class that was meant, also where the namespace was forgotten.
std::optional<std::string> nearest_class(std::string_view misspelt,
                                         const std::vector<ComponentType>& types) {
  std::vector<std::string> names;
  std::vector<std::string> own_names;
  for (const ComponentType& type : types) {
    names.push_back(type.class_name);
    own_names.emplace_back(own_name(type.class_name));
  }
  if (auto nearest = nearest_name(misspelt, names)) {
    return nearest;
  }
  if (const auto nearest = nearest_name(own_name(misspelt), own_names)) {
    const auto position = std::find(own_names.begin(), own_names.end(), *nearest);
    return names.at(static_cast<std::size_t>(position - own_names.begin()));
  }
  return std::nullopt;
}

}  // namespace

ComponentRegistry::ComponentRegistry() : ComponentRegistry(default_prefixes()) {}

ComponentRegistry::ComponentRegistry(const std::vector<std::filesystem::path>& prefixes) {
  std::set<std::string> packages;
  for (const fs::path& prefix : without_repetitions(prefixes)) {
    ++prefixes_;
    std::error_code error;
    for (fs::directory_iterator entry(prefix / kIndex, error), end; !error && entry != end;
         entry.increment(error)) {
      const std::string package = entry->path().filename().string();
      // A file that begins with a dot is not of the index.
      if (!package.starts_with('.') && packages.insert(package).second) {
        read_index(prefix, entry->path());
      }
    }
  }
  std::sort(types_.begin(), types_.end(), [](const ComponentType& a, const ComponentType& b) {
    return std::tie(a.class_name, a.package) < std::tie(b.class_name, b.package);
  });
}

std::vector<std::filesystem::path> ComponentRegistry::default_prefixes() {
  return installed_prefixes();
}

void ComponentRegistry::read_index(const std::filesystem::path& prefix,
                                   const std::filesystem::path& file) {
  std::ifstream stream(file);
  if (!stream || fs::is_directory(file)) {
    problems_.push_back(file.string() + ": cannot be read");
    return;
  }
  std::set<std::string> classes;
  int number = 0;
  for (std::string line; std::getline(stream, line);) {
    ++number;
    if (!line.empty() && line.back() == '\r') {
      line.pop_back();
    }
    if (line.empty()) {
      continue;
    }
    const std::string where = file.string() + ":" + std::to_string(number) + ": ";
    std::vector<std::string> fields;
    std::istringstream text(line);
    for (std::string field; std::getline(text, field, ';');) {
      fields.push_back(std::move(field));
    }
    const bool sees_whole_graph = fields.size() == 3 && fields[2] == kSeesWholeGraph;
    const std::string& class_name = fields.front();
    if (class_name.empty() || fields.size() < 2 || fields[1].empty() || line.back() == ';' ||
        (fields.size() > 2 && !sees_whole_graph)) {
      problems_.push_back(where + "expected '<class>;<library>', found '" + line + "'");
    } else if (!classes.insert(class_name).second) {
      problems_.push_back(where + "class '" + class_name + "' is a duplicate in this file");
    } else {
      types_.push_back(
          {class_name, file.filename().string(), prefix / fields[1], sees_whole_graph});
    }
  }
}

const ComponentType& ComponentRegistry::find(std::string_view class_name,
                                             std::string_view package) const {
  std::vector<const ComponentType*> matches;
  for (const ComponentType& type : types_) {
    if (type.class_name == class_name && (package.empty() || type.package == package)) {
      matches.push_back(&type);
    }
  }
  if (matches.size() == 1) {
    return *matches.front();
  }
  const std::string what = "component class '" + std::string(class_name) + "'";
  if (!matches.empty()) {
    throw UnknownComponent(what + " is provided by the packages '" + matches[0]->package +
                           "' and '" + matches[1]->package + "': select one of them");
  }
  std::string message = "unknown " + what;
  if (!package.empty()) {
    message += " in package '" + std::string(package) + "'";
  }
  if (const auto nearest = nearest_class(class_name, types_)) {
    message += *nearest == class_name ? "; another package provides it"
                                      : did_you_mean(class_name, *nearest);
  }
  message += " (" + std::to_string(types_.size()) + " known, in " + std::to_string(prefixes_) +
             (prefixes_ == 1 ? " prefix searched)" : " prefixes searched)");
  throw UnknownComponent(message);
}

bool ComponentRegistry::sees_whole_graph(std::string_view class_name) const noexcept {
  return std::any_of(types_.begin(), types_.end(), [&](const ComponentType& type) {
    return type.class_name == class_name && type.sees_whole_graph;
  });
}

ComponentPtr<> ComponentRegistry::create(std::string_view class_name, ComponentOptions options,
                                         std::string_view package) const {
  return LoadedLibraries::instance().factory(find(class_name, package))->create(std::move(options));
}

std::string default_component_name(std::string_view class_name) {
  const auto is_upper = [](char c) { return std::isupper(static_cast<unsigned char>(c)) != 0; };
  const std::string_view camel = own_name(class_name);
  std::string name;
  for (std::size_t i = 0; i < camel.size(); ++i) {
    // A word begins at a capital after a small letter or digit, and at the last capital of a row of
    // them: "IMUDriver" -> "imu_driver".
    const bool after_small = i > 0 && !is_upper(camel[i - 1]) && camel[i - 1] != '_';
    const bool ends_row = i > 0 && is_upper(camel[i - 1]) && i + 1 < camel.size() &&
                          std::islower(static_cast<unsigned char>(camel[i + 1])) != 0;
    if (is_upper(camel[i]) && (after_small || ends_row)) {
      name += '_';
    }
    name += static_cast<char>(std::tolower(static_cast<unsigned char>(camel[i])));
  }
  return name;
}

}  // namespace pipescout
