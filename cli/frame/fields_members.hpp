// Lists the members of a result for the README, by its field list.
#pragma once

#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <variant>

#include "cli/frame/fields.hpp"

namespace ddssec::cli {

/// The row of the README, such as "`dir`, `cas` (each: `role`, `subject`), `until` (null: none)".
template <class T>
std::string members_of();

namespace fields_detail {

template <class Value>
std::string member_words(std::string_view name, const FieldOptions& options) {
  std::string inside(options.note);
  if constexpr (HasFields<typename InnerStruct<Value>::Type>) {
    if (!options.has_same_members && !options.has_own_row) {
      if (!inside.empty()) inside += "; ";
      if (InnerStruct<Value>::kIsList) inside += "each: ";
      inside += members_of<typename InnerStruct<Value>::Type>();
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
    using Struct = typename InnerStruct<typename std::remove_cvref_t<decltype(one)>::Value>::Type;
    if constexpr (HasFields<Struct>) {
      if (one.options.has_own_row) out[std::string(one.name)] = members_of<Struct>();
      add_rows<Struct>(out);
    }
  };
  if constexpr (HasFields<T>)
    std::apply([&](const auto&... all) { (add(all), ...); }, ListOf<T>::fields());
}

}  // namespace ddssec::cli
