#include "governance/pattern.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <optional>

namespace ddssec::governance {
namespace {

bool is_between(int c, char first, char last) { return c >= first && c <= last; }
bool is_upper(int c) { return is_between(c, 'A', 'Z'); }
bool is_lower(int c) { return is_between(c, 'a', 'z'); }
bool is_digit(int c) { return is_between(c, '0', '9'); }
bool is_alpha(int c) { return is_upper(c) || is_lower(c); }
bool is_alnum(int c) { return is_alpha(c) || is_digit(c); }
bool is_xdigit(int c) { return is_digit(c) || is_between(c, 'a', 'f') || is_between(c, 'A', 'F'); }
bool is_graph(int c) { return is_between(c, '!', '~'); }
bool is_print(int c) { return is_between(c, ' ', '~'); }
bool is_punct(int c) { return is_graph(c) && !is_alnum(c); }
bool is_blank(int c) { return c == ' ' || c == '\t'; }
bool is_space(int c) { return c == ' ' || is_between(c, '\t', '\r'); }
bool is_cntrl(int c) { return (c >= 0 && c < 0x20) || c == 0x7F; }

struct Class {
  std::string_view name;
  bool (*contains)(int);
};
constexpr std::array<Class, 12> kClasses = {{{"alpha", is_alpha},
                                             {"digit", is_digit},
                                             {"alnum", is_alnum},
                                             {"upper", is_upper},
                                             {"lower", is_lower},
                                             {"space", is_space},
                                             {"blank", is_blank},
                                             {"punct", is_punct},
                                             {"print", is_print},
                                             {"graph", is_graph},
                                             {"cntrl", is_cntrl},
                                             {"xdigit", is_xdigit}}};

}  // namespace

// Reads the bracket expressions of a text member by member. Takes linear time, however many '[' the
// text contains: each member searches for nothing beyond itself, and no expression is read past the
// point where another one failed.
class Pattern::SetReader {
 public:
  SetReader(std::string_view text, bool escapes)
      : text_(text),
        escapes_(escapes),
        symbols_end_(behind_last(".]")),
        equivalences_end_(behind_last("=]")) {}

  // Reads the expression whose '[' is before `begin`. Returns the number of octets from `begin` up
  // to and including its ']'; empty if there is none. Calls go from left to right.
  std::optional<std::size_t> read(std::size_t begin, std::bitset<256>& set) {
    at_ = begin;
    const bool negated = !at_end() && (text_[at_] == '!' || text_[at_] == '^');
    if (negated) ++at_;
    for (bool first = true; !at_end(); first = false) {
      if (!first && text_[at_] == ']') {
        if (negated) set.flip();
        return at_ + 1 - begin;
      }
      if (!first && was_here()) return std::nullopt;
      if (!member(set)) return std::nullopt;
    }
    return std::nullopt;
  }

 private:
  bool at_end() const { return at_ >= text_.size(); }

  std::size_t behind_last(std::string_view close) const {
    const auto last = text_.rfind(close);
    return last == text_.npos ? 0 : last + close.size();
  }

  // True if a member other than the first of its expression was read here before. That earlier
  // expression was never closed, because the search for the next '[' begins after a closed one. The
  // same members follow here, so this expression is not closed either.
  bool was_here() {
    if (visited_.empty()) visited_.resize(text_.size());
    const bool before = visited_[at_];
    visited_[at_] = true;
    return before;
  }

  bool member(std::bitset<256>& set) {
    if (auto name = class_name()) return add_class(set, *name);
    const auto low = endpoint();
    if (!low) return false;
    const bool range = at_ + 1 < text_.size() && text_[at_] == '-' && text_[at_ + 1] != ']';
    if (!range) {
      set.set(*low);
      return true;
    }
    ++at_;
    const auto high = endpoint();
    if (!high) return false;
    for (int c = *low; c <= *high; ++c) set.set(static_cast<std::size_t>(c));
    return true;
  }

  bool is_pair(std::size_t at, char first, char second) const {
    return at + 1 < text_.size() && text_[at] == first && text_[at + 1] == second;
  }

  // The letters between "[:" and ":]". Without such a name nothing is consumed.
  std::optional<std::string_view> class_name() {
    if (!is_pair(at_, '[', ':')) return std::nullopt;
    const auto begin = at_ + 2;
    auto end = begin;
    while (end < text_.size() && is_lower(text_[end])) ++end;
    if (!is_pair(end, ':', ']')) return std::nullopt;
    at_ = end + 2;
    return text_.substr(begin, end - begin);
  }

  static bool add_class(std::bitset<256>& set, std::string_view name) {
    for (const auto& known : kClasses) {
      if (known.name != name) continue;
      for (int c = 0; c < 256; ++c) {
        if (known.contains(c)) set.set(static_cast<std::size_t>(c));
      }
      return true;
    }
    return false;
  }

  // True if a collating symbol ('.') or an equivalence class ('=') begins here and is closed at
  // some place after it.
  bool is_symbol(char mark) const {
    const auto end = mark == '.' ? symbols_end_ : equivalences_end_;
    return is_pair(at_, '[', mark) && end >= at_ + 4;
  }

