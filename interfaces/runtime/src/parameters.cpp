// SPDX-License-Identifier: Apache-2.0
#include "pipescout/runtime/parameters.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <shared_mutex>

#include "number_text.hpp"
#include "pipescout/runtime/hint.hpp"
#include "pipescout/runtime/names.hpp"

namespace pipescout {
namespace {

constexpr char kSeparator = '.';

std::string about(const std::string& name, const std::string& message) {
  return "parameter '" + name + "': " + message;
}

std::uint64_t scalar_bits(const ParameterValue& value) noexcept {
  if (const auto* boolean = value.get_if<bool>()) {
    return *boolean ? 1 : 0;
  }
  if (const auto* integer = value.get_if<std::int64_t>()) {
    return static_cast<std::uint64_t>(*integer);
  }
  if (const auto* number = value.get_if<double>()) {
    return std::bit_cast<std::uint64_t>(*number);
  }
  return 0;
}

struct IsEmpty {
  template <class T>
  bool operator()(const std::vector<T>& array) const {
    return array.empty();
  }
  template <class T>
  bool operator()(const T&) const {
    return false;
  }
};

// An empty array of one type becomes one of the type that is expected, and a text that is a number
// becomes that number where one is expected.
ParameterValue conform(ParameterValue value, const ParameterDescriptor& descriptor) {
  if (descriptor.dynamic_typing || value.type() == descriptor.type) {
    return value;
  }
  if (auto numbers = numbers_from_text(value, descriptor.type)) {
    return *std::move(numbers);
  }
  if (!value.visit(IsEmpty{})) {
    return value;
  }
  switch (descriptor.type) {
    case ParameterType::kByteArray:
      return std::vector<std::uint8_t>{};
    case ParameterType::kBoolArray:
      return std::vector<bool>{};
    case ParameterType::kIntegerArray:
      return std::vector<std::int64_t>{};
    case ParameterType::kDoubleArray:
      return std::vector<double>{};
    case ParameterType::kStringArray:
      return std::vector<std::string>{};
    default:
      return value;
  }
}

// Callbacks of one kind. Used under the update mutex only.
template <class Function>
class CallbackList {
 public:
  struct Entry {
    Function function;
    bool active = true;
  };

  std::shared_ptr<Entry> add(Function function) {
    entries_.push_back(std::make_shared<Entry>(Entry{std::move(function)}));
    return entries_.back();
  }

  void remove(const std::shared_ptr<Entry>& entry) {
    entry->active = false;
    std::erase(entries_, entry);
  }

  // Last registered first. A callback may remove any, itself included: entries are kept alive by
  // the copy, and the removed are skipped. `call` returns false to stop.
  template <class Call>
  void for_each(const Call& call) const {
    const std::vector<std::shared_ptr<Entry>> entries = entries_;
    for (auto entry = entries.rbegin(); entry != entries.rend(); ++entry) {
      if ((*entry)->active && !call((*entry)->function)) {
        return;
      }
    }
  }

 private:
  std::vector<std::shared_ptr<Entry>> entries_;
};

// Calls back; an exception becomes a refusal.
template <class Call>
SetResult guarded(const Call& call) {
  try {
    return call();
  } catch (const std::exception& error) {
    return SetResult::refuse(error.what());
  } catch (...) {
    return SetResult::refuse("a parameter callback threw an object that is not an exception");
  }
}

}  // namespace

std::string to_string(const UnusedOverride& unused) {
  std::string text;
  if (!unused.parameter.source.empty()) {
    text = unused.parameter.source + ": ";
  }
  text += "no parameter '" + unused.parameter.name + "'";
  if (unused.nearest) {
    text += did_you_mean(unused.parameter.name, *unused.nearest);
  }
  return text;
}

namespace detail {

ParameterCell::ParameterCell(std::string name, std::shared_ptr<const ParameterValue> value)
    : name_(std::move(name)), scalar_(scalar_bits(*value)), value_(std::move(value)) {}

std::shared_ptr<const ParameterValue> ParameterCell::load() const {
  const std::lock_guard lock(mutex_);
  return value_;
}

void ParameterCell::store(std::shared_ptr<const ParameterValue> value) noexcept {
  {
    const std::lock_guard lock(mutex_);
    scalar_.store(scalar_bits(*value), std::memory_order_release);
    value_.swap(value);
  }
  // The old value is released here, outside the lock.
}

}  // namespace detail

struct Parameters::State {
  struct Entry {
    ParameterDescriptor descriptor;
    std::shared_ptr<detail::ParameterCell> cell;
  };
  struct Override {
    ParameterOverride given;
    bool used = false;
  };

