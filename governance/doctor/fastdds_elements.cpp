#include "governance/doctor/fastdds_elements.hpp"

#include <algorithm>
#include <charconv>
#include <set>
#include <string>

#include <fmt/format.h>

#include "base/ids.hpp"
#include "base/text.hpp"

namespace ddssec::governance::doctor {
namespace {

constexpr std::size_t kMaxDoubts = 10;
constexpr int kMaxNumber = 2147483647;

// The kind of content that an element has.
enum class Form : std::uint8_t {
  group,    // elements
  list,     // elements; may be repeated
  profile,  // elements, with a name that is unique
  text,
  texts,      // text; may be repeated
  transport,  // the id of a transport described above; may be repeated
  keyword,
  boolean,
  number,
  octet,
  port,
  domain,
  seconds,
  address,
};

struct Element {
  std::string_view path;
  Form form;
  std::string_view keywords;
};
constexpr Element kElements[] = {
#define X(path, form, keywords) {path, Form::form, keywords},
#include "governance/doctor/fastdds_elements.def"
#undef X
};

constexpr std::string_view kEndpoints[] = {"data_writer", "data_reader", "publisher", "subscriber"};
constexpr std::string_view kPolicy = "participant/rtps/propertiesPolicy";
constexpr std::string_view kProperties = "participant/rtps/propertiesPolicy/properties";

bool is_in_every_version(std::string_view path) {
  return path == "participant" || path == "participant/rtps" || path == "participant/rtps/name" ||
         path == kPolicy || path.starts_with(kProperties);
}

const Element* find_element(std::string_view path) {
  const auto* const found = std::ranges::find(kElements, path, &Element::path);
  return found == std::end(kElements) ? nullptr : found;
}

bool has_elements(Form form) {
  return form == Form::group || form == Form::list || form == Form::profile;
}
bool may_repeat(Form form) {
  return form == Form::list || form == Form::profile || form == Form::texts ||
         form == Form::transport;
}

bool is_number(std::string_view text, int limit) {
  int value = 0;
  const auto* const end = text.data() + text.size();
  const auto read = std::from_chars(text.data(), end, value);
  return !text.starts_with('-') && read.ec == std::errc() && read.ptr == end && value <= limit;
}

bool is_address(std::string_view text) {
  for (int part = 0; part < 4; ++part) {
    const auto dot = std::min(text.find('.'), text.size());
    if (!is_number(text.substr(0, dot), 255) || (dot == text.size()) != (part == 3)) return false;
    text.remove_prefix(part == 3 ? dot : dot + 1);
  }
  return true;
}

bool is_keyword(std::string_view text, std::string_view keywords) {
  while (!keywords.empty()) {
    const auto end = std::min(keywords.find('|'), keywords.size());
    if (keywords.substr(0, end) == text) return true;
    keywords.remove_prefix(std::min(end + 1, keywords.size()));
  }
  return false;
}

bool has_form(std::string_view text, const Element& element) {
  switch (element.form) {
    case Form::keyword:
      return is_keyword(text, element.keywords);
    case Form::boolean:
      return text == "true" || text == "false";
    case Form::number:
      return is_number(text, kMaxNumber);
    case Form::octet:
      return is_number(text, 255);
    case Form::port:
      return is_number(text, 65535);
    case Form::domain:
      return is_number(text, kMaxDomainId);
    case Form::seconds:
      return text == "DURATION_INFINITY" || is_number(text, kMaxNumber);
    case Form::address:
      return is_address(text);
    default:
      return !trimmed(text, " \t\r\n").empty();
  }
}

class Forms {
 public:
  explicit Forms(Version version) : is_newer_(version.major > 2) {}

  std::vector<ConfiguredText> doubts_below(XmlElement root) {
    if (root.name() == "dds") {
      diagnose_attributes(root, {});
      root = only_profiles(root);
    }
    if (root) {
      diagnose_attributes(root, {});
      diagnose_children(root, "");
    }
    return std::move(doubts_);
  }

 private:
  void doubt(XmlElement at, std::string what) {
    if (doubts_.size() < kMaxDoubts) doubts_.push_back({std::move(what), at.line()});
  }

  XmlElement only_profiles(XmlElement root) {
    XmlElement out;
    for (auto child = root.first_child(); child; child = child.next_sibling()) {
      if (child.name() != "profiles")
        doubt(child, fmt::format("has {} beside <profiles>", in_brackets(child.name())));
      else if (out)
        doubt(child, "has a second <profiles>");
      else
        out = child;
    }
    return out;
  }

  void diagnose_attributes(XmlElement at, const std::vector<std::string_view>& known) {
    for (const auto name : at.attribute_names()) {
      const bool is_namespace = name.starts_with("xmlns") || name.starts_with("xsi:");
      if (!is_namespace && std::ranges::find(known, name) == known.end())
        doubt(at, fmt::format("has the attribute {} in {}", name, in_brackets(at.name())));
    }
  }

