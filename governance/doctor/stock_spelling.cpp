#include "governance/doctor/stock_spelling.hpp"

#include <algorithm>
#include <charconv>
#include <ctime>
#include <initializer_list>
#include <iomanip>
#include <locale>
#include <sstream>
#include <string>

#include "governance/doctor/checks.hpp"
#include "governance/doctor/library_search.hpp"
#include "pki/smime_diagnosis.hpp"

namespace ddssec::governance::doctor {
namespace {

namespace fs = std::filesystem;

// True for a number as strtol reads it with base 0: hexadecimal after 0x, octal after 0. The result
// is then cut to an int, so -0 and 4294967296 are 0.
bool is_number_for_strtol(std::string_view text) {
  const bool is_negative = text.starts_with('-');
  if (is_negative || text.starts_with('+')) text.remove_prefix(1);
  const bool is_hexadecimal = text.starts_with("0x") || text.starts_with("0X");
  if (is_hexadecimal) text.remove_prefix(2);
  if (text.starts_with('-')) return false;
  const int base = is_hexadecimal ? 16 : text.starts_with('0') ? 8 : 10;
  std::int64_t number = 0;
  const auto* const end = text.data() + text.size();
  const auto read = std::from_chars(text.data(), end, number, base);
  const auto id = static_cast<std::int32_t>(is_negative ? -number : number);
  return !text.empty() && read.ec == std::errc() && read.ptr == end && id >= 0 &&
         id <= static_cast<std::int32_t>(kMaxGovernedDomainId);
}

bool is_one_of(std::string_view element, std::initializer_list<std::string_view> elements) {
  return std::ranges::find(elements, element) != elements.end();
}

// True if the product starts with a second element where only one is allowed. Measured: not with
// every kind. Of documents with two <permissions> it refuses some and starts with others.
bool cyclonedds_repeats(std::string_view element) { return element != "<domain_access_rules>"; }
bool fastdds_repeats(std::string_view element) {
  return is_one_of(element,
                   {"<permissions>", "<not_before>", "<not_after>", "<default>", "<topics>"});
}

// False for elements that must not be empty. With an empty <topic_expression> Cyclone DDS crashes.
bool may_be_empty(std::string_view element) {
  return !is_one_of(element,
                    {"<topic_expression>", "<subject_name>", "<not_before>", "<not_after>"});
}

// True for elements that the product accepts empty, although they must list something. They then
// apply to no topic.
bool cyclonedds_misses_nothing_in(std::string_view element) {
  return is_one_of(element, {"<publish>", "<subscribe>", "<topics>", "<partitions>"});
}
bool fastdds_misses_nothing_in(std::string_view element) {
  return is_one_of(element, {"<publish>", "<subscribe>"});
}

// Fast DDS reads dates with std::get_time, and ignores any text after the seconds.
bool is_date_for_fastdds(const std::string& text) {
  std::istringstream in(text);
  in.imbue(std::locale::classic());
  std::tm read{};
  in >> std::get_time(&read, "%Y-%m-%dT%H:%M:%S");
  return !in.fail();
}

// True except for NUL: both products read all other control characters.
bool is_other_control_character(const ErrorDetails& details) {
  return !details.found.ends_with(" 00");
}

bool starts_with(Product product, const Error& error) {
  return product == Product::cyclonedds ? cyclonedds_starts_with(error)
                                        : fastdds_starts_with(error);
}

template <class Model>
bool is_unpredictable(const LoadedDocument<Model>& document, Product product,
                      const Lineup& lineup) {
  const bool is_cyclonedds = product == Product::cyclonedds;
  const auto& verdict = is_cyclonedds ? document.cyclonedds_verdict : document.fastdds_verdict;
  if (!document.readable || !verdict) return false;
  if (document.form.ambiguous) return true;
  const bool is_refused = std::ranges::any_of(document.left_out, [&](Variant variant) {
    return measured(variant, lineup).of(product) == Outcome::fail;
  });
  if (is_refused) return false;
  // Fast DDS reads only the first piece of a value in pieces.
  if (document.model && !document.parsed) return !is_cyclonedds && document.has_joined_values;
  return !document.model && !document.parsed && starts_with(product, document.unread());
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
    case Code::element_repeated:
      return cyclonedds_repeats(details.field);
    case Code::element_missing:
      return cyclonedds_misses_nothing_in(details.field);
    case Code::xml_control_character:
      return is_other_control_character(details);
    case Code::xml_not_well_formed:
      return details.found == "XML_ERROR_PARSING_ATTRIBUTE";
    default:
      return false;
  }
}

bool fastdds_starts_with(const Error& error) {
  const auto& details = error.details();
  switch (error.code()) {
    case Code::value_not_date_time:
      return is_date_for_fastdds(details.found);
    case Code::element_missing:
      return fastdds_misses_nothing_in(details.field);
    case Code::xml_control_character:
      return is_other_control_character(details);
    case Code::value_not_domain_id:
    case Code::domain_range_reversed:
    case Code::text_unexpected:
    case Code::attribute_unknown:
      return true;
    case Code::value_not_boolean:
      return !details.found.empty() &&
             details.found.find_first_not_of("0123456789+-") == details.found.npos;
    case Code::element_repeated:
      return fastdds_repeats(details.field);
    case Code::xml_not_well_formed:
      return details.expected == "one root element";
    default:
      return false;
  }
}

bool has_certificate_for_openssl(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored) &&
         pki::ca_announced_by_fastdds(as_bytes(library_octets(path)));
}

bool is_key_of_explicit_curve(const Error& error) {
  return error.code() == Code::key_not_allowed && error.details().found == "EC of 256 bits";
}

const fs::path* unpredictable_file(const LoadedFolder& folder, Product product,
                                   const Lineup& lineup) {
  const auto& paths = folder.paths;
  const auto is_labelled = [&](const auto& piece, const fs::path& path) {
    return !piece && piece.error().code() != Code::key_not_allowed &&
           has_certificate_for_openssl(path);
  };
  // Fast DDS accepts more kinds of keys than ddssec reads.
  const auto has_other_key = [&](const auto& piece, const fs::path& path) {
    return product == Product::fastdds && !piece && piece.error().code() == Code::key_not_allowed &&
           outcomes_of_key(paths, path, piece.error(), lineup).fastdds < Outcome::late;
  };
  if (product == Product::ddssec) return nullptr;
  if (has_other_key(folder.identity_cas, paths.identity_ca)) return &paths.identity_ca;
  if (has_other_key(folder.certificate, paths.certificate)) return &paths.certificate;
  if (is_labelled(folder.identity_cas, paths.identity_ca)) return &paths.identity_ca;
  if (is_labelled(folder.certificate, paths.certificate)) return &paths.certificate;
  if (is_labelled(folder.permissions_cas, paths.permissions_ca)) return &paths.permissions_ca;
  if (product == Product::cyclonedds && !folder.key && is_key_of_explicit_curve(folder.key.error()))
    return &paths.key;
  if (is_unpredictable(folder.governance, product, lineup)) return &paths.governance;
  if (is_unpredictable(folder.permissions, product, lineup)) return &paths.permissions;
  return nullptr;
}

}  // namespace ddssec::governance::doctor
