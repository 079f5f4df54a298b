// Errors are values: a Result<T> holds a T or an Error. An Error names the document, the rule and
// the values.
#pragma once

#include <expected>
#include <memory>
#include <string>
#include <utility>

#include "base/code.hpp"

namespace ddssec {

/// The place of an error and the values that differ. Every field may be empty.
struct ErrorDetails {
  std::string document = {};  ///< which document: a path, a property's name or a message's name
  int line = 0;               ///< line in the document, from 1; 0 if there is none
  std::string field = {};     ///< element, attribute, property or rule
  std::string expected = {};
  std::string found = {};
  std::string note = {};  ///< further information for the sentence
  std::string hint = {};  ///< what the user can do about it; empty if the code's hint applies
};

/// A refusal. It is three words long, so that Result<T> is cheap on success. An Error without
/// details allocates nothing. Copies share their details.
class Error {
 public:
  explicit Error(Code code) : code_(code) {}
  Error(Code code, ErrorDetails details)
      : code_(code), details_(std::make_shared<const ErrorDetails>(std::move(details))) {}

  Code code() const { return code_; }
  /// Returns the place and the values; all fields are empty if the error has none. Valid as long as
  /// this error or a copy of it.
  const ErrorDetails& details() const;

  /// Returns what the user can do about it: the hint of the details, or else that of the code.
  std::string hint() const;

  /// Returns the same error, with `document` filled in if it had none.
  Error with_default_document(std::string document) const;

  /// Tells what happened, with the expected and the found value; without place and hint.
  std::string message() const;

  /// Returns one sentence with what happened, the place, both values and the hint, without control
  /// characters.
  std::string to_sentence() const;

 private:
  Code code_;
  std::shared_ptr<const ErrorDetails> details_;
};
static_assert(sizeof(Error) == 3 * sizeof(void*));

template <class T>
using Result = std::expected<T, Error>;

/// Success, or the reason for the failure.
using Status = Result<void>;

/// Makes the result of a function: `return fail(Code::file_not_found, {.document = path});`
inline std::unexpected<Error> fail(Code code) { return std::unexpected(Error(code)); }
inline std::unexpected<Error> fail(Code code, ErrorDetails details) {
  return std::unexpected(Error(code, std::move(details)));
}

/// Returns the result; an error without a document gets this one.
template <class T>
Result<T> with_default_document(Result<T> result, std::string document) {
  if (result) return result;
  return std::unexpected(result.error().with_default_document(std::move(document)));
}

}  // namespace ddssec

/// `DDSSEC_RETURN_IF_ERROR(check(name));` returns the error to the caller, if there is one. It
/// discards the value.
#define DDSSEC_RETURN_IF_ERROR(...) \
  DDSSEC_RETURN_IF_ERROR_OF(DDSSEC_JOIN(ddssec_result_, __COUNTER__), __VA_ARGS__)

/// `DDSSEC_ASSIGN_OR_RETURN(const auto pair, table.pair_of(handle));` returns the error to the
/// caller, or declares `pair` and moves the value into it. The first argument may also name an
/// existing object, such as `out.pair`. The macro expands to several statements: after `if`,
/// `else`, `for` and `case` it needs braces. The Result lives until the end of the scope, so `const
/// auto& pair` may refer to the value inside it. A macro argument cannot hold the comma of a
/// structured binding: declare the value first, then bind with `const auto& [a, b] = value;`.
#define DDSSEC_ASSIGN_OR_RETURN(declaration, ...) \
  DDSSEC_ASSIGN_OR_RETURN_OF(DDSSEC_JOIN(ddssec_result_, __COUNTER__), declaration, __VA_ARGS__)

// The statements behind both macros. `result` is a name that is unique in the file.
#define DDSSEC_RETURN_IF_ERROR_OF(result, ...)                           \
  do {                                                                   \
    if (auto&& result = (__VA_ARGS__); !result.has_value()) [[unlikely]] \
      return std::unexpected(std::move(result).error());                 \
  } while (false)
#define DDSSEC_ASSIGN_OR_RETURN_OF(result, declaration, ...) \
  auto&& result = (__VA_ARGS__);                             \
  if (!result.has_value()) [[unlikely]]                      \
    return std::unexpected(std::move(result).error());       \
  declaration = *std::move(result)
#define DDSSEC_JOIN(a, b) DDSSEC_JOIN_EXPANDED(a, b)
#define DDSSEC_JOIN_EXPANDED(a, b) a##b