  void diagnose_children(XmlElement parent, const std::string& path) {
    std::set<std::string_view> seen;
    for (auto child = parent.first_child(); child; child = child.next_sibling()) {
      const bool is_endpoint =
          path.empty() && std::ranges::find(kEndpoints, child.name()) != std::end(kEndpoints);
      const std::string_view name = is_endpoint ? "endpoint" : child.name();
      const auto inner = path.empty() ? std::string(name) : fmt::format("{}/{}", path, name);
      const auto* const element = find_element(inner);
      if (element == nullptr || (is_newer_ && !is_in_every_version(inner))) {
        doubt(child,
              fmt::format("has {} in {}", in_brackets(child.name()), in_brackets(parent.name())));
        continue;
      }
      if (!seen.insert(child.name()).second && !may_repeat(element->form))
        doubt(child, fmt::format("has a second {} in {}", in_brackets(child.name()),
                                 in_brackets(parent.name())));
      diagnose_element(child, *element);
    }
    if (seen.empty() && !path.empty())
      doubt(parent,
            fmt::format("has {} without an element that is known", in_brackets(parent.name())));
  }

  void diagnose_element(XmlElement at, const Element& element) {
    if (element.path == "participant") properties_.clear();
    if (element.form == Form::profile)
      diagnose_profile_name(at);
    else
      diagnose_attributes(at, {});
    if (!has_elements(element.form)) return diagnose_value(at, element);
    diagnose_children(at, std::string(element.path));
    diagnose_required(at, element.path);
  }

  void diagnose_required(XmlElement at, std::string_view path) {
    for (const auto& [parent, child] : kRequired) {
      if (parent != path) continue;
      bool is_there = false;
      for (auto one = at.first_child(); one; one = one.next_sibling())
        is_there = is_there || one.name() == child;
      if (!is_there)
        doubt(at, fmt::format("has no {} in {}", in_brackets(child), in_brackets(at.name())));
    }
  }

  void diagnose_profile_name(XmlElement profile) {
    diagnose_attributes(profile, {"profile_name", "is_default_profile"});
    const char* const name = profile.attribute("profile_name");
    if (name == nullptr || *name == '\0')
      doubt(profile, fmt::format("has {} without a profile_name", in_brackets(profile.name())));
    else if (!profiles_.insert(name).second)
      doubt(profile, fmt::format("has two profiles with the name \"{}\"", name));
    const char* const given = profile.attribute("is_default_profile");
    if (given == nullptr) return;
    const std::string_view text = given;
    if (text != "true" && text != "false")
      doubt(profile, fmt::format("has is_default_profile=\"{}\"", text));
    if (text == "true" && !defaults_.insert(std::string(profile.name())).second)
      doubt(profile, fmt::format("has a second {} with is_default_profile=\"true\"",
                                 in_brackets(profile.name())));
  }

  // The value of a property is not shown: it may be a password.
  void diagnose_value(XmlElement at, const Element& element) {
    const auto text = at.raw_text();
    const bool is_known = text && has_form(*text, element);
    const bool is_shown = text && !element.path.starts_with(kPolicy);
    if (!is_known)
      return doubt(at, fmt::format("has {} with {}", in_brackets(at.name()),
                                   is_shown ? fmt::format("the value \"{}\"", *text)
                                            : std::string("a value that is empty or in pieces")));
    if (element.path.ends_with("/transport_descriptor/transport_id") &&
        !transports_.insert(*text).second)
      doubt(at, fmt::format("has two transports with the id \"{}\"", *text));
    if (element.form == Form::transport && !transports_.contains(*text))
      doubt(at, fmt::format("names the transport \"{}\" before it is described", *text));
    if (element.path == kPropertyName && !properties_.insert(*text).second)
      doubt(at, fmt::format("has the property {} twice", *text));
  }

  struct RequiredChild {
    std::string_view parent;
    std::string_view child;
  };
  static constexpr RequiredChild kRequired[] = {
      {"participant", "rtps"},
      {"participant/rtps/propertiesPolicy/properties/property", "name"},
      {"participant/rtps/propertiesPolicy/properties/property", "value"},
      {"transport_descriptors/transport_descriptor", "transport_id"},
      {"transport_descriptors/transport_descriptor", "type"},
  };
  static constexpr std::string_view kPropertyName =
      "participant/rtps/propertiesPolicy/properties/property/name";

  bool is_newer_;
  std::set<std::string> profiles_;
  std::set<std::string> defaults_;
  std::set<std::string> transports_;
  std::set<std::string> properties_;
  std::vector<ConfiguredText> doubts_;
};

}  // namespace

std::vector<ConfiguredText> doubts_about_profiles(XmlElement root, Version version) {
  return Forms(version).doubts_below(root);
}

}  // namespace ddssec::governance::doctor
