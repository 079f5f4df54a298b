#include "idl/header.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <span>

namespace ddssec::idl {
namespace {

// The type of an enumeration on the wire (XTypes 7.2.2.4.1.2).
const char* underlying(const void* enumeration) {
  const auto bits = tree_bit_bound(enumeration);
  if (bits == 0 || bits > 16) return "std::int32_t";
  return bits <= 8 ? "std::int8_t" : "std::int16_t";
}

// Returns text such as "  static constexpr std::array<std::uint8_t, 3> NAME = {1, 2, 3};".
std::string octets_named(const char* name, std::span<const std::uint8_t> octets) {
  std::string out = "  static constexpr std::array<std::uint8_t, " + std::to_string(octets.size()) +
                    "> " + name + " = {";
  for (std::size_t i = 0; i < octets.size(); ++i)
    out += (i % 24 == 0 ? "\n      " : " ") + std::to_string(octets[i]) + ",";
  return out + "};\n";
}

struct Free {
  void operator()(std::uint8_t* octets) const { std::free(octets); }
};

std::string stem_of(const char* path) { return std::filesystem::path(path).stem().string(); }

struct RefusedConstruct {
  tree_flag flag;
  const char* what;
  const char* to_do;
};
constexpr std::array kRefused = {
    RefusedConstruct{tree_inherits, "inheritance", "make the base type a member"},
    RefusedConstruct{tree_mutable, "@mutable", "make it @appendable"},
    RefusedConstruct{tree_keylist, "#pragma keylist", "write @key before the members"},
    RefusedConstruct{tree_hashed_ids, "@autoid(HASH)",
                     "leave it out: ids follow the order of members"},
    RefusedConstruct{
        tree_representation, "@data_representation",
        "leave it out: the QoS policy DATA_REPRESENTATION of writers and readers says it"},
    RefusedConstruct{tree_optional, "@optional", "use a sequence with the bound 1"},
    RefusedConstruct{tree_external, "@external", "leave it out"},
    RefusedConstruct{tree_own_id, "@id and @hashid",
                     "leave it out: ids follow the order of members"}};

}  // namespace

Header::Header(const tree_state* state, const std::string& root)
    : state_(state), root_(root), refusals_(state), types_(root, refusals_) {}

std::optional<std::string> Header::make() {
  definitions(tree_root(state_));
  if (refusals_.any()) return std::nullopt;
  const auto own = stem_of(tree_file(state_));
  std::string out = "// Made from " + own +
                    ".idl by ddssec_idl_generate: change that one instead.\n#pragma once\n\n";
  std::string includes = "#include \"rtps/cdr/type.hpp\"\n";
  for (unsigned i = 0; const auto* file = tree_included_file(state_, i); ++i) {
    const auto stem = stem_of(file);
    out += "#if !__has_include(\"" + stem + ".hpp\")\n#error \"" + own + ".idl includes " + stem +
           ".idl: name that in ddssec_idl_generate too, or link the target that does\"\n#endif\n";
    includes += "#include \"" + stem + ".hpp\"\n";
  }
  out += includes;
  if (!root_.empty())
    declared_ = "namespace " + root_ + " {\n" + declared_ + "}  // namespace " + root_ + "\n";
  return out + "\n" + declared_ + traits_;
}

void Header::definitions(const void* first) {
  for (const auto* node = first; node != nullptr; node = tree_next(node)) {
    if (tree_kind_of(node) != tree_module) {
      if (tree_is_own(state_, node)) definition(node);
      continue;
    }
    const auto name = cpp_name(node);
    const auto before = declared_.size();
    declared_ += "namespace " + name + " {\n";
    const auto inside = declared_.size();
    definitions(tree_first(node));
    if (declared_.size() == inside)
      declared_.resize(before);
    else
      declared_ += "}  // namespace " + name + "\n";
  }
}

void Header::definition(const void* node) {
  switch (tree_kind_of(node)) {
    case tree_forward:
      declared_ += "struct " + cpp_name(node) + ";\n";
      break;
    case tree_enum:
      return enumeration(node);
    case tree_struct:
      return structure(node);
    case tree_typedef:
      return aliases(node);
    case tree_const:
      return constant(node);
    case tree_union:
    case tree_bitmask:
      static_cast<void>(types_.of(node, nullptr));  // reports what to do instead
      break;
    default:
      break;
  }
}

void Header::enumeration(const void* which) {
  std::string values, labels;
  std::size_t count = 0;
  for (const auto* at = tree_first(which); at != nullptr; at = tree_next(at), ++count) {
    const auto value = std::to_string(tree_integer(at));
    values += "  " + cpp_name(at) + " = " + value + ",\n";
    labels += (count == 0 ? "{\"" : ", {\"") + std::string(tree_name(at)) + "\", " + value + "}";
  }
  declared_ +=
      "enum class " + cpp_name(which) + " : " + underlying(which) + " {\n" + values + "};\n";
  traits_ +=
      "template <>\nstruct ddssec::rtps::EnumTraits<" + types_.qualified(which) +
      "> {\n  static constexpr std::string_view type_name = \"" + scoped_name(which) +
      "\";\n  static constexpr bool by_width = true;\n  static constexpr std::array<EnumLabel, " +
      std::to_string(count) + "> labels = {{" + labels + "}};\n};\n";
}

bool Header::accepts(const void* node) {
  const auto flags = tree_flags(node);
  for (const auto& each : kRefused)
    if ((flags & each.flag) != 0) refusals_.refuse(node, each.what, each.to_do);
  return !refusals_.any();
}

bool Header::accepts_nesting(const void* structure) {
  switch (nesting_.of(structure)) {
    case Nesting::fine:
      return true;
    case Nesting::recursive:
      refusals_.refuse(structure, "a recursive type",
                       "keep all nodes in one sequence, and in each the positions of its children");
      return false;
    case Nesting::before_definition:
      refusals_.refuse(structure, "a member of a type before its definition",
                       "move that definition up; a forward declaration is not enough");
      return false;
  }
  return false;
}

std::string Header::value_text(const void* value, const CppType& type) {
  if (value == nullptr) return type.initial;
  if (tree_kind_of(value) == tree_enumerator) return " = " + type.text + "::" + cpp_name(value);
  const auto text = literal_text(value);
  return text ? " = " + *text : type.initial;
}

// Adds the member to the struct and returns its entry in the traits.
Header::Member Header::member(const void* member, const void* name) {
  const auto type = types_.of(tree_type(member), name);
  const auto cpp = cpp_name(name);
  declared_ += "  " + type.text + " " + cpp + value_text(tree_value(member), type) + ";\n";
  auto text = "self." + cpp;
  if ((tree_flags(member) & tree_key) != 0)
    text = "key(" + text + (type.bound > 0 ? ", " + std::to_string(type.bound) : "") + ")";
  else if (type.bound > 0)
    text = "bounded(" + text + ", " + std::to_string(type.bound) + ")";
  if (type.element_bound > 0)
    text = "with_element_bound(" + text + ", " + std::to_string(type.element_bound) + ")";
  return {"named(\"" + std::string(tree_name(name)) + "\", " + text + ")", cpp};
}

void Header::structure(const void* which) {
  if (!accepts(which) || !accepts_nesting(which)) return;
  std::vector<Member> members;
  declared_ += "struct " + cpp_name(which) + " {\n";
  for (const auto* at = tree_first(which); at != nullptr; at = tree_next(at)) {
    if (!accepts(at)) continue;
    for (const auto* name = tree_first(at); name != nullptr; name = tree_next(name))
      if (accepts(name)) members.push_back(member(at, name));
  }
  declared_ += "\n  bool operator==(const " + cpp_name(which) + "&) const = default;\n};\n";
  // idlc aborts while it computes the TypeInformation of a type with wchar.
  if (refusals_.any()) return;
  if (members.empty())
    refusals_.refuse(which, "a struct without members", "give it one");
  else
    traits(which, members);
}

// Returns the declarations of the type's TypeInformation and type objects. Only the minimal part of
// the map is used: its first member, a sequence whose DHEADER counts its octets.
std::string Header::type_description(const void* which) {
  std::uint8_t* octets[2] = {};
  std::size_t sizes[2] = {};
  if (!tree_type_description(state_, which, octets, sizes)) return {};
  const std::unique_ptr<std::uint8_t, Free> information(octets[0]), map(octets[1]);
  std::size_t minimal = 0;
  for (int i = 3; i >= 0 && sizes[1] >= 4; --i) minimal = minimal << 8 | map.get()[i];
  return octets_named("type_information", {information.get(), sizes[0]}) +
         octets_named("type_objects", {map.get(), std::min(sizes[1], minimal + 4)});
}

// Returns the declaration from which the compiler sees whether the type is flat. An appendable one
// never is.
std::string Header::layout(const std::string& type, const std::vector<Member>& members) {
  std::string list;
  for (const auto& [entry, name] : members)
    list += (list.empty() ? "{offsetof(" : ",\n       {offsetof(") + type + ", " + name +
            "), kFlatSize<decltype(" + type + "::" + name + ")>}";
  return "  static constexpr std::array<MemberPlace, " + std::to_string(members.size()) +
         "> layout = {\n      {" + list + "}};\n";
}

void Header::traits(const void* which, const std::vector<Member>& members) {
  std::string list;
  for (const auto& each : members) list += (list.empty() ? "" : ",\n          ") + each.entry;
  const bool appendable = (tree_flags(which) & tree_appendable) != 0;
  traits_ += "template <>\nstruct ddssec::rtps::TypeTraits<" + types_.qualified(which) +
             "> {\n  static constexpr std::string_view type_name = \"" + scoped_name(which) +
             "\";\n  static constexpr auto extensibility = Extensibility::" +
             (appendable ? "appendable" : "final_type") + ";\n" +
             (appendable ? "" : layout(types_.qualified(which), members)) +
             type_description(which) +
             "  template <class Self, class Visit>\n"
             "  static void members(Self& self, Visit&& visit) {\n    visit(" +
             list + ");\n  }\n};\n";
}

void Header::aliases(const void* which) {
  for (const auto* name = tree_first(which); name != nullptr; name = tree_next(name))
    declared_ += "using " + cpp_name(name) + " = " + types_.of(tree_type(name), name).text + ";\n";
}

void Header::constant(const void* which) {
  const auto* spec = tree_type(which);
  auto type = tree_kind_of(spec) == tree_string ? CppType{"std::string_view", ""}
                                                : types_.of(spec, nullptr);
  const auto value = value_text(tree_value(which), type);
  declared_ += "inline constexpr " + type.text + " " + cpp_name(which) + value + ";\n";
}

}  // namespace ddssec::idl
