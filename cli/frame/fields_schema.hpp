// Makes the schema of a result's JSON, by its field list.
#pragma once

#include <algorithm>
#include <concepts>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "base/clock.hpp"
#include "cli/frame/fields.hpp"

namespace ddssec::cli {
namespace fields_detail {

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

/// Adds the entries of $defs that a value of this type needs, as far as field lists describe them.
template <class T>
void add_definitions(Json& out) {
  using namespace fields_detail;
  if constexpr (kIsA<T, std::variant>) {
    [&]<class... Ts>(std::type_identity<std::variant<Ts...>>) {
      (add_definitions<Ts>(out), ...);
    }(std::type_identity<T>());
  } else if constexpr (HasFields<typename InnerStruct<T>::Type>) {
    using Struct = typename InnerStruct<T>::Type;
    if constexpr (requires { ListOf<Struct>::kDef; })
      out[std::string(ListOf<Struct>::kDef)] = object_schema<Struct>();
    std::apply([&]<class... Fields>(
                   const Fields&...) { (add_definitions<typename Fields::Value>(out), ...); },
               ListOf<Struct>::fields());
  }
}

}  // namespace ddssec::cli