  // Held during a whole declaration or set with its callbacks, and by what registers callbacks.
  // Recursive, so that callbacks can unregister; `updating` keeps them from setting.
  mutable std::recursive_mutex update_mutex;
  bool updating = false;
  CallbackList<AdjustCallback> adjusters;
  CallbackList<ValidateCallback> validators;
  CallbackList<ChangedCallback> listeners;
  EventSink sink;

  // Held for moments only, never during a callback. Taken after update_mutex.
  mutable std::shared_mutex store_mutex;
  std::map<std::string, Entry> entries;
  std::map<std::string, Override> overrides;

  [[nodiscard]] const Entry& entry(const std::string& name) const {
    const auto found = entries.find(name);
    if (found == entries.end()) {
      throw ParameterError(name, about(name, "it is not declared"));
    }
    return found->second;
  }

  [[nodiscard]] ParameterValue value(const std::string& name) const {
    const Entry& found = entry(name);
    const std::shared_ptr<const ParameterValue> current = found.cell->load();
    if (!current->is_set() && !found.descriptor.dynamic_typing) {
      throw ParameterError(name, about(name, "it has no value yet"));
    }
    return *current;
  }

  [[nodiscard]] std::vector<std::string> names() const {
    std::vector<std::string> result;
    for (const auto& [name, entry] : entries) {
      result.push_back(name);
    }
    return result;
  }

  /// A declared parameter "a" for "a.b", or the other way round: `ros2 param dump` writes names as
  /// nested maps, and fails on both.
  [[nodiscard]] std::optional<std::string> branch_of(const std::string& name) const {
    for (auto dot = name.find(kSeparator); dot != std::string::npos;
         dot = name.find(kSeparator, dot + 1)) {
      if (const auto found = entries.find(name.substr(0, dot)); found != entries.end()) {
        return found->first;
      }
    }
    const std::string prefix = name + kSeparator;
    const auto below = entries.lower_bound(prefix);
    return below != entries.end() && below->first.starts_with(prefix) ? std::optional(below->first)
                                                                      : std::nullopt;
  }

  [[nodiscard]] SetResult validate(const std::vector<NamedParameter>& parameters) const {
    SetResult result;
    validators.for_each([&](const ValidateCallback& callback) {
      result = guarded([&] { return callback(parameters); });
      return result.successful;
    });
    if (!result.successful && result.reason.empty()) {
      result.reason = "refused without a reason";
    }
    return result;
  }

  void publish(const ParameterChange& change) const {
    // A copy, since the sink may replace itself.
    if (const EventSink current = sink) {
      current(change);
    }
  }

  [[nodiscard]] SetResult check(std::vector<NamedParameter>& parameters) const;
  [[nodiscard]] ParameterChange apply(const std::vector<NamedParameter>& parameters);
};

namespace {

// Marks an update; made under the update mutex.
class UpdateScope {
 public:
  explicit UpdateScope(bool& updating) : updating_(updating) { updating_ = true; }
  ~UpdateScope() { updating_ = false; }
  UpdateScope(const UpdateScope&) = delete;
  UpdateScope& operator=(const UpdateScope&) = delete;

 private:
  bool& updating_;
};

const char* const kInCallback = "parameters cannot be changed from within a parameter callback";

// The recursive mutex lets only the thread of a callback come here while an update is going on.
void refuse_in_callback(bool updating, const std::string& name) {
  if (updating) {
    throw ParameterError(name, about(name, kInCallback));
  }
}

}  // namespace

// What must hold before anyone is asked; brings empty arrays to their type.
SetResult Parameters::State::check(std::vector<NamedParameter>& parameters) const {
  const std::shared_lock lock(store_mutex);
  std::set<std::string> seen;
  for (NamedParameter& parameter : parameters) {
    const auto refuse = [&parameter](const std::string& reason) {
      return SetResult::refuse(about(parameter.name, reason));
    };
    // In the words of rclcpp, which people and programs know.
    const auto cannot_be_set = [&parameter](const std::string& reason) {
      return SetResult::refuse("parameter '" + parameter.name + "' cannot be set because " +
                               reason);
    };
    const auto found = entries.find(parameter.name);
    if (found == entries.end()) {
      return cannot_be_set("it was not declared");
    }
    if (!seen.insert(parameter.name).second) {
      return refuse("it occurs twice in one set");
    }
    const ParameterDescriptor& descriptor = found->second.descriptor;
    if (descriptor.read_only) {
      return cannot_be_set("it is read-only");
    }
    parameter.value = conform(std::move(parameter.value), descriptor);
    if (const auto objection = descriptor.objection(parameter.value)) {
      return refuse(*objection);
    }
  }
  return SetResult::accept();
}

// All that can fail happens before the first value is stored.
ParameterChange Parameters::State::apply(const std::vector<NamedParameter>& parameters) {
  ParameterChange change;
  std::vector<std::shared_ptr<const ParameterValue>> values;
  for (const NamedParameter& parameter : parameters) {
    values.push_back(std::make_shared<const ParameterValue>(parameter.value));
    if (parameter.value.is_set()) {
      change.changed_parameters.push_back(parameter);
    } else {
      change.deleted_parameters.push_back(
          {parameter.name, *entries.at(parameter.name).cell->load()});
    }
  }
  const std::unique_lock lock(store_mutex);
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const auto found = entries.find(parameters[i].name);
    if (values[i]->is_set()) {
      found->second.descriptor.type = values[i]->type();
      found->second.cell->store(std::move(values[i]));
    } else {
      entries.erase(found);
    }
  }
  return change;
}

