#include <algorithm>
#include <array>
#include <list>

#include "governance/ros_policy.hpp"
#include "governance/xml.hpp"
#include "governance/xml_check.hpp"

namespace ddssec::governance {
namespace {

namespace fs = std::filesystem;

constexpr std::array<std::string_view, 2> kXIncludeNamespaces = {"http://www.w3.org/2001/XInclude",
                                                                 "http://www.w3.org/2003/XInclude"};

// An element and the file it is in.
struct Node {
  XmlElement element;
  fs::path file;
};

std::unexpected<Error> element_error(Code code, const Node& at, std::string expected,
                                     std::string found) {
  return fail(code, {.document = at.file,
                     .line = at.element.line(),
                     .field = in_brackets(at.element.name()),
                     .expected = std::move(expected),
                     .found = std::move(found)});
}

std::string text_of(const char* attribute) { return attribute == nullptr ? "" : attribute; }

// The element names of `xpointer(/a/b/*)`. An xpointer of another form is an error.
Result<std::vector<std::string>> steps_of(const Node& include) {
  const auto text = text_of(include.element.attribute("xpointer"));
  constexpr std::string_view kBegin = "xpointer(/", kEnd = "/*)";
  const auto wrong = [&] {
    return element_error(Code::policy_include, include, "xpointer(/NAME/*)", text);
  };
  if (!text.starts_with(kBegin) || !text.ends_with(kEnd) ||
      text.size() <= kBegin.size() + kEnd.size())
    return wrong();
  std::vector<std::string> out(1);
  for (const char c :
       std::string_view(text).substr(kBegin.size(), text.size() - kBegin.size() - kEnd.size())) {
    if (c == '/')
      out.emplace_back();
    else if (c == '_' || (c >= 'a' && c <= 'z'))
      out.back() += c;
    else
      return wrong();
  }
  if (std::ranges::any_of(out, &std::string::empty)) return wrong();
  return out;
}

// Expands includes, and stores every file that it reads.
class Policies {
 public:
  explicit Policies(const ReadFile& read) : read_(read) {}

  Result<Node> open(const fs::path& file) {
    DDSSEC_ASSIGN_OR_RETURN(const auto octets, read_(file));
    octets_ += octets.size();
    if (octets_ > kMaxXmlOctets) return fail(Code::xml_too_large, {.document = file});
    DDSSEC_ASSIGN_OR_RETURN(auto document, with_default_document(XmlDocument::parse(octets), file));
    return Node{documents_.emplace_back(std::move(document)).root(), file};
  }

  // The children; includes are replaced by their content.
  Result<std::vector<Node>> children(const Node& parent, int depth = 0) {
    DDSSEC_RETURN_IF_ERROR(with_default_document(parent.element.check_no_text(), parent.file));
    std::vector<Node> out;
    for (auto child = parent.element.first_child(); child; child = child.next_sibling()) {
      const Node node{child, parent.file};
      if (!is_include(child)) {
        out.push_back(node);
        continue;
      }
      DDSSEC_ASSIGN_OR_RETURN(auto nodes, includes(node, depth));
      for (auto& included : nodes) out.push_back(std::move(included));
    }
    return out;
  }

 private:
  // True for an include element whose prefix is bound to XInclude, here or above.
  static bool is_include(XmlElement element) {
    const auto name = element.name();
    const auto colon = name.find(':');
    if (colon == name.npos || name.substr(colon + 1) != "include") return false;
    const auto binding = "xmlns:" + std::string(name.substr(0, colon));
    for (auto at = element; at; at = at.parent())
      if (const char* bound = at.attribute(binding.c_str()))
        return std::ranges::find(kXIncludeNamespaces, bound) != kXIncludeNamespaces.end();
    return false;
  }

