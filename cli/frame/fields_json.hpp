// Makes JSON of a result, by its field list.
#pragma once

#include <concepts>
#include <filesystem>
#include <optional>
#include <string>
#include <tuple>
#include <type_traits>
#include <variant>
#include <vector>

#include "base/clock.hpp"
#include "cli/frame/fields.hpp"

namespace ddssec::cli {

/// Makes an object of the field list of T, an array of a vector or a set, null of an empty
/// optional, and a text or number of anything else.
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

}  // namespace ddssec::cli
