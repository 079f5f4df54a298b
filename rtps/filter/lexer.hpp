// The tokens of a filter expression (DDS 1.4, Annex B).
#pragma once

#include <cstdint>
#include <string_view>

#include "base/result.hpp"

namespace ddssec::rtps {

/// A token of a filter expression. Borrows the expression.
struct FilterToken {
  enum class Kind : std::uint8_t {
    end,
    field,      ///< a name, or names separated by dots
    integer,    ///< decimal or 0x..., possibly signed
    real,       ///< with a decimal point or an exponent
    text,       ///< between ' or ` and ' (Annex B); `text` does not include these quotes
    parameter,  ///< %0 to %99; `text` contains the digits
    relation,   ///< = == <> != < <= > >=
    open,
    close,
    and_,
    or_,
    not_,
    between,
    like,
    true_,
    false_,
  };
  Kind kind = Kind::end;
  std::string_view text = {};
  std::size_t position = 1;  ///< position of its first character, counted from 1
};

/// Reads one token after the other. Keywords are not case-sensitive.
class FilterLexer {
 public:
  explicit FilterLexer(std::string_view expression) : all_(expression) {}

  /// Returns the next token. Errors: rtps_filter_invalid.
  Result<FilterToken> next();

 private:
  FilterToken take(FilterToken::Kind kind, std::size_t length);
  Result<FilterToken> word();
  Result<FilterToken> number();
  Result<FilterToken> quoted();
  Result<FilterToken> parameter();
  std::string_view rest() const { return all_.substr(at_); }

  std::string_view all_;
  std::size_t at_ = 0;
};

/// Creates rtps_filter_invalid for a position in the expression. `found` is shortened, and shown
/// without terminal control characters.
std::unexpected<Error> filter_error(std::size_t position, std::string expected,
                                    std::string_view found);

}  // namespace ddssec::rtps
