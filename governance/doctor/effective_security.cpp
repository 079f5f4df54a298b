#include "governance/doctor/effective_security.hpp"

#include <algorithm>
#include <charconv>
#include <set>
#include <span>
#include <utility>

#include <fmt/format.h>

#include "base/text.hpp"
#include "governance/doctor/expanded_variables.hpp"
#include "governance/doctor/markup.hpp"
#include "governance/doctor/section_elements.hpp"

namespace ddssec::governance::doctor {
namespace {

constexpr std::string_view kBlanks = kMarkupBlanks;

constexpr std::string_view kAuthentication[] = {"library",
                                                "identityca",
                                                "identitycertificate",
                                                "privatekey",
                                                "password",
                                                "trustedcadirectory",
                                                "crl",
                                                "includeoptionalfields"};
constexpr std::string_view kCryptographic[] = {"library"};
constexpr std::string_view kAccessControl[] = {"library", "permissionsca", "governance",
                                               "permissions"};
constexpr std::string_view kLibrary[] = {"path", "initfunction", "finalizefunction"};

// An element of <Security> that configures one plugin.
struct Kind {
  std::string_view name;
  std::span<const std::string_view> children;
  std::optional<ConfiguredPlugin> EffectiveSecurity::*plugin;
};
constexpr Kind kKinds[] = {
    {"authentication", kAuthentication, &EffectiveSecurity::authentication},
    {"cryptographic", kCryptographic, &EffectiveSecurity::cryptographic},
    {"accesscontrol", kAccessControl, &EffectiveSecurity::access_control},
};

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

// Reads the elements and stores those that apply.
class SecurityElementReader {
 public:
  SecurityElementReader(DomainId domain, ConfigurationPlace place, std::size_t inline_from)
      : domain_(domain), place_(place), inline_from_(inline_from) {}

  EffectiveSecurity read(std::string_view text) {
    Markup markup(text, inline_from_);
    for (;;) {
      const auto token = markup.next();
      if (token.is_inline && !std::exchange(is_inline_, true)) refuse_open_elements();
      if (token.kind == Markup::Kind::end) break;
      if (token.kind == Markup::Kind::broken) {
        add_problem(token.line, "is not well-formed XML");
        return std::move(out_);
      }
      if (!read_token(token)) return std::move(out_);
    }
    if (!is_inline_) refuse_open_elements();
    return std::move(out_);
  }

 private:
  struct Open {
    std::string name;
    int line;
    bool is_for_other_domain;
    std::string id = {};        // the Id of a <Domain>
    bool has_values = false;    // an attribute or a text was seen in it, at any depth
    bool has_elements = false;  // an element was seen directly inside
    bool has_security = false;  // a <Domain> in which a <Security> was seen
    std::string path = {};      // path from a known section on (section_elements.hpp)
    std::string place = {};     // the same for elements that are the same one in a <Domain>
    bool has_text = false;      // a text was seen directly inside
    std::string spelled = {};   // the name as it is written
  };

  bool is_file() const { return place_ == ConfigurationPlace::file; }
  void add_problem(int line, std::string what) { out_.problems.push_back({std::move(what), line}); }

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
    if (path_.empty() || !out_.problems.empty()) return;
    add_problem(path_.back().line, fmt::format("has no end tag for <{}>", path_.back().name));
  }

  bool on_end_tag(const Markup::Token& token) {
    const bool is_anonymous = token.name.empty() && token.is_inline;
    if (!path_.empty() && (is_anonymous || token.spelled == path_.back().spelled)) {
      on_end();
      return true;
    }
    if (!path_.empty() && token.name == path_.back().name)
      add_problem(token.line, fmt::format("ends <{}> with </{}>, in another letter case",
                                          path_.back().spelled, token.spelled));
    else
      add_problem(token.line, fmt::format("has an end tag </{}> that no start tag belongs to",
                                          token.name.substr(0, 64)));
    return false;
  }

  // Measured: an empty value means the default.
  void check_switch(const ConfiguredText& value) {
    const auto read = ascii_lower(expanded_variables(value.text, domain_).value_or(""));
    if (!read.empty() && read != "true" && read != "false")
      add_problem(value.line, fmt::format("has the value \"{}\" for <{}>, which is true or false",
                                          value.text.substr(0, 64), path_.back().spelled));
  }

