#include "governance/doctor/effective_security.hpp"

#include <algorithm>
#include <charconv>
#include <set>
#include <span>
#include <utility>

#include <fmt/format.h>

#include "base/text.hpp"
#include "governance/doctor/configuration_findings.hpp"
#include "governance/doctor/markup.hpp"
#include "governance/doctor/open_elements.hpp"
#include "governance/doctor/section_elements.hpp"
#include "governance/doctor/security_section.hpp"

namespace ddssec::governance::doctor {
namespace {

constexpr std::string_view kBlanks = kMarkupBlanks;

// The elements directly below <CycloneDDS> and <Domain>, measured with 0.10.2 and 0.10.5, which do
// not differ.
constexpr std::string_view kSections[] = {
    "compatibility", "ddssecurity",  "discovery",  "general", "internal",
    "partitioning",  "sharedmemory", "sizing",     "ssl",     "tcp",
    "threads",       "tracing",      "unsupported"};
constexpr std::string_view kOfRoot[] = {"domain", "ddsi2e", "ddsi2eservice"};
constexpr std::string_view kOfDomain[] = {"id", "security"};
constexpr std::string_view kRootAttributes[] = {"xmlns", "xmlns:xsi", "xsi:schemalocation",
                                                "xsi:nonamespaceschemalocation"};

bool is_one_of(std::span<const std::string_view> names, std::string_view name) {
  return std::ranges::find(names, name) != names.end();
}

bool is_security(std::string_view name) { return name == "security" || name == "ddssecurity"; }

std::optional<DomainId> number_of(std::string_view word) {
  DomainId id = 0;
  if (word.starts_with('+') && !word.starts_with("+-")) word.remove_prefix(1);
  const auto* const end = word.data() + word.size();
  const auto read = std::from_chars(word.data(), end, id);
  if (word.empty() || read.ec != std::errc() || read.ptr != end) return std::nullopt;
  return id;
}

// Judges elements outside of <Security>: which of them Cyclone DDS knows, and which values are set
// twice.
class OtherSections {
 public:
  OtherSections(OpenElements& elements, ConfigurationFindings& findings, bool is_file)
      : elements_(elements), findings_(findings), is_file_(is_file) {}

  // Gives the innermost element a place of its own, in which no other value can be.
  void set_own_place() { elements_.innermost().place = fmt::format("#{}", count_++); }

  void on_start_tag(const Markup::Token& token) {
    refuse_unknown(token);
    doubt_unknown(token);
  }

  // Reports a value that a former element has set.
  void diagnose_single_value() {
    const auto& ended = elements_.innermost();
    if (ended.has_text && !values_.insert(ended.place).second)
      findings_.add_problem(ended.line, fmt::format("has <{}> twice", ended.name));
  }

 private:
  void refuse_unknown(const Markup::Token& token) {
    const bool is_below_root = elements_.is_below_root();
    if (!is_below_root && !elements_.is_below_domain()) return;
    const auto own = is_below_root ? std::span<const std::string_view>(kOfRoot) : kOfDomain;
    if (!is_one_of(kSections, token.name) && !is_one_of(own, token.name))
      findings_.add_problem(
          token.line,
          fmt::format("has <{}> inside <{}>, which Cyclone DDS does not know",
                      token.name.substr(0, 64), is_below_root ? "CycloneDDS" : "Domain"));
  }

  // Records an unknown element as a doubt, because other versions may know it (docs/decisions).
  void doubt_unknown(const Markup::Token& token) {
    const auto depth = elements_.depth();
    auto& own = elements_.innermost();
    const bool is_at_top = depth == 1 && !is_file_;
    if (is_at_top || elements_.is_below_root() || elements_.is_below_domain()) {
      own.path = section_path(token.name);
      if (own.path.empty()) return;
      own.place = fmt::format("{}/{}", depth > 1 ? elements_.parent().place : "", own.path);
      findings_.refuse_attributes(token);
    } else if (depth > 1 && !elements_.parent().path.empty()) {
      doubt_inside(token, elements_.parent());
    }
  }

  void doubt_inside(const Markup::Token& token, const OpenElement& parent) {
    auto& own = elements_.innermost();
    if (!is_known_inside(parent.path, token.name))
      return findings_.add_doubt(
          token.line, fmt::format("has <{}> inside <{}>", token.name.substr(0, 64), parent.name));
    own.path = path_inside(parent.path, token.name);
    // <Internal><FragmentSize> is the same as <General><FragmentSize>.
    const auto section = own.path.substr(0, own.path.find('/'));
    own.place = parent.path.starts_with(section)
                    ? fmt::format("{}/{}", parent.place, token.name)
                    : fmt::format("{}/{}", elements_.grandparent().place, own.path);
    if (is_repeated(own.path)) own.place += fmt::format("#{}", count_++);
    for (const auto& [name, value] : token.attributes) {
      if (!is_known_attribute(own.path, name))
        findings_.add_doubt(token.line, fmt::format("has the attribute {} in <{}>",
                                                    name.substr(0, 64), token.name));
      else if (!values_.insert(own.place + "@" + name).second)
        findings_.add_problem(token.line,
                              fmt::format("has the attribute {} of <{}> twice", name, token.name));
    }
  }

