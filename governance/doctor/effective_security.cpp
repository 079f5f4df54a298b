#include "governance/doctor/effective_security.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <span>
#include <utility>

#include <fmt/format.h>

#include "base/text.hpp"

namespace ddssec::governance::doctor {
namespace {

constexpr std::string_view kBlanks = " \t\r\n";

using Attributes = std::vector<std::pair<std::string, std::string>>;

/// Reads markup as leniently as Cyclone DDS does, which is no XML parser: no namespaces, no check
/// of the characters of names, entities of characters only.
class Markup {
 public:
  struct Token {
    enum class Kind : std::uint8_t { open, close, text, broken, end } kind;
    std::string name = {};  ///< lower case; of text: the text
    Attributes attributes = {};
    bool is_closed = false;  ///< <Name/>
    int line = 0;
  };
  using Kind = Token::Kind;

  explicit Markup(std::string_view text) : rest_(text) {}

  Token next() {
    while (!rest_.empty()) {
      if (rest_.starts_with("<![CDATA[")) return cdata();
      if (rest_.front() != '<') return text();
      if (rest_.starts_with("<!--")) {
        if (!skip_past("-->")) return at(Kind::broken);
      } else if (rest_.starts_with("<?") || rest_.starts_with("<!")) {
        if (!skip_past(">")) return at(Kind::broken);
      } else {
        return rest_.starts_with("</") ? close() : open();
      }
    }
    return at(Kind::end);
  }

 private:
  Token at(Kind kind) const { return {.kind = kind, .line = line_}; }

  std::string_view take(std::size_t count) {
    const auto taken = rest_.substr(0, count);
    line_ += static_cast<int>(std::ranges::count(taken, '\n'));
    rest_.remove_prefix(taken.size());
    return taken;
  }
  bool skip_past(std::string_view end) {
    const auto found = rest_.find(end);
    take(found == rest_.npos ? rest_.size() : found + end.size());
    return found != rest_.npos;
  }
  void skip_blanks() { take(std::min(rest_.find_first_not_of(kBlanks), rest_.size())); }

  Token cdata() {
    auto out = at(Kind::text);
    take(std::string_view("<![CDATA[").size());
    const auto end = rest_.find("]]>");
    if (end == rest_.npos) return at(Kind::broken);
    out.name = take(end);
    take(3);
    return out;
  }
  Token text() {
    auto out = at(Kind::text);
    out.name = without_references(take(std::min(rest_.find('<'), rest_.size())));
    return out;
  }
  Token close() {
    auto out = at(Kind::close);
    take(2);
    const auto end = rest_.find('>');
    if (end == rest_.npos) return at(Kind::broken);
    out.name = ascii_lower(trimmed(take(end), kBlanks));
    take(1);
    return out;
  }
  Token open() {
    auto out = at(Kind::open);
    take(1);
    out.name = ascii_lower(take(std::min(rest_.find_first_of(" \t\r\n/>"), rest_.size())));
    for (;;) {
      skip_blanks();
      if (rest_.empty()) return at(Kind::broken);
      out.is_closed = rest_.starts_with("/>");
      if (out.is_closed || rest_.front() == '>') {
        take(out.is_closed ? 2 : 1);
        return out;
      }
      if (!add_attribute(out)) return at(Kind::broken);
    }
  }
  bool add_attribute(Token& out) {
    const auto name = take(std::min(rest_.find_first_of("= \t\r\n/>"), rest_.size()));
    skip_blanks();
    if (name.empty() || !rest_.starts_with('=')) return false;
    take(1);
    skip_blanks();
    if (rest_.empty() || (rest_.front() != '"' && rest_.front() != '\'')) return false;
    const char quote = take(1).front();
    const auto end = rest_.find(quote);
    if (end == rest_.npos) return false;
    out.attributes.emplace_back(ascii_lower(name), without_references(take(end)));
    take(1);
    return true;
  }

  static std::string without_references(std::string_view text) {
    constexpr std::pair<std::string_view, char> kNames[] = {
        {"lt;", '<'}, {"gt;", '>'}, {"amp;", '&'}, {"quot;", '"'}, {"apos;", '\''}};
    std::string out;
    while (!text.empty()) {
      const auto before = std::min(text.find('&'), text.size());
      out += text.substr(0, before);
      text.remove_prefix(before);
      if (text.empty()) break;
      text.remove_prefix(1);
      const auto* const known = std::ranges::find_if(
          kNames, [&](const auto& one) { return text.starts_with(one.first); });
      if (known != std::end(kNames)) {
        out += known->second;
        text.remove_prefix(known->first.size());
      } else {
        out += character_of_number(text);
      }
    }
    return out;
  }
  // Of ASCII only: another one in the name of a file is written as it is.
  static char character_of_number(std::string_view& text) {
    const bool is_hex = text.starts_with("#x");
    const auto end = text.find(';');
    if (!text.starts_with('#') || end == text.npos) return '&';
    unsigned value = 0;
    const auto* const begin = text.data() + (is_hex ? 2 : 1);
    const auto read = std::from_chars(begin, text.data() + end, value, is_hex ? 16 : 10);
    if (read.ec != std::errc() || read.ptr != text.data() + end || value > 127) return '&';
    text.remove_prefix(end + 1);
    return static_cast<char>(value);
  }

  std::string_view rest_;
  int line_ = 1;
};

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

/// A plugin's element.
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

bool is_security(std::string_view name) { return name == "security" || name == "ddssecurity"; }

/// Walks through the elements and keeps what counts.
class Walk {
 public:
  Walk(DomainId domain, ConfigurationPlace place) : domain_(domain), place_(place) {}