  void on_end() {
    if (path_.size() == security_depth_) {
      security_depth_ = 0;
      if (is_second_ && !out_.authentication)
        add_problem(path_.back().line, "has a second <Security> without <Authentication>");
    }
    if (value_ != nullptr) {
      value_->text = std::string(trimmed(value_->text, kBlanks));
      if (path_.back().name == "includeoptionalfields") check_switch(*value_);
    }
    value_ = nullptr;
    if (is_old_id()) read_old_id();
    if (path_.back().has_text && !values_.insert(path_.back().place).second)
      add_problem(path_.back().line, fmt::format("has <{}> twice", path_.back().name));
    path_.pop_back();
    if (path_.empty()) had_root_ = true;
  }

  void on_start_tag(const Markup::Token& token) {
    const bool is_other = !path_.empty() && path_.back().is_for_other_domain;
    if (!path_.empty()) path_.back().has_elements = true;
    path_.push_back({token.name, token.line, is_other});
    path_.back().spelled = token.spelled;
    path_.back().place = fmt::format("#{}", count_++);
    if (path_.size() == 1) is_file() ? open_root(token) : open_part(token);
    if (security_depth_ != 0) return open_inside(token);
    if (!is_other) {
      refuse_unknown(token);
      doubt_unknown(token);
    }
    if (is_old_id()) {
      old_id_.clear();
      refuse_attributes(token);
    } else if (!token.attributes.empty()) {
      mark_values();
    }
    if (token.name == "domain") return open_domain(token);
    if (is_security(token.name) && is_at_its_place()) open_security(token);
  }

  void open_root(const Markup::Token& token) {
    if (had_root_) return add_problem(token.line, "goes on after </CycloneDDS>");
    if (token.name != "cyclonedds")
      return add_problem(token.line,
                         fmt::format("begins with <{}>, and Cyclone DDS reads <CycloneDDS> only",
                                     token.name.substr(0, 64)));
    for (const auto& [name, value] : token.attributes)
      if (std::ranges::find(kRootAttributes, name) == std::end(kRootAttributes))
        add_unknown_attribute(token, name);
  }

  // Checks the first element in the variable: it may be <CycloneDDS>, <Domain> or an element from
  // inside a <Domain>.
  void open_part(const Markup::Token& token) {
    if (token.name == "cyclonedds" || token.name == "domain") return;
    if (!is_one_of(kSections, token.name) && !is_one_of(kOfDomain, token.name))
      add_problem(token.line, fmt::format("begins with <{}>, which Cyclone DDS does not know",
                                          token.name.substr(0, 64)));
  }

  // True if the innermost element is directly below <CycloneDDS>.
  bool is_below_root() const { return path_.size() == 2 && path_[0].name == "cyclonedds"; }
  bool is_below_domain() const {
    const auto depth = path_.size();
    return depth >= 2 && path_[depth - 2].name == "domain" &&
           (depth == 2 || (depth == 3 && path_[0].name == "cyclonedds"));
  }

  void refuse_unknown(const Markup::Token& token) {
    if (!is_below_root() && !is_below_domain()) return;
    const auto own = is_below_root() ? std::span<const std::string_view>(kOfRoot) : kOfDomain;
    if (!is_one_of(kSections, token.name) && !is_one_of(own, token.name))
      add_problem(token.line,
                  fmt::format("has <{}> inside <{}>, which Cyclone DDS does not know",
                              token.name.substr(0, 64), is_below_root() ? "CycloneDDS" : "Domain"));
  }

  // Records an unknown element as a doubt, because other versions may know it (docs/decisions).
  void doubt_unknown(const Markup::Token& token) {
    const auto depth = path_.size();
    auto& own = path_.back();
    const bool is_at_top = depth == 1 && !is_file();
    if (is_at_top || is_below_root() || is_below_domain()) {
      own.path = section_path(token.name);
      if (own.path.empty()) return;
      own.place = fmt::format("{}/{}", depth > 1 ? path_[depth - 2].place : "", own.path);
      refuse_attributes(token);
    } else if (depth > 1 && !path_[depth - 2].path.empty()) {
      doubt_inside(token, path_[depth - 2]);
    }
  }