  OpenElements& elements_;
  ConfigurationFindings& findings_;
  bool is_file_;
  std::set<std::string> values_;  // the places of values, none of which may be set twice
  std::size_t count_ = 0;
};

// Reads the elements and stores those that apply.
class ConfigurationReader {
 public:
  ConfigurationReader(DomainId domain, ConfigurationPlace place, std::size_t inline_from)
      : domain_(domain),
        is_file_(place == ConfigurationPlace::file),
        inline_from_(is_file_ ? std::string_view::npos : inline_from) {}

  EffectiveSecurity read(std::string_view text) {
    Markup markup(text, inline_from_);
    bool is_inline = false;  // the rest of the text is in the variable itself
    for (;;) {
      const auto token = markup.next();
      if (token.is_inline && !std::exchange(is_inline, true)) refuse_open_elements();
      if (token.kind == Markup::Kind::end) break;
      if (token.kind == Markup::Kind::broken) {
        findings_.add_problem(token.line, "is not well-formed XML");
        return std::move(out_);
      }
      if (!read_token(token)) return std::move(out_);
    }
    if (!is_inline) refuse_open_elements();
    return std::move(out_);
  }

 private:
  bool read_token(const Markup::Token& token) {
    if (token.kind == Markup::Kind::close) return on_end_tag(token);
    if (token.kind == Markup::Kind::text) {
      on_text(token);
      return true;
    }
    on_start_tag(token);
    if (token.is_closed) on_end();
    return true;
  }

  // Reports an element that is still open when the file ends: what follows it is in another file,
  // or in the environment variable itself.
  void refuse_open_elements() {
    if (elements_.is_empty() || findings_.has_problems()) return;
    const auto& open = elements_.innermost();
    findings_.add_problem(open.line, fmt::format("has no end tag for <{}>",
                                                 std::string_view(open.name).substr(0, 64)));
  }

  bool on_end_tag(const Markup::Token& token) {
    if (elements_.is_ended_by(token)) {
      on_end();
      return true;
    }
    if (!elements_.is_empty() && token.name == elements_.innermost().name)
      findings_.add_problem(
          token.line, fmt::format("ends <{}> with </{}>, in another letter case",
                                  std::string_view(elements_.innermost().spelled).substr(0, 64),
                                  std::string_view(token.spelled).substr(0, 64)));
    else
      findings_.add_problem(token.line,
                            fmt::format("has an end tag </{}> that no start tag belongs to",
                                        token.name.substr(0, 64)));
    return false;
  }

  void on_end() {
    security_.on_end(elements_);
    if (is_old_id()) read_old_id();
    others_.diagnose_single_value();
    elements_.close();
    if (elements_.is_empty()) had_root_ = true;
  }

  void on_start_tag(const Markup::Token& token) {
    const bool is_other = !elements_.is_empty() && elements_.innermost().is_for_other_domain;
    elements_.open(token);
    others_.set_own_place();
    if (elements_.depth() == 1) is_file_ ? diagnose_root(token) : diagnose_part(token);
    if (security_.is_open()) return security_.on_start_tag(elements_, token);
    if (!is_other) others_.on_start_tag(token);
    if (is_old_id()) {
      old_id_.clear();
      findings_.refuse_attributes(token);
    } else if (!token.attributes.empty()) {
      elements_.mark_values();
    }
    if (token.name == "domain") return begin_domain(token);
    if (is_security(token.name) && is_at_its_place()) begin_security(token);
  }

  void diagnose_root(const Markup::Token& token) {
    if (had_root_) return findings_.add_problem(token.line, "goes on after </CycloneDDS>");
    if (token.name != "cyclonedds")
      return findings_.add_problem(
          token.line, fmt::format("begins with <{}>, and Cyclone DDS reads <CycloneDDS> only",
                                  token.name.substr(0, 64)));
    for (const auto& [name, value] : token.attributes)
      if (std::ranges::find(kRootAttributes, name) == std::end(kRootAttributes))
        findings_.add_unknown_attribute(token, name);
  }

  // Checks the first element in the variable: it may be <CycloneDDS>, <Domain> or an element from
  // inside a <Domain>.
  void diagnose_part(const Markup::Token& token) {
    if (token.name == "cyclonedds" || token.name == "domain") return;
    if (!is_one_of(kSections, token.name) && !is_one_of(kOfDomain, token.name))
      findings_.add_problem(token.line,
                            fmt::format("begins with <{}>, which Cyclone DDS does not know",
                                        token.name.substr(0, 64)));
  }

  // True for <Domain><Id>5</Id>, which Cyclone DDS still reads as <Domain Id="5">.
  bool is_old_id() const {
    return elements_.is_below_domain() && elements_.innermost().name == "id" &&
           !elements_.innermost().is_for_other_domain;
  }

