// Errors are values: a Result<T> holds a T or an Error. An Error names the document, rule and
// values.
#pragma once

#include <cstdint>
#include <expected>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>

#include "base/code.hpp"

namespace ddssec {

/// Where an error was found and which values differ. Every field may be empty.
struct ErrorDetails {
  std::string document = {};  ///< which document: a path, a property's name or a message's name
  int line = 0;               ///< line in the document, from 1; 0 = none
  std::string field = {};     ///< element, attribute, property or rule
  std::string expected = {};
  std::string found = {};
  std::string note = {};  ///< further information for the sentence
  std::string hint = {};  ///< what the user can do about it; empty: the hint of the code
};

/// A refusal. It is two words long, so that Result<T> is cheap on success. An Error without details
/// allocates nothing. Copies share their details.
class Error {
 public:
  explicit Error(Code code) : code_(code) {}
  Error(Code code, ErrorDetails details)
      : code_(code), details_(std::make_shared<const ErrorDetails>(std::move(details))) {}

  Code code() const { return code_; }
  const ErrorDetails& details() const;

  /// What the user can do about it: the hint of the details, or else that of the code.
  std::string hint() const;

  /// The same error, with `document` filled in if it had none.
  Error in(std::string document) const;

  /// What happened, with the expected and the found value; without place and hint.
  std::string message() const;

  /// One sentence with what happened, the place, both values and the hint; without control
  /// characters.
  std::string to_sentence() const;

 private:
  Code code_;
  std::shared_ptr<const ErrorDetails> details_;
};

template <class T>
using Result = std::expected<T, Error>;

/// Success, or the reason why not.
using Status = Result<void>;

inline std::unexpected<Error> fail(Code code) { return std::unexpected(Error(code)); }
inline std::unexpected<Error> fail(Code code, ErrorDetails details) {
  return std::unexpected(Error(code, std::move(details)));
}

/// Moves the value out of a successful Result. For DDSSEC_TRY; unlike the result of the operators,
/// it may be ignored.
template <class T>
T take_value(Result<T>& result) {
  if constexpr (!std::is_void_v<T>) return *std::move(result);
}
template <class T>
T take_value(const Result<T>& result) {
  if constexpr (!std::is_void_v<T>) return *result;
}

}  // namespace ddssec

/// The value of a Result, or return its error from the caller; .cpp only, and see lint/braces.py.
#define DDSSEC_TRY(...)                                       \
  __extension__({                                             \
    auto&& ddssec_try_ = (__VA_ARGS__);                       \
    if (!ddssec_try_) [[unlikely]]                            \
      return std::unexpected(std::move(ddssec_try_).error()); \
    ::ddssec::take_value(ddssec_try_);                        \
  })