  EffectiveSecurity of(std::string_view text) {
    Markup markup(text);
    for (;;) {
      const auto token = markup.next();
      if (token.kind == Markup::Kind::end) break;
      if (token.kind == Markup::Kind::broken) {
        problem(token.line, "is not well-formed XML");
        return std::move(out_);
      }
      if (!take(token)) return std::move(out_);
    }
    if (!path_.empty() && is_file())
      problem(path_.back().line, fmt::format("has no end tag for <{}>", path_.back().name));
    return std::move(out_);
  }

 private:
  struct Open {
    std::string name;
    int line;
    bool is_for_other_domain;
    std::string id = {};  ///< of a <Domain>
  };

  bool is_file() const { return place_ == ConfigurationPlace::file; }
  void problem(int line, std::string what) { out_.problems.push_back({std::move(what), line}); }

  bool take(const Markup::Token& token) {
    if (token.kind == Markup::Kind::close) return close(token);
    if (token.kind == Markup::Kind::text) {
      text(token);
      return true;
    }
    open(token);
    if (token.is_closed) leave();
    return true;
  }

  bool close(const Markup::Token& token) {
    const bool is_anonymous = token.name.empty() && !is_file();
    if (path_.empty() || (!is_anonymous && token.name != path_.back().name)) {
      problem(token.line, fmt::format("has an end tag </{}> that no start tag belongs to",
                                      token.name.substr(0, 64)));
      return false;
    }
    leave();
    return true;
  }

  void leave() {
    if (path_.size() == security_depth_) security_depth_ = 0;
    if (value_ != nullptr) value_->text = std::string(trimmed(value_->text, kBlanks));
    value_ = nullptr;
    path_.pop_back();
  }

  void open(const Markup::Token& token) {
    const bool is_other = !path_.empty() && path_.back().is_for_other_domain;
    path_.push_back({token.name, token.line, is_other});
    if (path_.size() == 1 && is_file() && token.name != "cyclonedds")
      problem(token.line, fmt::format("begins with <{}>, and Cyclone DDS reads <CycloneDDS> only",
                                      token.name.substr(0, 64)));
    if (security_depth_ != 0) return open_inside(token);
    if (token.name == "domain") return open_domain(token);
    if (is_security(token.name) && is_at_its_place()) open_security(token);
  }

  // Of a variable parts are read, too: <Domain>...</Domain>, <Security>...</Security>.
  bool is_at_its_place() const {
    if (!is_file()) return path_.size() <= 3;
    return path_.size() == 3 && path_[1].name == "domain";
  }

  void open_domain(const Markup::Token& token) {
    for (const auto& [name, value] : token.attributes) {
      if (name != "id") continue;
      path_.back().id = value;
      const auto word = trimmed(value, kBlanks);
      if (ascii_lower(word) == "any") continue;
      DomainId id = 0;
      const auto read = std::from_chars(word.data(), word.data() + word.size(), id);
      if (word.empty() || read.ec != std::errc() || read.ptr != word.data() + word.size())
        problem(token.line, fmt::format("has <Domain Id=\"{}\">, which is neither a number nor any",
                                        value.substr(0, 64)));
      else if (id != domain_)
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
    out_.is_there = true;
    refuse_attributes(token);
  }

  void open_inside(const Markup::Token& token) {
    const auto level = path_.size() - security_depth_;
    if (level == 1) {
      kind_ = std::ranges::find(kKinds, token.name, &Kind::name);
      if (kind_ == std::end(kKinds)) return unknown(token);
      out_.*kind_->plugin = ConfiguredPlugin{};
      return refuse_attributes(token);
    }
    if (kind_ == std::end(kKinds)) return;
    if (level != 2 || std::ranges::find(kind_->children, token.name) == kind_->children.end())
      return unknown(token);
    auto& plugin = *(out_.*kind_->plugin);
    if (token.name == "library") return open_library(token, plugin);
    refuse_attributes(token);
    if (plugin.value(token.name) != nullptr)
      problem(token.line, fmt::format("has <{}> twice", token.name));
    plugin.values.push_back({token.name, {{}, token.line}});
    value_ = &plugin.values.back().second;
  }

  void open_library(const Markup::Token& token, ConfiguredPlugin& plugin) {
    if (!plugin.library.empty()) problem(token.line, "has <library> twice");
    for (const auto& [name, value] : token.attributes)
      if (std::ranges::find(kLibrary, name) == std::end(kLibrary))
        unknown_attribute(token, name);
      else
        plugin.library.push_back({name, {value, token.line}});
  }

  void unknown(const Markup::Token& token) {
    problem(token.line, fmt::format("has <{}> inside <Security>, which Cyclone DDS does not know",
                                    token.name.substr(0, 64)));
  }
  void unknown_attribute(const Markup::Token& token, std::string_view name) {
    problem(token.line, fmt::format("has the attribute {} in <{}>, which Cyclone DDS does not know",
                                    name.substr(0, 64), token.name));
  }
  void refuse_attributes(const Markup::Token& token) {
    for (const auto& [name, value] : token.attributes) unknown_attribute(token, name);
  }

  void text(const Markup::Token& token) {
    if (value_ != nullptr) {
      value_->text += token.name;
    } else if (security_depth_ != 0 && !trimmed(token.name, kBlanks).empty()) {
      problem(token.line,
              fmt::format("has text in <{}>, where only elements may be", path_.back().name));
    }
  }

  DomainId domain_;
  ConfigurationPlace place_;
  EffectiveSecurity out_;
  std::vector<Open> path_;
  std::size_t security_depth_ = 0;  ///< 0: not inside one that counts
  const Kind* kind_ = std::end(kKinds);
  ConfiguredText* value_ = nullptr;
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
                                     ConfigurationPlace place) {
  return Walk(domain, place).of(text);
}

}  // namespace ddssec::governance::doctor