  void read_old_id() {
    auto& domain = elements_.parent();
    const auto line = elements_.innermost().line;
    const auto id = std::string(trimmed(old_id_, kBlanks));
    const auto number = number_of(id);
    if (!id.empty() && ascii_lower(id) != "any") {
      if (!number) {
        findings_.add_problem(
            line,
            fmt::format("has <Id>{}</Id>, which is neither a number nor any", id.substr(0, 64)));
      } else if (*number != domain_) {
        if (domain.has_values)
          findings_.add_problem(
              line, fmt::format("has <Id>{}</Id> after other values of the same <Domain>",
                                id.substr(0, 64)));
        domain.is_for_other_domain = true;
        domain.id = id;
      }
    }
    elements_.mark_values();
  }

  // True if the <Security> is where it counts. In the variable it may also be in a part of a
  // document: <Domain>...</Domain>, <Security>...</Security>.
  bool is_at_its_place() const {
    if (!is_file_) return elements_.depth() <= 3;
    const bool is_former = elements_.is_below_root() && elements_.innermost().name == "ddssecurity";
    return is_former || (elements_.depth() == 3 && elements_.parent().name == "domain");
  }

  void begin_domain(const Markup::Token& token) {
    auto& domain = elements_.innermost();
    for (const auto& [name, value] : token.attributes) {
      if (domain.is_for_other_domain) return;  // Cyclone DDS reads no further
      if (name != "id") {
        findings_.add_unknown_attribute(token, name);
        continue;
      }
      domain.id = value;
      if (ascii_lower(value) == "any") continue;
      // Blanks may be before the number, but nowhere else.
      const auto first = std::min(value.find_first_not_of(kBlanks), value.size());
      const auto id = number_of(std::string_view(value).substr(first));
      if (!id)
        findings_.add_problem(
            token.line, fmt::format("has <Domain Id=\"{}\">, which is neither a number nor any",
                                    value.substr(0, 64)));
      else if (*id != domain_)
        domain.is_for_other_domain = true;
    }
  }

  void begin_security(const Markup::Token& token) {
    if (elements_.innermost().is_for_other_domain) {
      for (const auto& above : elements_.all())
        if (above.is_for_other_domain && !above.id.empty()) out_.other_domain = above.id;
      return;
    }
    if (elements_.depth() > 1) {
      auto& domain = elements_.parent();
      if (domain.has_security)
        findings_.add_problem(token.line,
                              fmt::format("has a second <{}> in one <Domain>", token.name));
      domain.has_security = true;
    }
    security_.begin(elements_, token);
  }

  void on_text(const Markup::Token& token) {
    if (security_.on_text(token)) return;
    if (is_old_id() && !elements_.innermost().has_elements) {
      old_id_ += token.name;
      return;
    }
    if (trimmed(token.name, kBlanks).empty()) return;
    if (elements_.is_empty()) {
      // In the variable the name of a file may follow after a comma.
      if (is_file_ || !trimmed(token.name, kBlanks).starts_with(','))
        findings_.add_problem(token.line, "has text outside of <CycloneDDS>");
      return;
    }
    auto& own = elements_.innermost();
    own.has_text = true;
    if (own.has_elements || is_list())
      findings_.add_problem(token.line, fmt::format("has text in <{}>, where only elements may be",
                                                    std::string_view(own.name).substr(0, 64)));
    elements_.mark_values();
  }

  // True where only elements are allowed. Cyclone DDS does not check options of other domains so
  // strictly.
  bool is_list() const {
    if (security_.is_open()) return true;
    const auto& own = elements_.innermost();
    if (has_elements_only(own.path)) return true;
    const bool is_outer =
        elements_.depth() <= 2 && (own.name == "cyclonedds" || own.name == "domain");
    return is_outer && !own.is_for_other_domain;
  }

  DomainId domain_;
  bool is_file_;
  std::size_t inline_from_;
  EffectiveSecurity out_ = {};
  ConfigurationFindings findings_{out_};
  OpenElements elements_ = {};
  SecuritySection security_{out_, findings_, domain_};
  OtherSections others_{elements_, findings_, is_file_};
  std::string old_id_ = {};  // the content of <Id> so far
  bool had_root_ = false;    // <CycloneDDS> has ended
};

const ConfiguredText* find_in(const std::vector<std::pair<std::string, ConfiguredText>>& texts,
                              std::string_view name) {
  for (const auto& [own, text] : texts)
    if (own == name) return &text;
  return nullptr;
}

}  // namespace

const ConfiguredText* ConfiguredPlugin::attribute(std::string_view name) const {
  return find_in(library, name);
}

const ConfiguredText* ConfiguredPlugin::value(std::string_view name) const {
  return find_in(values, name);
}

EffectiveSecurity effective_security(std::string_view text, DomainId domain,
                                     ConfigurationPlace place, std::size_t inline_from) {
  return ConfigurationReader(domain, place, inline_from).read(text);
}

}  // namespace ddssec::governance::doctor