ParameterCallbackHandle& ParameterCallbackHandle::operator=(
    ParameterCallbackHandle&& other) noexcept {
  if (this != &other) {
    reset();
    unregister_ = std::exchange(other.unregister_, nullptr);
  }
  return *this;
}

void ParameterCallbackHandle::reset() {
  if (const auto unregister = std::exchange(unregister_, nullptr)) {
    unregister();
  }
}

Parameters::Parameters(std::vector<ParameterOverride> overrides)
    : state_(std::make_shared<State>()) {
  for (ParameterOverride& given : overrides) {
    std::string name = given.name;
    state_->overrides[std::move(name)] = {std::move(given)};
  }
}

Parameters::~Parameters() = default;

ParameterValue Parameters::declare(ParameterDescriptor descriptor, ParameterValue default_value) {
  State& state = *state_;
  const std::lock_guard update_lock(state.update_mutex);
  refuse_in_callback(state.updating, descriptor.name);
  const std::string name = descriptor.name;
  if (descriptor.dynamic_typing) {
    descriptor.type = default_value.type();
  } else if (descriptor.type == ParameterType::kNotSet) {
    descriptor.type = default_value.type();
    if (descriptor.type == ParameterType::kNotSet) {
      throw ParameterError(name, about(name, "it has neither a type nor a default"));
    }
  }
  descriptor.validate();
  if (state.entries.contains(name)) {
    throw ParameterError(name, about(name, "it is already declared"));
  }
  if (const auto other = state.branch_of(name)) {
    throw ParameterError(name, about(name, "'" + *other +
                                               "' is declared, and the one name begins the other: "
                                               "in YAML it would be a value and a map at once"));
  }
  if (default_value.is_set()) {
    if (const auto objection = descriptor.objection(default_value)) {
      throw ParameterError(name, about(name, "default " + *objection));
    }
  }

  ParameterValue initial = std::move(default_value);
  std::string origin;
  if (const auto found = state.overrides.find(name); found != state.overrides.end()) {
    const ParameterOverride& given = found->second.given;
    origin = given.source.empty() ? "" : given.source + ": ";
    {
      const std::unique_lock lock(state.store_mutex);
      found->second.used = true;
    }
    initial = conform(given.value, descriptor);
    if (const auto objection = descriptor.objection(initial)) {
      throw ParameterError(name, origin + about(name, *objection));
    }
  }

  ParameterChange change;
  if (initial.is_set()) {
    change.new_parameters.push_back({name, initial});
    const UpdateScope scope(state.updating);
    if (const SetResult result = state.validate(change.new_parameters); !result.successful) {
      throw ParameterError(name, origin + about(name, "value " + to_yaml(initial) +
                                                          " is refused: " + result.reason));
    }
    descriptor.type = initial.type();
  }
  auto cell = std::make_shared<detail::ParameterCell>(
      name, std::make_shared<const ParameterValue>(initial));
  {
    const std::unique_lock lock(state.store_mutex);
    state.entries.emplace(name, State::Entry{std::move(descriptor), std::move(cell)});
  }
  if (initial.is_set()) {
    const UpdateScope scope(state.updating);
    state.publish(change);
  }
  return initial;
}

