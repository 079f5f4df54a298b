#include "governance/doctor/stock_spelling.hpp"

#include <algorithm>
#include <charconv>

#include "governance/doctor/library_search.hpp"

namespace ddssec::governance::doctor {
namespace {

namespace fs = std::filesystem;

// As strtol with base 0 reads it: hexadecimal after 0x, octal after 0.
bool is_number_for_strtol(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  const bool is_hexadecimal = text.starts_with("0x") || text.starts_with("0X");
  if (is_hexadecimal) text.remove_prefix(2);
  if (text.starts_with('-')) return false;
  const int base = is_hexadecimal ? 16 : text.starts_with('0') ? 8 : 10;
  DomainId id = 0;
  const auto* const end = text.data() + text.size();
  const auto read = std::from_chars(text.data(), end, id, base);
  return !text.empty() && read.ec == std::errc() && read.ptr == end && id <= kHighestDomainId;
}

// With an empty <topic_expression> Cyclone DDS crashes.
bool may_be_empty(std::string_view element) {
  constexpr std::string_view kNeeded[] = {"<topic_expression>", "<subject_name>", "<not_before>",
                                          "<not_after>"};
  return std::ranges::find(kNeeded, element) == std::end(kNeeded);
}

template <class Model>
bool is_unpredictable(const LoadedDocument<Model>& document) {
  if (!document.readable || !document.cyclonedds_belief) return false;
  if (document.form.ambiguous) return true;
  return !document.model && !document.parsed && cyclonedds_starts_with(document.parsed.error());
}

}  // namespace

bool cyclonedds_starts_with(const Error& error) {
  const auto& details = error.details();
  switch (error.code()) {
    case Code::value_not_default:
      return true;
    case Code::value_not_date_time:
      return details.field == "<not_before>";
    case Code::value_not_domain_id:
      return is_number_for_strtol(details.found);
    case Code::element_empty:
      return may_be_empty(details.field);
    case Code::xml_not_well_formed:
      return details.found == "XML_ERROR_PARSING_ATTRIBUTE";
    default:
      return false;
  }
}

bool has_other_certificate_label(const fs::path& path) {
  std::error_code ignored;
  if (!fs::is_regular_file(path, ignored)) return false;
  const auto text = library_octets(path);
  return text.contains("-----BEGIN X509 CERTIFICATE-----") ||
         text.contains("-----BEGIN TRUSTED CERTIFICATE-----");
}

bool is_key_of_explicit_curve(const Error& error) {
  return error.code() == Code::key_not_allowed && error.details().found == "EC of 256 bits";
}

const fs::path* unpredictable_file(const LoadedFolder& folder) {
  const auto& paths = folder.paths;
  const auto is_labelled = [](const auto& piece, const fs::path& path) {
    return !piece && has_other_certificate_label(path);
  };
  if (is_labelled(folder.identity_cas, paths.identity_ca)) return &paths.identity_ca;
  if (is_labelled(folder.certificate, paths.certificate)) return &paths.certificate;
  if (is_labelled(folder.permissions_cas, paths.permissions_ca)) return &paths.permissions_ca;
  if (!folder.key && is_key_of_explicit_curve(folder.key.error())) return &paths.key;
  if (is_unpredictable(folder.governance)) return &paths.governance;
  if (is_unpredictable(folder.permissions)) return &paths.permissions;
  return nullptr;
}

}  // namespace ddssec::governance::doctor
