// Finds one document in the answer of a record of documents in use.
#pragma once

#include <string_view>

#include <nlohmann/json.hpp>

#include "base/documents_in_use.hpp"

namespace ddssec::test {

/// Returns the document of this kind of the first participant; null if there is none.
inline nlohmann::json recorded_document(const DocumentsInUse& record, std::string_view kind) {
  const auto answer = nlohmann::json::parse(record.to_json());
  if (answer["participants"].empty()) return {};
  for (const auto& document : answer["participants"][0]["documents"])
    if (document["kind"] == kind) return document;
  return {};
}

}  // namespace ddssec::test