  Result<std::vector<Node>> includes(const Node& include, int depth) {
    if (depth >= kMaxIncludeDepth || ++count_ > kMaxIncludes)
      return element_error(Code::policy_include, include, "files that do not include one another",
                           "");
    const auto href = text_of(include.element.attribute("href"));
    const fs::path path(href);
    const bool leaves = std::ranges::find(path, fs::path("..")) != path.end();
    if (href.empty() || path.is_absolute() || leaves || href.find(':') != href.npos)
      return element_error(Code::policy_include, include, "a file beside or below this one", href);
    DDSSEC_ASSIGN_OR_RETURN(const auto steps, steps_of(include));
    DDSSEC_ASSIGN_OR_RETURN(auto opened, open(include.file.parent_path() / path));
    std::vector<Node> found = {std::move(opened)};
    if (found[0].element.name() != steps[0]) found.clear();
    for (std::size_t i = 1; i <= steps.size(); ++i) {
      std::vector<Node> next;
      for (const auto& node : found) {
        DDSSEC_ASSIGN_OR_RETURN(auto nodes, children(node, depth + 1));
        for (auto& child : nodes)
          if (i == steps.size() || child.element.name() == steps[i])
            next.push_back(std::move(child));
      }
      found = std::move(next);
    }
    if (found.empty())
      return element_error(Code::policy_include, include, "elements there", "none");
    return found;
  }

  const ReadFile& read_;
  std::list<XmlDocument> documents_;
  int count_ = 0;
  std::size_t octets_ = 0;  // size of all files together
};

// The names of the elements and attributes of a policy.
struct Words {
  RosKind kind;
  std::string_view list, item, first, second;
};
constexpr std::array<Words, 3> kWords = {
    {{RosKind::topics, "topics", "topic", "publish", "subscribe"},
     {RosKind::services, "services", "service", "reply", "request"},
     {RosKind::actions, "actions", "action", "call", "execute"}}};

bool is_xml_attribute(std::string_view name) {
  return name == "xmlns" || name.starts_with("xmlns:") || name.starts_with("xml:") ||
         name.starts_with("xsi:");
}

Status check_attributes(const Node& node, std::initializer_list<std::string_view> known) {
  for (const auto name : node.element.attribute_names())
    if (!is_xml_attribute(name) && std::ranges::find(known, name) == known.end())
      return element_error(Code::attribute_unknown, node, "", std::string(name));
  return {};
}

Result<RosQualifier> qualifier(const Node& node, std::string_view name) {
  const char* value = node.element.attribute(std::string(name).c_str());
  if (value == nullptr) return RosQualifier::unsaid;
  if (std::string_view(value) == "ALLOW") return RosQualifier::allow;
  if (std::string_view(value) == "DENY") return RosQualifier::deny;
  return element_error(Code::policy_value, node, std::string(name) + "=ALLOW or DENY", value);
}

std::unexpected<Error> unknown_element_error(const Node& node) {
  return fail(Code::element_unknown, {.document = node.file,
                                      .line = node.element.line(),
                                      .field = in_brackets(node.element.name())});
}

Status require(const Node& node, bool there, std::string_view what) {
  if (there) return {};
  return element_error(Code::element_missing, node, std::string(what), "");
}

// Reads the policy's elements from the outside in.
class PolicyReader {
 public:
  explicit PolicyReader(Policies& policies) : policies_(policies) {}

  Result<RosPolicy> policy(const Node& root) {
    if (root.element.name() != "policy")
      return element_error(Code::document_kind, root, "<policy>", std::string(root.element.name()));
    DDSSEC_RETURN_IF_ERROR(check_attributes(root, {"version"}));
    if (const auto version = text_of(root.element.attribute("version")); version != "0.2.0")
      return element_error(Code::policy_value, root, "version 0.2.0", version);
    RosPolicy out;
    DDSSEC_ASSIGN_OR_RETURN(const auto nodes, named_children(root, "enclaves"));
    for (const auto& enclaves : nodes) {
      DDSSEC_ASSIGN_OR_RETURN(const auto children, named_children(enclaves, "enclave"));
      for (const auto& node : children) {
        DDSSEC_ASSIGN_OR_RETURN(auto ros_enclave, enclave(node));
        out.enclaves.push_back(std::move(ros_enclave));
      }
    }
    DDSSEC_RETURN_IF_ERROR(require(root, !out.enclaves.empty(), "<enclave>"));
    return out;
  }

