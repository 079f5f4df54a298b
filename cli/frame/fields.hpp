// The field list of a result: from it come the JSON, its schema and the table of the README.
//
// A result is a plain struct with one static member:
//
//   struct Signing {
//     std::filesystem::path file;
//     std::string signer;
//     static constexpr auto fields() {
//       return std::tuple(field<&Signing::file>(),
//                         field<&Signing::signer>({.def = "subject"}));
//     }
//   };
//
// The member gives the field its name; field("old", &Change::before) gives another one. computed()
// is a field that a function makes. Listed<T> has the field list of a struct that knows nothing of
// this file. A struct with kDef ("new_ca") has an entry of its own in the schema's $defs. A value
// with kDef and a member json() is a leaf that the schema describes by hand. The alternatives of a
// std::variant are results of one command; kWhen of the second and the later ones says when.
#pragma once

#include <algorithm>
#include <concepts>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <source_location>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include <nlohmann/json.hpp>

#include "base/clock.hpp"

namespace ddssec::cli {

/// JSON whose members keep their order.
using Json = nlohmann::ordered_json;

/// What is known about a field besides its type.
struct FieldOptions {
  std::string_view note = {};     ///< for the README: "null: none"
  std::string_view def = {};      ///< the entry of $defs for the value or, of a list, its elements
  std::string_view words = {};    ///< all values that it can have, separated by |
  std::string_view pattern = {};  ///< the regular expression that a text matches
  bool has_same_members = false;  ///< `note` names the struct that has the same members
  bool has_own_row = false;       ///< the README has a row of its own for the members
  std::size_t min = 0;       ///< least number of elements, or lowest number (not of std::int64_t)
  std::size_t max = 0;       ///< the largest number of elements; 0: any number
  bool omits_empty = false;  ///< an empty std::optional is left out; otherwise it is null
};

namespace fields_detail {

/// The name of a member, taken from the compiler's text: "... [with auto Member = &Signing::file;
/// ...]".
template <auto Member>
consteval std::string_view name_of() {
  std::string_view text = std::source_location::current().function_name();
  text.remove_prefix(text.find("Member = "));
  text = text.substr(0, text.find_first_of(";]"));
  text.remove_prefix(text.rfind(':') + 1);
  return text.substr(0, text.find(')'));
}

}  // namespace fields_detail

/// One field of `Owner`.
template <class Owner, class T>
struct Field {
  using Value = T;
  std::string_view name;
  T Owner::*member;
  FieldOptions options;

  const T& of(const Owner& owner) const { return owner.*member; }
};

template <class Owner, class T>
requires std::is_object_v<T>
constexpr Field<Owner, T> field(std::string_view name, T Owner::*member,
                                FieldOptions options = {}) {
  return {name, member, options};
}

/// A field that `make` makes from `Owner`.
template <class Owner, class Make>
struct ComputedField {
  using Value = std::remove_cvref_t<std::invoke_result_t<Make, const Owner&>>;
  std::string_view name;
  Make make;
  FieldOptions options;

  decltype(auto) of(const Owner& owner) const { return std::invoke(make, owner); }
};

template <class Owner, class Make>
constexpr ComputedField<Owner, Make> computed(std::string_view name, Make make,
                                              FieldOptions options = {}) {
  return {name, make, options};
}

/// A field that a member function makes.
template <class Owner, class T>
constexpr auto field(std::string_view name, T (Owner::*make)() const, FieldOptions options = {}) {
  return computed<Owner>(name, make, options);
}

/// A field that `next` makes from a member. `next` is another member of it, if it is a struct or a
/// pointer to one, or a function of it.
template <class Owner, class T, class Next>
requires std::invocable<Next, const T&>
constexpr auto field(std::string_view name, T Owner::*member, Next next,
                     FieldOptions options = {}) {
  const auto make = [member, next](const Owner& owner) -> decltype(auto) {
    return std::invoke(next, owner.*member);
  };
  return computed<Owner>(name, make, options);
}

/// A field with the name of its member: field<&Signing::file>().
template <auto Member>
constexpr auto field(FieldOptions options = {}) {
  return field(fields_detail::name_of<Member>(), Member, options);
}

/// A field of a part of `Owner`, which appears among the fields of `Owner` itself.
template <class Owner, class Part, class OfPart>
struct PartField {
  using Value = typename OfPart::Value;
  std::string_view name;
  Part Owner::*part;
  OfPart inner;
  FieldOptions options;

