// Reads the markup of Cyclone DDS's configurations. For governance/doctor/ only.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace ddssec::governance::doctor {

inline constexpr std::string_view kMarkupBlanks = " \t\v\r\n";

/// Reads markup as Cyclone DDS 0.10.2 does (measured), which is not an XML parser: no namespaces,
/// and an element has either a text or elements. Comments, processing instructions and declarations
/// may stand between any two tokens; in a text only comments may.
class Markup {
 public:
  struct Token {
    enum class Kind : std::uint8_t { open, close, text, broken, end } kind;
    std::string name = {};  ///< in lower case; for a text: the text itself
    std::vector<std::pair<std::string, std::string>> attributes = {};  ///< names in lower case
    bool is_closed = false;                                            ///< true for <Name/>
    int line = 0;
    std::string spelled = {};  ///< the name as it is written
    bool is_inline = false;    ///< true in the part that is in the variable itself
  };
  using Kind = Token::Kind;

  /// The text from `inline_from` on is in the variable itself.
  explicit Markup(std::string_view text, std::size_t inline_from)
      : text_(text), inline_from_(inline_from), rest_(text) {}

  Token next();

 private:
  /// The kind of text at which the rest begins.
  enum class Position : std::uint8_t { between_elements, content, end_of_text };

  Token at(Kind kind) const;
  std::size_t offset() const { return text_.size() - rest_.size(); }
  std::string_view take(std::size_t count);
  bool skip_between();
  Token between();
  Token content();
  Token text();
  Token close();
  Token open();
  bool add_attribute(Token& out);

  std::string_view text_;
  std::size_t inline_from_;
  std::string_view rest_;
  Position position_ = Position::between_elements;
  int line_ = 1;
};

}  // namespace ddssec::governance::doctor