std::shared_ptr<const detail::ParameterCell> Parameters::declare_static(
    ParameterDescriptor descriptor, ParameterValue default_value,
    std::optional<IntegerRange> limits) {
  const std::string name = descriptor.name;
  const ParameterType type = descriptor.type;
  if (descriptor.dynamic_typing) {
    throw ParameterError(name, about(name, "a typed parameter cannot be dynamically typed"));
  }
  if (limits) {
    if (!descriptor.integer_range) {
      descriptor.integer_range = limits;
    } else if (descriptor.integer_range->from < limits->from ||
               descriptor.integer_range->to > limits->to) {
      throw ParameterError(name, about(name, "its range " + to_string(*descriptor.integer_range) +
                                                 " exceeds its C++ type, " + to_string(*limits)));
    }
  }
  declare(std::move(descriptor), std::move(default_value));
  return cell(name, type, limits);
}

void Parameters::require_override(const std::string& name, ParameterType type) const {
  const std::shared_lock lock(state_->store_mutex);
  const auto found = state_->overrides.find(name);
  if (found == state_->overrides.end() || !found->second.given.value.is_set()) {
    throw ParameterError(name, about(name, std::string("it has no default: a value of type ") +
                                               to_string(type) + " must be given"));
  }
}

std::shared_ptr<const detail::ParameterCell> Parameters::cell(
    const std::string& name, ParameterType type, std::optional<IntegerRange> limits) const {
  const std::shared_lock lock(state_->store_mutex);
  const State::Entry& entry = state_->entry(name);
  const ParameterDescriptor& descriptor = entry.descriptor;
  if (descriptor.dynamic_typing || descriptor.type != type) {
    throw ParameterError(
        name, about(name, std::string("it is of type ") + to_string(descriptor.type) +
                              (descriptor.dynamic_typing ? " (dynamic)" : "") + ", requested as " +
                              to_string(type)));
  }
  const auto& range = descriptor.integer_range;
  if (limits && (!range || range->from < limits->from || range->to > limits->to)) {
    throw ParameterError(name,
                         about(name, "its values may exceed the C++ type, " + to_string(*limits)));
  }
  if (!entry.cell->load()->is_set()) {
    throw ParameterError(name, about(name, "it has no value yet"));
  }
  return entry.cell;
}

void Parameters::undeclare(const std::string& name) {
  State& state = *state_;
  const std::lock_guard update_lock(state.update_mutex);
  refuse_in_callback(state.updating, name);
  const ParameterDescriptor& descriptor = state.entry(name).descriptor;
  if (descriptor.read_only) {
    throw ParameterError(name, about(name, "cannot be undeclared because it is read-only"));
  }
  if (!descriptor.dynamic_typing) {
    throw ParameterError(name, about(name, "cannot be undeclared because it is statically typed"));
  }
  const ParameterChange change = state.apply({{name, {}}});
  const UpdateScope scope(state.updating);
  state.publish(change);
}

bool Parameters::has(const std::string& name) const {
  const std::shared_lock lock(state_->store_mutex);
  return state_->entries.contains(name);
}

ParameterValue Parameters::get(const std::string& name) const {
  const std::shared_lock lock(state_->store_mutex);
  return state_->value(name);
}

std::vector<ParameterValue> Parameters::get_many(const std::vector<std::string>& names) const {
  std::vector<ParameterValue> result;
  result.reserve(names.size());
  const std::shared_lock lock(state_->store_mutex);
  for (const std::string& name : names) {
    result.push_back(state_->value(name));
  }
  return result;
}

std::optional<ParameterValue> Parameters::get_optional(const std::string& name) const {
  const std::shared_lock lock(state_->store_mutex);
  const auto found = state_->entries.find(name);
  if (found == state_->entries.end()) {
    return std::nullopt;
  }
  const std::shared_ptr<const ParameterValue> value = found->second.cell->load();
  return value->is_set() ? std::optional(*value) : std::nullopt;
}

std::vector<NamedParameter> Parameters::all() const {
  std::vector<NamedParameter> result;
  const std::shared_lock lock(state_->store_mutex);
  for (const auto& [name, entry] : state_->entries) {
    result.push_back({name, *entry.cell->load()});
  }
  return result;
}

ParameterList Parameters::list(const std::vector<std::string>& prefixes,
                               std::uint64_t depth) const {
  const auto is_shallow = [depth](std::string_view text) {
    const auto separators = std::count(text.begin(), text.end(), kSeparator);
    return depth == 0 || static_cast<std::uint64_t>(separators) < depth;
  };
  const auto is_listed = [&](std::string_view name) {
    if (prefixes.empty()) {
      return is_shallow(name);
    }
    return std::any_of(prefixes.begin(), prefixes.end(), [&](const std::string& prefix) {
      return name == prefix ||
             (name.starts_with(prefix + kSeparator) && is_shallow(name.substr(prefix.size())));
    });
  };
  ParameterList result;
  std::set<std::string> found_prefixes;
  const std::shared_lock lock(state_->store_mutex);
  for (const auto& [name, entry] : state_->entries) {
    if (!is_listed(name)) {
      continue;
    }
    result.names.push_back(name);
    if (const std::size_t last = name.rfind(kSeparator); last != std::string::npos) {
      found_prefixes.insert(name.substr(0, last));
    }
  }
  result.prefixes.assign(found_prefixes.begin(), found_prefixes.end());
  return result;
}

