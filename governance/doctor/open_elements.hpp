// The elements of a configuration of Cyclone DDS that are open while it is read. For
// governance/doctor/ only.
#pragma once

#include <cstddef>
#include <ranges>
#include <string>
#include <utility>
#include <vector>

#include "governance/doctor/markup.hpp"

namespace ddssec::governance::doctor {

/// An element whose end tag was not read yet.
struct OpenElement {
  std::string name;
  std::string spelled;  ///< the name as it is written
  int line;
  bool is_for_other_domain;
  std::string id = {};        ///< the Id of a <Domain>
  bool has_values = false;    ///< an attribute or a text was seen in it, at any depth
  bool has_elements = false;  ///< an element was seen directly inside
  bool has_text = false;      ///< a text was seen directly inside
  bool has_security = false;  ///< a <Domain> in which a <Security> was seen
  std::string path = {};      ///< path from a known section on (section_elements.hpp)
  std::string place = {};     ///< the same for elements that are the same one in a <Domain>
};

/// The open elements, from the outermost to the innermost one.
class OpenElements {
 public:
  std::size_t depth() const { return elements_.size(); }
  bool is_empty() const { return elements_.empty(); }
  const std::vector<OpenElement>& all() const { return elements_; }
  OpenElement& innermost() { return elements_.back(); }
  const OpenElement& innermost() const { return elements_.back(); }
  /// The element that contains the innermost one, which must not be the outermost one.
  OpenElement& parent() { return elements_[depth() - 2]; }
  const OpenElement& parent() const { return elements_[depth() - 2]; }
  /// The element that contains that one.
  const OpenElement& grandparent() const { return elements_[depth() - 3]; }

  void open(const Markup::Token& token) {
    const bool is_other = !is_empty() && innermost().is_for_other_domain;
    if (!is_empty()) innermost().has_elements = true;
    elements_.push_back({token.name, token.spelled, token.line, is_other});
  }
  void close() { elements_.pop_back(); }
  /// True if the end tag ends the innermost element. In an environment variable, </> does, too.
  bool is_ended_by(const Markup::Token& token) const {
    const bool is_anonymous = token.name.empty() && token.is_inline;
    return !is_empty() && (is_anonymous || token.spelled == innermost().spelled);
  }
  /// Notes in all of them that they have a value. The elements around one that is marked are marked
  /// already.
  void mark_values() {
    for (auto& one : std::views::reverse(elements_))
      if (std::exchange(one.has_values, true)) return;
  }

  /// True if the innermost element is directly below <CycloneDDS>.
  bool is_below_root() const { return depth() == 2 && elements_[0].name == "cyclonedds"; }
  /// True if it is directly below a <Domain>.
  bool is_below_domain() const {
    return depth() >= 2 && parent().name == "domain" &&
           (depth() == 2 || (depth() == 3 && elements_[0].name == "cyclonedds"));
  }

 private:
  std::vector<OpenElement> elements_;
};

}  // namespace ddssec::governance::doctor
