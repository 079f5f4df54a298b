// Errors about the document that a property names.
#pragma once

#include <string>
#include <string_view>

#include "base/result.hpp"

namespace ddssec::authentication {

/// Makes an error in a document an error about the property that names the document.
inline Error in(const Error& error, std::string_view document) {
  auto details = error.details();
  if (!details.document.empty() && details.document != document)
    details.note += (details.note.empty() ? "" : "; ") + details.document;
  details.document = document;
  return {error.code(), std::move(details)};
}

template <class T>
Result<T> in(Result<T> result, std::string_view document) {
  if (result) return result;
  return std::unexpected(in(result.error(), document));
}

}  // namespace ddssec::authentication
