// Errors are values: Result<T> is a T or an Error that says which document, rule and values.
#pragma once

#include <cstdint>
#include <expected>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>

#include "base/code.hpp"

namespace ddssec {

/// Where an error was found and what differs; every field may stay empty.
struct ErrorDetails {
  std::string document = {};  ///< which document: a path, a property's name or a message's name
  int line = 0;               ///< line in the document, from 1; 0 = none
  std::string field = {};     ///< element, attribute, property or rule
  std::string expected = {};
  std::string found = {};
  std::string note = {};  ///< anything else worth a clause of the sentence
  std::string hint = {};  ///< what a person can do about it; empty = what the code's row says
};

/// A refusal. Two words in size, so that Result<T> stays cheap where nothing goes wrong; an Error
/// without details allocates nothing.
class Error {
 public:
  explicit Error(Code code) : code_(code) {}
  Error(Code code, ErrorDetails details)
      : code_(code), details_(std::make_shared<const ErrorDetails>(std::move(details))) {}

  Code code() const { return code_; }
  const ErrorDetails& details() const;

  /// What a person can do about it: the details' own, or else that of the code.
  std::string hint() const;

  /// The same error, with the document filled in if it had none.
  Error in(std::string document) const;

  /// What happened, with both values; neither where nor what to do.
  std::string message() const;

  /// One sentence: what happened, where, both values and what to do; without control characters.
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

/// The value of a success, moved out. For DDSSEC_TRY: may be ignored, unlike the operators.
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
