// Errors about the document that a property names.
#pragma once

#include <string_view>

#include "base/result.hpp"

namespace ddssec::authentication {

/// Makes an error in a document an error about the property that names the document.
inline Error with_property(const Error& error, std::string_view property) {
  auto details = error.details();
  if (!details.document.empty() && details.document != property)
    details.note += (details.note.empty() ? "" : "; ") + details.document;
  details.document = property;
  return {error.code(), std::move(details)};
}

/// Returns a success as it is, and an error as an error about the property.
template <class T>
Result<T> with_property(Result<T> result, std::string_view property) {
  if (result) return result;
  return std::unexpected(with_property(result.error(), property));
}

}  // namespace ddssec::authentication