  decltype(auto) of(const Owner& owner) const {
    if constexpr (std::is_pointer_v<Part>)
      return inner.of(*(owner.*part));
    else
      return inner.of(owner.*part);
  }
};

/// The field list for a struct of another folder. A specialization has fields(), and may have kDef.
template <class T>
struct Listed {};

namespace fields_detail {

template <class T>
concept IsListed = requires {
  Listed<T>::fields();
};
template <class T>
using ListOf = std::conditional_t<IsListed<T>, Listed<T>, T>;

}  // namespace fields_detail

/// The fields of a part, or of what it points to, for std::tuple_cat.
template <class Owner, class Part>
constexpr auto fields_within(Part Owner::*part) {
  return std::apply(
      [&](const auto&... inner) {
        return std::tuple(PartField<Owner, Part, std::remove_cvref_t<decltype(inner)>>{
            inner.name, part, inner, inner.options}...);
      },
      fields_detail::ListOf<std::remove_cvref_t<std::remove_pointer_t<Part>>>::fields());
}

template <class T>
concept HasFields = requires {
  fields_detail::ListOf<T>::fields();
};

namespace fields_detail {

template <class T, template <class...> class Template>
inline constexpr bool kIsA = false;
template <template <class...> class Template, class... Ts>
inline constexpr bool kIsA<Template<Ts...>, Template> = true;

template <class T>
constexpr std::string_view def_of(const FieldOptions& options) {
  if constexpr (requires { ListOf<T>::kDef; })
    return ListOf<T>::kDef;
  else if (!options.def.empty())
    return options.def;
  else if constexpr (std::same_as<T, std::filesystem::path>)
    return "path";
  else if constexpr (std::same_as<T, WallTime>)
    return "time";
  else
    return {};
}

inline Json words_json(std::string_view words) {
  Json out = Json::array();
  while (!words.empty()) {
    const auto end = std::min(words.find('|'), words.size());
    out.push_back(words.substr(0, end));
    words.remove_prefix(std::min(end + 1, words.size()));
  }
  return out;
}

}  // namespace fields_detail

/// The value as JSON.
template <class T>
Json to_json(const T& value) {
  using namespace fields_detail;
  if constexpr (HasFields<T>) {
    Json out = Json::object();
    const auto add = [&](const auto& one) {
      const auto& held = one.of(value);
      if constexpr (kIsA<std::remove_cvref_t<decltype(held)>, std::optional>)
        if (one.options.omits_empty && !held) return;
      out[std::string(one.name)] = to_json(held);
    };
    std::apply([&](const auto&... all) { (add(all), ...); }, ListOf<T>::fields());
    return out;
  } else if constexpr (requires { value.json(); }) {
    return value.json();
  } else if constexpr (kIsA<T, std::optional>) {
    return value ? to_json(*value) : Json();
  } else if constexpr (kIsA<T, std::vector>) {
    Json out = Json::array();
    for (const auto& element : value) out.push_back(to_json(element));
    return out;
  } else if constexpr (kIsA<T, std::variant>) {
    return std::visit([](const auto& held) { return to_json(held); }, value);
  } else if constexpr (std::same_as<T, std::filesystem::path>) {
    return value.string();
  } else if constexpr (std::same_as<T, WallTime> || std::is_enum_v<T>) {
    return to_string(value);
  } else {
    return value;
  }
}

template <class T>
Json schema_of(const FieldOptions& options = {});

/// The schema of the struct itself, even if it has an entry of its own in $defs.
template <HasFields T>
Json object_schema() {
  using namespace fields_detail;
  Json required = Json::array(), properties = Json::object();
  const auto add = [&](const auto& one) {
    if (!one.options.omits_empty) required.push_back(one.name);
    properties[std::string(one.name)] =
        schema_of<typename std::remove_cvref_t<decltype(one)>::Value>(one.options);
  };
  std::apply([&](const auto&... all) { (add(all), ...); }, ListOf<T>::fields());
  return {{"type", "object"},
          {"additionalProperties", false},
          {"required", std::move(required)},
          {"properties", std::move(properties)}};
}

namespace fields_detail {

template <class... Ts>
Json alternatives(std::type_identity<std::variant<Ts...>>) {
  return {{"oneOf", Json::array({schema_of<Ts>()...})}};
}

template <class T>
Json text_schema(const FieldOptions& options) {
  static_assert(
      std::convertible_to<T, std::string_view> || std::is_enum_v<T> || !def_of<T>({}).empty(),
      "a type without a schema: give it fields()");
  if (!options.words.empty()) return {{"enum", words_json(options.words)}};
  Json out = {{"type", "string"}};
  if (!options.pattern.empty()) out["pattern"] = options.pattern;
  return out;
}

template <class T>
Json list_schema(const FieldOptions& options) {
  Json out = {{"type", "array"}, {"items", schema_of<typename T::value_type>(options)}};
  if (options.min > 0) out["minItems"] = options.min;
  if (options.max > 0) out["maxItems"] = options.max;
  return out;
}

}  // namespace fields_detail

/// The schema of a value of this type.
template <class T>
Json schema_of(const FieldOptions& options) {
  using namespace fields_detail;
  if constexpr (kIsA<T, std::optional>) {
    auto inner = schema_of<typename T::value_type>(options);
    if (options.omits_empty) return inner;
    return {{"anyOf", Json::array({Json{{"type", "null"}}, std::move(inner)})}};
  } else if constexpr (kIsA<T, std::vector>) {
    return list_schema<T>(options);
  } else {
    if (const auto def = def_of<T>(options); !def.empty())
      return {{"$ref", "#/$defs/" + std::string(def)}};
    if constexpr (HasFields<T>)
      return object_schema<T>();
    else if constexpr (kIsA<T, std::variant>)
      return alternatives(std::type_identity<T>());
    else if constexpr (std::same_as<T, bool>)
      return {{"type", "boolean"}};
    else if constexpr (std::same_as<T, std::int64_t>)
      return {{"type", "integer"}};
    else if constexpr (std::integral<T>)
      return {{"type", "integer"}, {"minimum", options.min}};
    else if constexpr (std::floating_point<T>)
      return {{"type", "number"}};
    else if constexpr (std::same_as<T, Json>)
      return Json::object();  // any value; FieldOptions::def names its schema
    else
      return text_schema<T>(options);
  }
}

namespace fields_detail {

/// The struct with the members that a field of this type has; void if it has none.
template <class T>
struct Inner {
  using Type = std::conditional_t<HasFields<T>, T, void>;
  static constexpr bool kIsList = false;
};
template <class T>
struct Inner<std::optional<T>> : Inner<T> {};
template <class T>
struct Inner<std::vector<T>> : Inner<T> {
  static constexpr bool kIsList = true;
};

}  // namespace fields_detail

/// Adds the entries of $defs that a value of this type needs, as far as field lists describe them.
template <class T>
void add_definitions(Json& out) {
  using namespace fields_detail;
  if constexpr (kIsA<T, std::variant>) {
    [&]<class... Ts>(std::type_identity<std::variant<Ts...>>) {
      (add_definitions<Ts>(out), ...);
    }(std::type_identity<T>());
  } else if constexpr (HasFields<typename Inner<T>::Type>) {
    using Struct = typename Inner<T>::Type;
    if constexpr (requires { ListOf<Struct>::kDef; })
      out[std::string(ListOf<Struct>::kDef)] = object_schema<Struct>();
    std::apply([&]<class... Fields>(
                   const Fields&...) { (add_definitions<typename Fields::Value>(out), ...); },
               ListOf<Struct>::fields());
  }
}

/// The row of the README, such as "`dir`, `cas` (each: `role`, `subject`), `until` (null: none)".
template <class T>
std::string members_of();

namespace fields_detail {

template <class Value>
std::string member_words(std::string_view name, const FieldOptions& options) {
  std::string inside(options.note);
  if constexpr (HasFields<typename Inner<Value>::Type>) {
    if (!options.has_same_members && !options.has_own_row) {
      if (!inside.empty()) inside += "; ";
      if (Inner<Value>::kIsList) inside += "each: ";
      inside += members_of<typename Inner<Value>::Type>();
    }
  }
  std::string out = "`" + std::string(name) + "`";
  if (!inside.empty()) out += " (" + inside + ")";
  return out;
}

template <class... Ts>
std::string alternative_words(std::type_identity<std::variant<Ts...>>) {
  std::string out;
  const auto add = [&]<class T>(std::type_identity<T>) {
    if (!out.empty()) out += "; ";
    if constexpr (requires { T::kWhen; }) out += std::string(T::kWhen) + ": ";
    out += members_of<T>();
  };
  (add(std::type_identity<Ts>()), ...);
  return out;
}

}  // namespace fields_detail

template <class T>
std::string members_of() {
  using namespace fields_detail;
  if constexpr (kIsA<T, std::variant>) {
    return alternative_words(std::type_identity<T>());
  } else {
    std::string out;
    const auto add = [&](const auto& one) {
      using Value = typename std::remove_cvref_t<decltype(one)>::Value;
      out += (out.empty() ? "" : ", ") + member_words<Value>(one.name, one.options);
    };
    std::apply([&](const auto&... all) { (add(all), ...); }, ListOf<T>::fields());
    return out;
  }
}

/// Adds a row of the README for each field with `has_own_row`, under the name of the field.
template <class T>
void add_rows(Json& out) {
  using namespace fields_detail;
  const auto add = [&](const auto& one) {
    using Struct = typename Inner<typename std::remove_cvref_t<decltype(one)>::Value>::Type;
    if constexpr (HasFields<Struct>) {
      if (one.options.has_own_row) out[std::string(one.name)] = members_of<Struct>();
      add_rows<Struct>(out);
    }
  };
  if constexpr (HasFields<T>)
    std::apply([&](const auto&... all) { (add(all), ...); }, ListOf<T>::fields());
}

}  // namespace ddssec::cli