  void doubt_inside(const Markup::Token& token, const Open& parent) {
    auto& own = path_.back();
    if (!is_known_inside(parent.path, token.name)) {
      out_.doubts.push_back(
          {fmt::format("has <{}> inside <{}>", token.name.substr(0, 64), parent.name), token.line});
      return;
    }
    own.path = path_inside(parent.path, token.name);
    // <Internal><FragmentSize> is the same as <General><FragmentSize>.
    const auto section = own.path.substr(0, own.path.find('/'));
    own.place = parent.path.starts_with(section)
                    ? fmt::format("{}/{}", parent.place, token.name)
                    : fmt::format("{}/{}", path_[path_.size() - 3].place, own.path);
    if (is_repeated(own.path)) own.place += fmt::format("#{}", count_++);
    for (const auto& [name, value] : token.attributes) {
      if (!is_known_attribute(own.path, name))
        out_.doubts.push_back(
            {fmt::format("has the attribute {} in <{}>", name.substr(0, 64), token.name),
             token.line});
      else if (!values_.insert(own.place + "@" + name).second)
        add_problem(token.line,
                    fmt::format("has the attribute {} of <{}> twice", name, token.name));
    }
  }

  // True for <Domain><Id>5</Id>, which Cyclone DDS still reads as <Domain Id="5">.
  bool is_old_id() const {
    return is_below_domain() && path_.back().name == "id" && !path_.back().is_for_other_domain;
  }

  void read_old_id() {
    auto& domain = path_[path_.size() - 2];
    const auto line = path_.back().line;
    const auto id = std::string(trimmed(old_id_, kBlanks));
    const auto number = number_of(id);
    if (!id.empty() && ascii_lower(id) != "any") {
      if (!number) {
        add_problem(line, fmt::format("has <Id>{}</Id>, which is neither a number nor any",
                                      id.substr(0, 64)));
      } else if (*number != domain_) {
        if (domain.has_values)
          add_problem(line, fmt::format("has <Id>{}</Id> after other values of the same <Domain>",
                                        id.substr(0, 64)));
        domain.is_for_other_domain = true;
        domain.id = id;
      }
    }
    mark_values();
  }

  static std::optional<DomainId> number_of(std::string_view word) {
    DomainId id = 0;
    if (word.starts_with('+') && !word.starts_with("+-")) word.remove_prefix(1);
    const auto* const end = word.data() + word.size();
    const auto read = std::from_chars(word.data(), end, id);
    if (word.empty() || read.ec != std::errc() || read.ptr != end) return std::nullopt;
    return id;
  }

  void mark_values() {
    for (auto& one : path_) one.has_values = true;
  }

  // True if the <Security> is where it counts. In the variable it may also be in a part of a
  // document: <Domain>...</Domain>, <Security>...</Security>.
  bool is_at_its_place() const {
    if (!is_file()) return path_.size() <= 3;
    const bool is_former = is_below_root() && path_.back().name == "ddssecurity";
    return is_former || (path_.size() == 3 && path_[1].name == "domain");
  }

  void open_domain(const Markup::Token& token) {
    for (const auto& [name, value] : token.attributes) {
      if (path_.back().is_for_other_domain) return;  // Cyclone DDS reads no further
      if (name != "id") {
        add_unknown_attribute(token, name);
        continue;
      }
      path_.back().id = value;
      if (ascii_lower(value) == "any") continue;
      // Blanks may be before the number, but nowhere else.
      const auto first = std::min(value.find_first_not_of(kBlanks), value.size());
      const auto id = number_of(std::string_view(value).substr(first));
      if (!id)
        add_problem(token.line,
                    fmt::format("has <Domain Id=\"{}\">, which is neither a number nor any",
                                value.substr(0, 64)));
      else if (*id != domain_)
        path_.back().is_for_other_domain = true;
    }
  }

  void open_security(const Markup::Token& token) {
    if (path_.back().is_for_other_domain) {
      for (const auto& above : path_)
        if (above.is_for_other_domain && !above.id.empty()) out_.other_domain = above.id;
      return;
    }
    security_depth_ = path_.size();
    if (path_.size() > 1) {
      auto& domain = path_[path_.size() - 2];
      if (domain.has_security)
        add_problem(token.line, fmt::format("has a second <{}> in one <Domain>", token.name));
      domain.has_security = true;
    }
    // Each <Security> must be complete (measured).
    is_second_ = out_.applies;
    out_.authentication = out_.cryptographic = out_.access_control = std::nullopt;
    out_.applies = true;
    refuse_attributes(token);
  }

