// Compares many pairs of documents in one process. Reads a JSON object from each line:
//   {"kind":"governance" or "permissions","old":"XML","new":"XML"}
// and writes one for each: the product's verdict and changes, or {"error":"..."}. Names may be any
// octets, so they are written in hexadecimal.
#include <iostream>
#include <string>

#include <nlohmann/json.hpp>

#include "base/bytes.hpp"
#include "governance/compare/governance_diff.hpp"
#include "governance/compare/permissions_diff.hpp"
#include "governance/read.hpp"

namespace {

using namespace ddssec;
using Json = nlohmann::json;

std::string hex(std::string_view octets) { return to_hex(as_bytes(octets)); }

Json hex_of_all(const std::vector<std::string>& names) {
  Json out = Json::array();
  for (const auto& name : names) out.push_back(hex(name));
  return out;
}

Json scope_json(const governance::DomainScope& scope) {
  Json domains = Json::array();
  for (const auto& range : scope.domains) domains.push_back({range.first, range.last});
  // Without tags in the documents, the tag is the empty one.
  return {{"domains", domains},
          {"tags", scope.has_tags ? hex_of_all(scope.tags.examples) : Json::array({""})}};
}

Json names_of(const governance::Properties& properties) {
  Json names = Json::array();
  for (const auto property : governance::listed(properties))
    names.push_back(governance::to_string(property));
  return names;
}

Json to_json(const governance::GovernanceChange& change) {
  Json out = scope_json(change.scope);
  out["element"] = change.element.element;
  out["old"] = change.element.old_value;
  out["new"] = change.element.new_value;
  out["class"] = governance::to_string(change.element.change);
  out["topic"] = change.is_about_topics ? Json(hex(change.witness)) : Json();
  out["lost"] = names_of(change.lost);
  out["gained"] = names_of(change.gained);
  return out;
}

Json to_json(const governance::PermissionChange& change) {
  Json out = scope_json(change.scope);
  Json tags = Json::array();
  for (const auto& tag : change.entities.example_data_tags) tags.push_back({tag.name, tag.value});
  out["subject"] = change.subject;
  out["element"] = change.element;
  out["operation"] = change.operation;
  out["old"] = change.old_value;
  out["new"] = change.new_value;
  out["class"] = governance::to_string(change.change);
  out["topic"] = change.is_about_topics ? Json(hex(change.witness)) : Json();
  out["partitions"] = hex_of_all(change.entities.example_partitions);
  out["data_tags"] = tags;
  return out;
}

// Returns the readings that are about expressions.
Json to_json(const governance::Interpretations& interpretations) {
  Json out = Json::array();
  for (const auto& reading : interpretations.all)
    if (!reading.expression.empty()) out.push_back({reading.is_new, hex(reading.expression)});
  return out;
}

template <class Diff>
Json result_of(const Diff& diff) {
  Json changes = Json::array();
  for (const auto& change : diff.changes) changes.push_back(to_json(change));
  return {{"verdict", governance::to_string(diff.verdict)},
          {"changes", changes},
          {"readings", to_json(diff.interpretations)}};
}

// Reads both documents from XML text, as the program does, and compares them.
template <class Read>
Json compared(const Json& pair, Read read) {
  const auto before = read(as_bytes(pair["old"].template get_ref<const std::string&>()));
  const auto after = read(as_bytes(pair["new"].template get_ref<const std::string&>()));
  if (!before) return {{"error", "the old document: " + before.error().to_sentence()}};
  if (!after) return {{"error", "the new document: " + after.error().to_sentence()}};
  return result_of(governance::compare(*before, *after));
}

}  // namespace

int main() {
  std::string line;
  while (std::getline(std::cin, line)) {
    const auto pair = Json::parse(line);
    const auto read_governance = [](BytesView xml) { return governance::read_governance(xml); };
    const auto read_permissions = [](BytesView xml) { return governance::read_permissions(xml); };
    const auto answer = pair["kind"] == "governance" ? compared(pair, read_governance)
                                                     : compared(pair, read_permissions);
    std::cout << answer.dump(-1, ' ', true, Json::error_handler_t::replace) << '\n';
  }
  return std::cout.good() ? 0 : 1;
}
