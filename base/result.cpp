#include "base/result.hpp"

#include <fmt/format.h>

#include "base/never_destroyed.hpp"
#include "base/text.hpp"

namespace ddssec {

const ErrorDetails& Error::details() const {
  static const NeverDestroyed<ErrorDetails> kNone;
  return details_ ? *details_ : *kNone;
}

std::string Error::hint() const {
  const auto& own = details().hint;
  return own.empty() ? std::string(info(code_).hint) : own;
}

Error Error::with_default_document(std::string document) const {
  ErrorDetails copy = details();
  if (copy.document.empty()) copy.document = std::move(document);
  return Error(code_, std::move(copy));
}

std::string Error::message() const {
  const auto& d = details();
  std::string text(info(code_).summary);
  if (!d.expected.empty() && !d.found.empty()) {
    text += fmt::format(" (expected {}, found {})", d.expected, d.found);
  } else if (!d.expected.empty()) {
    text += fmt::format(" (expected {})", d.expected);
  } else if (!d.found.empty()) {
    text += fmt::format(" (found {})", d.found);
  }
  if (!d.note.empty()) text += fmt::format("; {}", d.note);
  return text;
}

std::string Error::to_sentence() const {
  const auto& row = info(code_);
  const auto& d = details();
  std::string text;
  if (!d.document.empty()) text += d.document;
  if (d.line > 0) text += fmt::format("{}line {}", text.empty() ? "" : ", ", d.line);
  if (!d.field.empty()) text += fmt::format("{}{}", text.empty() ? "" : ", ", d.field);
  if (!text.empty()) text += ": ";
  // Files and peers choose parts of the text, and it goes to logs and terminals, so it is made
  // printable.
  const auto what_to_do = hint();
  if (what_to_do != kNoHint)
    text += fmt::format("{}; {}", message(), what_to_do);
  else
    text += message();
  return printable(fmt::format("{} [{} {}]", text, row.name, static_cast<int>(code_)));
}

}  // namespace ddssec