  // Reads one octet, or a collating symbol or equivalence class of one octet.
  std::optional<std::uint8_t> endpoint() {
    for (const char mark : {'.', '='}) {
      if (!is_symbol(mark)) continue;
      const auto name = at_ + 2;
      if (is_pair(name, mark, ']') || !is_pair(name + 1, mark, ']')) return std::nullopt;
      at_ = name + 3;
      return static_cast<std::uint8_t>(text_[name]);
    }
    if (escapes_ && text_[at_] == '\\' && ++at_ == text_.size()) return std::nullopt;
    return static_cast<std::uint8_t>(text_[at_++]);
  }

  std::string_view text_;
  bool escapes_;
  std::size_t symbols_end_, equivalences_end_;  // after the last ".]" and "=]", or 0
  std::size_t at_ = 0;
  std::vector<bool> visited_;
};

Pattern::Pattern(std::string_view expression, Syntax syntax) : text_(expression), syntax_(syntax) {
  SetReader sets(text_, syntax_ == Syntax::name);
  bool literal = true;
  for (std::size_t at = 0; at < text_.size();) {
    at += read_step(at, sets);
    literal = literal && steps_.back().kind == Kind::character;
  }
  if (!literal) return;
  text_.clear();
  for (const auto& step : steps_) text_ += static_cast<char>(step.character);
  steps_.clear();
}

std::size_t Pattern::read_step(std::size_t at, SetReader& sets) {
  const char c = text_[at];
  if (c == '*') {
    // Stars in a row are one star.
    if (steps_.empty() || steps_.back().kind != Kind::star) steps_.push_back({Kind::star, 0, 0});
    return 1;
  }
  if (c == '?') {
    steps_.push_back({Kind::any, 0, 0});
    return 1;
  }
  if (c == '[') {
    if (const auto length = read_set(at, sets)) return length;
  }
  if (c != '\\' || syntax_ != Syntax::name) {
    steps_.push_back({Kind::character, static_cast<std::uint8_t>(c), 0});
    return 1;
  }
  if (at + 1 < text_.size()) {
    steps_.push_back({Kind::character, static_cast<std::uint8_t>(text_[at + 1]), 0});
    return 2;
  }
  // POSIX: a backslash at the end escapes nothing, so the expression matches no name.
  steps_.clear();
  sets_.clear();
  add_set({});
  return 1;
}

void Pattern::add_set(const std::bitset<256>& set) {
  sets_.push_back(set);
  steps_.push_back({Kind::set, 0, static_cast<std::uint16_t>(sets_.size() - 1)});
}

std::size_t Pattern::read_set(std::size_t at, SetReader& sets) {
  // A step stores the number of its set in 16 bits. Only a text of more than 64 KiB can have more
  // sets.
  if (sets_.size() > std::numeric_limits<std::uint16_t>::max()) return 0;
  std::bitset<256> set;
  const auto length = sets.read(at + 1, set);
  if (!length) return 0;
  // POSIX does not define a slash between brackets if slashes are separators. Here no name matches.
  const auto body = std::string_view(text_).substr(at + 1, *length);
  if (syntax_ == Syntax::subject && body.find('/') != body.npos) set.reset();
  add_set(set);
  return *length + 1;
}

bool Pattern::step_matches(const Step& step, char c) const {
  const auto octet = static_cast<std::uint8_t>(c);
  if (step.kind == Kind::character) return step.character == octet;
  if (syntax_ == Syntax::subject && c == '/') return false;
  return step.kind == Kind::any || sets_[step.set].test(octet);
}

bool Pattern::matches_no_name() const {
  std::bitset<256> possible;
  possible.set().reset(0);  // no name holds NUL
  if (syntax_ == Syntax::subject) possible.reset('/');
  return std::ranges::any_of(steps_, [&](const Step& step) {
    return step.kind == Kind::set && (sets_[step.set] & possible).none();
  });
}

bool Pattern::matches(std::string_view name) const {
  auto unbounded = std::numeric_limits<std::size_t>::max();
  return matches(name, unbounded).value_or(false);
}

std::optional<bool> Pattern::matches(std::string_view name, std::size_t& steps) const {
  if (is_literal()) return name == text_;
  // Only the last star needs backtracking: anything that an earlier one could match, a later one
  // can match too.
  const bool star_stops = syntax_ == Syntax::subject;
  std::size_t step = 0, at = 0;
  std::size_t star = steps_.size(), star_at = 0;
  while (at < name.size()) {
    if (steps == 0) return std::nullopt;
    --steps;
    if (step < steps_.size() && steps_[step].kind == Kind::star) {
      star = step++;
      star_at = at;
    } else if (step < steps_.size() && step_matches(steps_[step], name[at])) {
      ++step, ++at;
    } else if (star < steps_.size() && !(star_stops && name[star_at] == '/')) {
      step = star + 1;
      at = ++star_at;
    } else {
      return false;
    }
  }
  while (step < steps_.size() && steps_[step].kind == Kind::star) ++step;
  return step == steps_.size();
}

}  // namespace ddssec::governance
