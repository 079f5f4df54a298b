// The field list of a result, from which the JSON, its schema and the table of the README are made.
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
// is a field that a function makes. FieldsOf<T> has the field list of a struct that knows nothing
// of this file. A struct with kDef ("new_ca") has an entry of its own in the schema's $defs. A
// value with kDef and a member json() is a leaf that the schema describes by hand. The alternatives
// of a std::variant are results of one command; kWhen of the second and the later ones says when.
#pragma once

#include <concepts>
#include <cstddef>
#include <functional>
#include <optional>
#include <source_location>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <vector>

#include <nlohmann/json.hpp>

namespace ddssec::cli {

/// JSON whose members keep their order.
using Json = nlohmann::ordered_json;

/// The facts about a field besides its type.
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

/// Returns the name of a member, taken from the compiler's text: "... [with auto Member =
/// &Signing::file; ...]".
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

/// Returns a field that a member function makes.
template <class Owner, class T>
constexpr auto field(std::string_view name, T (Owner::*make)() const, FieldOptions options = {}) {
  return computed<Owner>(name, make, options);
}

/// Returns a field that `next` makes from a member. `next` is another member of it, if it is a
/// struct or a pointer to one, or a function of it.
template <class Owner, class T, class Next>
requires std::invocable<Next, const T&>
constexpr auto field(std::string_view name, T Owner::*member, Next next,
                     FieldOptions options = {}) {
  const auto make = [member, next](const Owner& owner) -> decltype(auto) {
    return std::invoke(next, owner.*member);
  };
  return computed<Owner>(name, make, options);
}

/// Returns a field with the name of its member: field<&Signing::file>().
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
struct FieldsOf {};

namespace fields_detail {

template <class T>
concept HasFieldsOf = requires {
  FieldsOf<T>::fields();
};
template <class T>
using ListOf = std::conditional_t<HasFieldsOf<T>, FieldsOf<T>, T>;

}  // namespace fields_detail

/// Returns the fields of a part, or of what it points to, for std::tuple_cat.
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

/// The struct with the members that a field of this type has; void if it has none.
template <class T>
struct InnerStruct {
  using Type = std::conditional_t<HasFields<T>, T, void>;
  static constexpr bool kIsList = false;
};
template <class T>
struct InnerStruct<std::optional<T>> : InnerStruct<T> {};
template <class T>
struct InnerStruct<std::vector<T>> : InnerStruct<T> {
  static constexpr bool kIsList = true;
};

}  // namespace fields_detail

}  // namespace ddssec::cli