 private:
  Result<std::vector<Node>> named_children(const Node& parent, std::string_view name,
                                           std::string_view or_ignored = {}) {
    DDSSEC_ASSIGN_OR_RETURN(auto all, policies_.children(parent));
    std::erase_if(all, [&](const Node& n) { return n.element.name() == or_ignored; });
    for (const auto& node : all)
      if (node.element.name() != name) return unknown_element_error(node);
    return all;
  }

  Result<RosEnclave> enclave(const Node& node) {
    DDSSEC_RETURN_IF_ERROR(check_attributes(node, {"path"}));
    RosEnclave out{.path = text_of(node.element.attribute("path")), .line = node.element.line()};
    if (!out.path.starts_with('/'))
      return element_error(Code::policy_value, node, "an absolute path", out.path);
    DDSSEC_ASSIGN_OR_RETURN(const auto nodes, named_children(node, "profiles"));
    for (const auto& profiles : nodes) {
      DDSSEC_RETURN_IF_ERROR(check_attributes(profiles, {"type"}));
      auto& list = out.profiles.emplace_back();
      DDSSEC_ASSIGN_OR_RETURN(const auto children, named_children(profiles, "profile", "metadata"));
      for (const auto& one : children) {
        DDSSEC_ASSIGN_OR_RETURN(auto ros_profile, profile(one));
        list.push_back(std::move(ros_profile));
      }
      DDSSEC_RETURN_IF_ERROR(require(profiles, !list.empty(), "<profile>"));
    }
    DDSSEC_RETURN_IF_ERROR(require(node, !out.profiles.empty(), "<profiles>"));
    return out;
  }

  Result<RosProfile> profile(const Node& node) {
    DDSSEC_RETURN_IF_ERROR(check_attributes(node, {"ns", "node"}));
    RosProfile out{text_of(node.element.attribute("ns")), text_of(node.element.attribute("node"))};
    if (!out.ns.starts_with('/') || out.node.empty())
      return element_error(Code::policy_value, node, "ns= an absolute namespace and node= a name",
                           out.ns + " " + out.node);
    DDSSEC_ASSIGN_OR_RETURN(const auto children, policies_.children(node));
    for (const auto& child : children) {
      DDSSEC_ASSIGN_OR_RETURN(auto ros_element, element(child));
      out.elements.push_back(std::move(ros_element));
    }
    return out;
  }

  Result<RosElement> element(const Node& node) {
    const auto words = std::ranges::find(kWords, node.element.name(), &Words::list);
    if (words == kWords.end()) return unknown_element_error(node);
    DDSSEC_RETURN_IF_ERROR(check_attributes(node, {words->first, words->second}));
    DDSSEC_ASSIGN_OR_RETURN(const auto first, qualifier(node, words->first));
    DDSSEC_ASSIGN_OR_RETURN(const auto second, qualifier(node, words->second));
    RosElement out{.kind = words->kind, .first = first, .second = second};
    DDSSEC_ASSIGN_OR_RETURN(const auto nodes, named_children(node, words->item));
    for (const auto& item : nodes) {
      DDSSEC_ASSIGN_OR_RETURN(auto name, with_default_document(item.element.raw_text(), item.file));
      if (name.empty()) return element_error(Code::element_empty, item, "a name", "");
      out.names.push_back(std::move(name));
    }
    DDSSEC_RETURN_IF_ERROR(require(node, !out.names.empty(), in_brackets(words->item)));
    return out;
  }

  Policies& policies_;
};

}  // namespace

Result<RosPolicy> read_ros_policy(const fs::path& file, const ReadFile& read) {
  Policies policies(read);
  DDSSEC_ASSIGN_OR_RETURN(const auto root, policies.open(file));
  return PolicyReader(policies).policy(root);
}

}  // namespace ddssec::governance
