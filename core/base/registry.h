// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <concepts>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <limits>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

// The registry of a family of methods: name -> promise, source, traits, options and factory. A
// registry is a value. Each method adds itself by a function in its own .cpp file, which one place
// of its room calls; nothing registers itself before main.

namespace selvedge {

/// The values that an option accepts.
enum class OptionKind : std::uint8_t { number, whole, boolean };

/// One option of a method.
struct MethodOption {
  std::string name;      ///< as in scene files, in snake_case
  double initial = 0.0;  ///< default, in `unit`; 1 for true
  std::string unit{};    ///< "m", "1/s"; "1": dimensionless; empty: true or false
  double least = -std::numeric_limits<double>::infinity();
  double most = std::numeric_limits<double>::infinity();
  bool above_least = false;  ///< `least` itself is excluded
  OptionKind kind = OptionKind::number;
  std::string meaning{};  ///< one sentence: effect and trade-off
};

/// Values of options by name. Whole numbers and true (1) or false (0) are stored as doubles.
class MethodOptions {
 public:
  using Values = std::map<std::string, double>;

  MethodOptions() = default;
  MethodOptions(std::initializer_list<Values::value_type> values) : values_(values) {}

  void set(const std::string& name, double value) { values_[name] = value; }
  bool contains(const std::string& name) const { return values_.contains(name); }
  bool empty() const { return values_.empty(); }
  /// Throws std::logic_error for a name that is not among the options.
  double operator[](const std::string& name) const;
  /// The same as a whole number, or as true or false.
  int whole(const std::string& name) const { return static_cast<int>((*this)[name]); }
  bool flag(const std::string& name) const { return (*this)[name] != 0.0; }

  Values::const_iterator begin() const { return values_.begin(); }
  Values::const_iterator end() const { return values_.end(); }
  bool operator==(const MethodOptions&) const = default;

 private:
  Values values_;
};

/// The known word with the smallest edit distance, the first of several; "" if none is known.
std::string nearest_word(const std::string& word, const std::vector<std::string>& known);

/// Why the options do not accept this value, as the predicate of a sentence: an unknown name (with
/// the nearest known one), or a value of the wrong kind or out of range. Empty if they accept it.
std::string option_fault(const std::vector<MethodOption>& options, const std::string& name,
                         double value);

/// The given values, and the defaults of the options that are not given. Throws
/// std::invalid_argument that begins with `method` for a value that the options do not accept.
MethodOptions complete_options(const std::string& method, const std::vector<MethodOption>& options,
                               const MethodOptions& given);

/// The given values that the options include, for methods that are compared under shared settings.
MethodOptions known_options(const std::vector<MethodOption>& options, const MethodOptions& given);

/// The values with their units: "stiffness 1000 N/m, damping 0.1 N·s/m".
std::string options_text(const std::vector<MethodOption>& options, const MethodOptions& values);

/// Why a registry with these names has no method `name`, as one sentence with the nearest name and
/// all names. `absent` maps methods that this build omits to the library that they need.
std::string unknown_name(const std::string& name, const std::vector<std::string>& known,
                         const std::map<std::string, std::string>& absent);

/// The guarantee of a method. Traits without the member `promise` have an overload beside them.
template <class Traits>
requires requires(const Traits& traits) { std::string(traits.promise); }
std::string promise_of(const Traits& traits) { return std::string(traits.promise); }

/// One method: its options, its traits and its factory. `Args` are the arguments that every method
/// of the family needs, such as the forces of an integrator.
template <class Product, class Traits, class... Args>
class RegistryEntry {
 public:
  /// Receives the values of all options.
  using Make = std::function<Product(const MethodOptions&, Args...)>;

  /// Takes the traits from a product made with the defaults and value-initialised arguments, each
  /// time they are needed.
  RegistryEntry(std::vector<MethodOption> options, Make make) requires
      requires(const Product& product) {
    { product->traits() } -> std::convertible_to<Traits>;
  } : options_(std::move(options)), make_(std::move(make)) {
    traits_ = [o = options_, m = make_]() -> Traits {
      return m(complete_options("", o, {}), std::remove_cvref_t<Args>{}...)->traits();
    };
  }
  RegistryEntry(std::vector<MethodOption> options, Make make, Traits traits)
      : options_(std::move(options)),
        make_(std::move(make)),
        traits_([t = std::move(traits)] { return t; }) {}

  const std::string& name() const { return name_; }
  const std::vector<MethodOption>& options() const { return options_; }
  /// Optional library that the method comes from; empty: selvedge itself.
  const std::string& library() const { return library_; }
  /// Traits with the default options.
  Traits traits() const { return traits_(); }
  std::string promise() const { return promise_of(traits_()); }         ///< guarantee, one sentence
  std::string source() const { return std::string(traits_().source); }  ///< author, title, year