std::vector<ParameterDescriptor> Parameters::describe(const std::vector<std::string>& names) const {
  std::vector<ParameterDescriptor> result;
  result.reserve(names.size());
  const std::shared_lock lock(state_->store_mutex);
  for (const std::string& name : names) {
    result.push_back(state_->entry(name).descriptor);
  }
  return result;
}

std::vector<ParameterType> Parameters::types(const std::vector<std::string>& names) const {
  std::vector<ParameterType> result;
  result.reserve(names.size());
  const std::shared_lock lock(state_->store_mutex);
  for (const std::string& name : names) {
    result.push_back(state_->entry(name).cell->load()->type());
  }
  return result;
}

std::vector<SetResult> Parameters::set(const std::vector<NamedParameter>& parameters) {
  std::vector<SetResult> results;
  results.reserve(parameters.size());
  for (const NamedParameter& parameter : parameters) {
    results.push_back(set_atomically({parameter}));
  }
  return results;
}

SetResult Parameters::set(const std::string& name, ParameterValue value) {
  return set_atomically({{name, std::move(value)}});
}

SetResult Parameters::set_atomically(const std::vector<NamedParameter>& parameters) {
  State& state = *state_;
  const std::lock_guard update_lock(state.update_mutex);
  if (state.updating) {
    return SetResult::refuse(kInCallback);
  }
  if (parameters.empty()) {
    return SetResult::accept();
  }
  const UpdateScope scope(state.updating);
  std::vector<NamedParameter> proposed = parameters;
  SetResult result;
  state.adjusters.for_each([&](const AdjustCallback& callback) {
    result = guarded([&] {
      callback(proposed);
      return SetResult::accept();
    });
    return result.successful;
  });
  if (!result.successful) {
    return result;
  }
  if (proposed.empty()) {
    return SetResult::refuse("a callback removed all parameters from the set");
  }
  if (result = state.check(proposed); !result.successful) {
    return result;
  }
  if (result = state.validate(proposed); !result.successful) {
    return result;
  }
  const ParameterChange change = state.apply(proposed);
  result = SetResult::accept();
  state.listeners.for_each([&](const ChangedCallback& callback) {
    const SetResult called = guarded([&] {
      callback(proposed);
      return SetResult::accept();
    });
    if (!called.successful) {
      result.reason += (result.reason.empty() ? "" : "; ") +
                       ("set, but a callback then failed: " + called.reason);
    }
    return true;
  });
  state.publish(change);
  return result;
}

namespace {

template <class State, class List, class Function>
ParameterCallbackHandle register_callback(const std::shared_ptr<State>& state, List State::*list,
                                          Function function) {
  if (!function) {
    throw std::invalid_argument("a parameter callback is empty");
  }
  const std::lock_guard lock(state->update_mutex);
  auto entry = ((*state).*list).add(std::move(function));
  return ParameterCallbackHandle([weak = std::weak_ptr(state), list, entry] {
    if (const std::shared_ptr<State> alive = weak.lock()) {
      const std::lock_guard unregister_lock(alive->update_mutex);
      ((*alive).*list).remove(entry);
    }
  });
}

}  // namespace

ParameterCallbackHandle Parameters::on_adjust(AdjustCallback callback) {
  return register_callback(state_, &State::adjusters, std::move(callback));
}

ParameterCallbackHandle Parameters::on_validate(ValidateCallback callback) {
  return register_callback(state_, &State::validators, std::move(callback));
}

ParameterCallbackHandle Parameters::on_changed(ChangedCallback callback) {
  return register_callback(state_, &State::listeners, std::move(callback));
}

void Parameters::set_event_sink(EventSink sink) {
  const std::lock_guard lock(state_->update_mutex);
  state_->sink = std::move(sink);
}

std::vector<UnusedOverride> Parameters::unused_overrides() const {
  std::vector<UnusedOverride> result;
  const std::shared_lock lock(state_->store_mutex);
  const std::vector<std::string> declared = state_->names();
  for (const auto& [name, override_entry] : state_->overrides) {
    if (!override_entry.used) {
      result.push_back({override_entry.given, nearest_name(name, declared)});
    }
  }
  return result;
}

}  // namespace pipescout
