#include "idl/cpp_type.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string_view>
#include <vector>

namespace ddssec::idl {
namespace {

constexpr std::array<std::string_view, 96> kKeywords = {
    "alignas",       "alignof",     "and",
    "and_eq",        "asm",         "auto",
    "bitand",        "bitor",       "bool",
    "break",         "case",        "catch",
    "char",          "char16_t",    "char32_t",
    "char8_t",       "class",       "co_await",
    "co_return",     "co_yield",    "compl",
    "concept",       "const",       "const_cast",
    "consteval",     "constexpr",   "constinit",
    "continue",      "decltype",    "default",
    "delete",        "do",          "double",
    "dynamic_cast",  "else",        "enum",
    "explicit",      "export",      "extern",
    "false",         "float",       "for",
    "friend",        "goto",        "if",
    "inline",        "int",         "long",
    "mutable",       "namespace",   "new",
    "noexcept",      "not",         "not_eq",
    "nullptr",       "operator",    "or",
    "or_eq",         "private",     "protected",
    "public",        "register",    "reinterpret_cast",
    "requires",      "return",      "short",
    "signed",        "sizeof",      "static",
    "static_assert", "static_cast", "struct",
    "switch",        "template",    "this",
    "thread_local",  "throw",       "true",
    "try",           "typedef",     "typeid",
    "typename",      "union",       "unsigned",
    "using",         "virtual",     "void",
    "volatile",      "wchar_t",     "while",
    "xor",           "xor_eq",      "errno",
    "assert",        "NULL",        "EOF"};

struct Primitive {
  tree_kind kind;
  const char* text;
};
constexpr std::array kPrimitives = {Primitive{tree_bool, "bool"},
                                    Primitive{tree_char, "char"},
                                    Primitive{tree_octet, "std::uint8_t"},
                                    Primitive{tree_int8, "std::int8_t"},
                                    Primitive{tree_uint8, "std::uint8_t"},
                                    Primitive{tree_int16, "std::int16_t"},
                                    Primitive{tree_uint16, "std::uint16_t"},
                                    Primitive{tree_int32, "std::int32_t"},
                                    Primitive{tree_uint32, "std::uint32_t"},
                                    Primitive{tree_int64, "std::int64_t"},
                                    Primitive{tree_uint64, "std::uint64_t"},
                                    Primitive{tree_float, "float"},
                                    Primitive{tree_double, "double"}};

struct MissingType {
  tree_kind kind;
  const char* what;
  const char* to_do;
};
constexpr std::array kMissing = {
    MissingType{tree_wchar, "wchar", "use a char or a string"},
    MissingType{tree_wstring, "wstring", "use a string, in UTF-8"},
    MissingType{tree_long_double, "long double", "use a double"},
    MissingType{tree_any, "any", "use a sequence<octet> and a type's name"},
    MissingType{tree_fixed, "fixed", "use an integer and a scale"},
    MissingType{tree_union, "a union", "use a struct and an enum that says which member counts"},
    MissingType{tree_bitmask, "a bitmask", "use an unsigned integer and constants"},
    MissingType{tree_other, "this type", "see idl/README.md for those it knows"}};

std::string quoted(const char* text) {
  static constexpr char kHex[] = "0123456789abcdef";
  std::string out = "\"";
  for (; *text != '\0'; ++text) {
    const auto c = static_cast<unsigned char>(*text);
    if (c == '"' || c == '\\') {
      out += {'\\', *text};
    } else if (c < 0x20 || c > 0x7e) {  // the empty literal ends the escape sequence
      out += {'\\', 'x', kHex[c >> 4], kHex[c & 15], '"', '"'};
    } else {
      out += *text;
    }
  }
  return out + "\"";
}

std::string floating(double value) {
  if (!std::isfinite(value)) return "0.0";
  std::array<char, 40> text{};
  std::snprintf(text.data(), text.size(), "%.17g", value);
  std::string out = text.data();
  return out.find_first_of(".e") == out.npos ? out + ".0" : out;
}

}  // namespace

void Refusals::refuse(const void* node, const std::string& what, const std::string& to_do) {
  any_ = true;
  tree_error(state_, node, ("ddssec cannot do " + what + ": " + to_do).c_str());
}

std::string cpp_name(const void* node) {
  const std::string name = tree_name(node);
  return std::ranges::find(kKeywords, name) == kKeywords.end() ? name : name + "_";
}

std::string scoped_name(const void* node) {
  std::string out = tree_name(node);
  for (const auto* at = tree_module_of(node); at != nullptr; at = tree_module_of(at))
    out = std::string(tree_name(at)) + "::" + out;
  return out;
}

std::optional<std::string> literal_text(const void* value) {
  const auto kind = tree_kind_of(value);
  const auto number = tree_integer(value);
  if (kind == tree_bool) return number != 0 ? "true" : "false";
  if (kind == tree_float) return floating(tree_real(value)) + "f";
  if (kind == tree_double) return floating(tree_real(value));
  if (kind == tree_string) return quoted(tree_text(value));
  if (kind == tree_uint64) return std::to_string(static_cast<std::uint64_t>(number)) + "u";
  if (kind == tree_uint32) return std::to_string(number) + "u";
  // The smallest value of 64 bits has no literal.
  if (number == std::numeric_limits<std::int64_t>::min()) return "-9223372036854775807 - 1";
  if (kind >= tree_char && kind <= tree_int64) return std::to_string(number);
  return std::nullopt;
}

std::string CppTypes::qualified(const void* node) const {
  std::string out = cpp_name(node);
  for (const auto* at = tree_module_of(node); at != nullptr; at = tree_module_of(at))
    out = cpp_name(at) + "::" + out;
  return prefix_ + out;
}

CppType CppTypes::scalar(const void* spec) {
  const auto kind = tree_kind_of(spec);
  for (const auto& known : kPrimitives)
    if (known.kind == kind) return {known.text, kind == tree_bool ? " = false" : " = 0"};
  if (kind == tree_string) return {"std::string", "", tree_bound(spec)};
  if (kind == tree_sequence) return sequence(spec);
  if (kind == tree_struct || kind == tree_forward) return {qualified(spec), ""};
  if (kind == tree_enum)
    return {qualified(spec), " = " + qualified(spec) + "::" + cpp_name(tree_value(spec))};
  for (const auto& missing : kMissing)
    if (missing.kind == kind) refusals_.refuse(spec, missing.what, missing.to_do);
  return {"void", ""};
}

CppType CppTypes::sequence(const void* spec) {
  const auto element = of(tree_type(spec), nullptr);
  if (element.element_bound > 0)
    refusals_.refuse(spec, "bounds three deep", "leave the innermost bound out");
  return {"std::vector<" + element.text + ">", "", tree_bound(spec), element.bound};
}

CppType CppTypes::alias(const void* name) {
  auto type = of(tree_type(name), name);
  type.text = qualified(name);
  return type;
}

CppType CppTypes::of(const void* spec, const void* name) {
  auto type = tree_kind_of(spec) == tree_alias ? alias(spec) : scalar(spec);
  if (name == nullptr || tree_dimension(name, 0) == 0) return type;
  std::vector<std::uint32_t> sizes;
  for (unsigned i = 0; tree_dimension(name, i) != 0; ++i) sizes.push_back(tree_dimension(name, i));
  for (auto at = sizes.rbegin(); at != sizes.rend(); ++at)
    type.text = "std::array<" + type.text + ", " + std::to_string(*at) + ">";
  type.initial = "{}";
  return type;
}

}  // namespace ddssec::idl