  /// The method with its default options.
  Product operator()(Args... args) const {
    return make_(complete_options(name_, options_, {}), std::forward<Args>(args)...);
  }
  /// The method with these options. Throws std::invalid_argument for an option that the method does
  /// not have (with the nearest one that it has) and for a value out of range.
  Product operator()(const MethodOptions& given, Args... args) const {
    return make_(complete_options(name_, options_, given), std::forward<Args>(args)...);
  }

  /// The same method, whose products pass through `change`.
  RegistryEntry wrapped(std::function<Product(Product)> change) const {
    RegistryEntry entry = *this;
    entry.make_ = [make = make_, change = std::move(change)](const MethodOptions& options,
                                                             Args... args) {
      return change(make(options, std::forward<Args>(args)...));
    };
    return entry;
  }

 private:
  template <class P, class T, class... A>
  friend class Registry;

  std::string name_, library_;
  std::size_t order_ = 0;  // among the methods of the registry
  std::vector<MethodOption> options_;
  Make make_;
  std::function<Traits()> traits_;
};

/// A method that a scene selects by another key than the names of its family.
template <class Traits>
struct KeyedMethod {
  std::string key;  ///< as in SceneKey, for example "materials.*.stretch_law"
  Traits traits;
};

/// The methods of one family by name.
template <class Product, class Traits, class... Args>
class Registry {
 public:
  using Entry = RegistryEntry<Product, Traits, Args...>;
  using Entries = std::map<std::string, Entry>;
  using value_type = typename Entries::value_type;

  /// Adds a method, or replaces the one of that name.
  void add(const std::string& name, Entry entry) {
    entry.name_ = name;
    const auto former = entries_.find(name);
    entry.order_ = former != entries_.end() ? former->second.order_ : added_++;
    keyed_.erase(name);
    if (const auto absent = absent_.find(name); absent != absent_.end()) {
      entry.library_ = absent->second;
      absent_.erase(absent);
    }
    entries_.insert_or_assign(name, std::move(entry));
  }
  void add(const std::string& name, std::vector<MethodOption> options, typename Entry::Make make) {
    add(name, Entry(std::move(options), std::move(make)));
  }
  /// The same for products without the member `traits`.
  void add(const std::string& name, std::vector<MethodOption> options, typename Entry::Make make,
           Traits traits) {
    add(name, Entry(std::move(options), std::move(make), std::move(traits)));
  }
  /// Notes a method that needs an optional library, for messages and lists; `add` makes it
  /// available.
  void add_absent(const std::string& name, const std::string& library) {
    if (!entries_.contains(name)) absent_[name] = library;
  }
  /// Notes a method that another key of a scene selects, for messages and lists.
  void add_keyed(const std::string& name, const std::string& key, Traits traits) {
    if (!entries_.contains(name))
      keyed_.insert_or_assign(name, KeyedMethod<Traits>{key, std::move(traits)});
  }

  /// The method of that name. Throws std::invalid_argument with the sentence of `fault`.
  const Entry& at(const std::string& name) const {
    const auto found = entries_.find(name);
    if (found == entries_.end()) throw std::invalid_argument(fault(name));
    return found->second;
  }
  /// Why there is no such method, as one sentence with the nearest name; empty if there is one.
  std::string fault(const std::string& name) const {
    if (const auto other = keyed_.find(name); other != keyed_.end())
      return "\"" + name + "\" is selected by the key \"" + other->second.key + "\", not by name";
    return entries_.contains(name) ? std::string() : unknown_name(name, names(), absent_);
  }
  /// All names, sorted. Iteration has the same order.
  std::vector<std::string> names() const {
    std::vector<std::string> names;
    for (const auto& entry : entries_) names.push_back(entry.first);
    return names;
  }
  /// The methods in the order in which they were added. One that was replaced keeps its place.
  std::vector<const Entry*> in_order() const {
    std::vector<const Entry*> all;
    for (const auto& [name, entry] : entries_) all.push_back(&entry);
    std::sort(all.begin(), all.end(),
              [](const Entry* a, const Entry* b) { return a->order_ < b->order_; });
    return all;
  }
  /// Methods that other keys of a scene select.
  const std::map<std::string, KeyedMethod<Traits>>& keyed() const { return keyed_; }
  /// Methods that need a library which this build does not have, and the name of that library.
  const std::map<std::string, std::string>& absent() const { return absent_; }

  bool contains(const std::string& name) const { return entries_.contains(name); }
  std::size_t size() const { return entries_.size(); }
  bool empty() const { return entries_.empty(); }
  std::size_t erase(const std::string& name) { return entries_.erase(name); }
  /// Erases the methods for which `drop` of (name, entry) is true.
  template <class Drop>
  void erase_if(Drop drop) {
    std::erase_if(entries_, drop);
  }
  typename Entries::const_iterator find(const std::string& name) const {
    return entries_.find(name);
  }
  typename Entries::const_iterator begin() const { return entries_.begin(); }
  typename Entries::const_iterator end() const { return entries_.end(); }

 private:
  Entries entries_;
  std::size_t added_ = 0;  // so far
  std::map<std::string, std::string> absent_;
  std::map<std::string, KeyedMethod<Traits>> keyed_;
};

}  // namespace selvedge