  void open_inside(const Markup::Token& token) {
    const auto level = path_.size() - security_depth_;
    if (level == 1) {
      kind_ = std::ranges::find(kKinds, token.name, &Kind::name);
      if (kind_ == std::end(kKinds)) return add_unknown_element(token);
      if (out_.*kind_->plugin)
        add_problem(token.line, fmt::format("has a second <{}> in one <Security>", token.name));
      out_.*kind_->plugin = ConfiguredPlugin{};
      return refuse_attributes(token);
    }
    if (kind_ == std::end(kKinds)) return;
    if (level != 2 || std::ranges::find(kind_->children, token.name) == kind_->children.end())
      return add_unknown_element(token);
    auto& plugin = *(out_.*kind_->plugin);
    if (token.name == "library") return open_library(token, plugin);
    refuse_attributes(token);
    if (plugin.value(token.name) != nullptr)
      add_problem(token.line, fmt::format("has <{}> twice", token.name));
    plugin.values.push_back({token.name, {{}, token.line}});
    value_ = &plugin.values.back().second;
  }

  void open_library(const Markup::Token& token, ConfiguredPlugin& plugin) {
    if (!plugin.library.empty()) add_problem(token.line, "has <library> twice");
    for (const auto& [name, value] : token.attributes)
      if (std::ranges::find(kLibrary, name) == std::end(kLibrary))
        add_unknown_attribute(token, name);
      else if (plugin.attribute(name) != nullptr)
        add_problem(token.line, fmt::format("has the attribute {} of <library> twice", name));
      else
        plugin.library.push_back({name, {value, token.line}});
  }

  void add_unknown_element(const Markup::Token& token) {
    add_problem(token.line,
                fmt::format("has <{}> inside <Security>, which Cyclone DDS does not know",
                            token.name.substr(0, 64)));
  }
  void add_unknown_attribute(const Markup::Token& token, std::string_view name) {
    add_problem(token.line,
                fmt::format("has the attribute {} in <{}>, which Cyclone DDS does not know",
                            name.substr(0, 64), token.name));
  }
  void refuse_attributes(const Markup::Token& token) {
    for (const auto& [name, value] : token.attributes) add_unknown_attribute(token, name);
  }

  void on_text(const Markup::Token& token) {
    if (value_ != nullptr) {
      value_->text += token.name;
      return;
    }
    if (is_old_id() && !path_.back().has_elements) {
      old_id_ += token.name;
      return;
    }
    if (trimmed(token.name, kBlanks).empty()) return;
    if (!path_.empty()) path_.back().has_text = true;
    if (path_.empty()) {
      // In the variable the name of a file may follow after a comma.
      if (is_file() || !trimmed(token.name, kBlanks).starts_with(','))
        add_problem(token.line, "has text outside of <CycloneDDS>");
    } else if (path_.back().has_elements || is_section_list()) {
      add_problem(token.line,
                  fmt::format("has text in <{}>, where only elements may be", path_.back().name));
    }
    mark_values();
  }

  // True where only elements are allowed. Cyclone DDS does not check options of other domains so
  // strictly.
  bool is_section_list() const {
    if (security_depth_ != 0) return true;
    const auto& name = path_.back().name;
    if (has_elements_only(path_.back().path)) return true;
    const bool is_list = path_.size() <= 2 && (name == "cyclonedds" || name == "domain");
    return is_list && !path_.back().is_for_other_domain;
  }

  DomainId domain_;
  ConfigurationPlace place_;
  std::size_t inline_from_;
  bool is_inline_ = false;  // the rest of the text is in the variable itself
  EffectiveSecurity out_;
  std::vector<Open> path_;
  std::size_t security_depth_ = 0;  // 0 outside of a <Security> that counts
  bool is_second_ = false;          // this is not the first <Security> that counts
  const Kind* kind_ = std::end(kKinds);
  ConfiguredText* value_ = nullptr;
  std::string old_id_;            // the content of <Id> so far
  bool had_root_ = false;         // <CycloneDDS> has ended
  std::set<std::string> values_;  // the places of values, none of which may be set twice
  std::size_t count_ = 0;
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
  return SecurityElementReader(domain, place,
                               place == ConfigurationPlace::file ? text.npos : inline_from)
      .read(text);
}

}  // namespace ddssec::governance::doctor
