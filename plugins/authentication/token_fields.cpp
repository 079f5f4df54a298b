#include "plugins/authentication/token_fields.hpp"

#include <algorithm>
#include <array>
#include <string>

namespace ddssec::authentication {
namespace {

struct ClassRow {
  TokenClass token_class;
  std::string_view class_id;
  std::string_view suffix;
  std::string_view document;
};

constexpr std::array kClasses = {
    ClassRow{TokenClass::identity, "DDS:Auth:PKI-DH:1.0", "", "identity token"},
    ClassRow{TokenClass::auth_request, "DDS:Auth:PKI-DH:1.0+AuthReq", "+AuthReq", "auth request"},
    ClassRow{TokenClass::request, "DDS:Auth:PKI-DH:1.0+Req", "+Req", "handshake request"},
    ClassRow{TokenClass::reply, "DDS:Auth:PKI-DH:1.0+Reply", "+Reply", "handshake reply"},
    ClassRow{TokenClass::final, "DDS:Auth:PKI-DH:1.0+Final", "+Final", "handshake final"},
    ClassRow{TokenClass::renewal, "DDS:Auth:PKI-DH:1.0+org.ddssec.Renewal", "+org.ddssec.Renewal",
             "renewed documents"},
    ClassRow{TokenClass::renewal_accepted, "DDS:Auth:PKI-DH:1.0+org.ddssec.RenewalTaken",
             "+org.ddssec.RenewalTaken", "answer to renewed documents"},
};
constexpr std::string_view kNameAndMajor = "DDS:Auth:PKI-DH:1.";

const ClassRow& row_of(TokenClass token_class) {
  return *std::ranges::find(kClasses, token_class, &ClassRow::token_class);
}

// The names of fields that have their own rule for their length.
constexpr std::array<std::string_view, 13> kKnownNames = {
    "c.id",         "c.perm",        kParticipantDataName,
    "c.dsign_algo", "c.kagree_algo", kHashC1,
    kHashC2,        kDh1.name,       kDh2.name,
    kChallenge1,    kChallenge2,     kFutureChallenge,
    kSignature.name};

bool fits(const spi::BinaryProperty& property) {
  if (property.name.size() > kMaxTextOctets) return false;
  const bool known = std::ranges::find(kKnownNames, property.name) != kKnownNames.end();
  return known || property.value.size() <= kMaxUnknownOctets;
}

bool fits(const spi::Property& property) {
  return property.name.size() <= kMaxTextOctets && property.value.size() <= kMaxTextOctets;
}

bool fits(const spi::Token& token) {
  return token.properties.size() <= spi::kMaxPropertiesPerToken &&
         token.binary_properties.size() <= spi::kMaxPropertiesPerToken &&
         std::ranges::all_of(token.properties, [](const auto& p) { return fits(p); }) &&
         std::ranges::all_of(token.binary_properties, [](const auto& p) { return fits(p); });
}

std::string octets(std::size_t count) { return std::to_string(count) + " octets"; }

std::string range(const FieldRule& rule) {
  return rule.min == rule.max ? octets(rule.min)
                              : std::to_string(rule.min) + " to " + octets(rule.max);
}

}  // namespace

std::string_view class_id_of(TokenClass token_class) { return row_of(token_class).class_id; }

std::string_view document_name(TokenClass token_class) { return row_of(token_class).document; }

std::optional<TokenClass> claimed_class_of(std::string_view class_id) {
  for (const auto& row : kClasses)
    if (!row.suffix.empty() && class_id.ends_with(row.suffix)) return row.token_class;
  return std::nullopt;
}

std::optional<TokenClass> token_class_of(std::string_view class_id) {
  if (!class_id.starts_with(kNameAndMajor)) return std::nullopt;
  class_id.remove_prefix(kNameAndMajor.size());
  const auto digits = std::min(class_id.find_first_not_of("0123456789"), class_id.size());
  if (digits == 0 || digits > 9) return std::nullopt;
  const auto row = std::ranges::find(kClasses, class_id.substr(digits), &ClassRow::suffix);
  if (row == kClasses.end()) return std::nullopt;
  return row->token_class;
}

Result<TokenFields> TokenFields::of(const spi::Token& token, TokenClass expected) {
  const std::string document(document_name(expected));
  if (token_class_of(token.class_id) != expected)
    return fail(Code::token_class_wrong, {.document = document,
                                          .expected = std::string(class_id_of(expected)),
                                          .found = token.class_id.substr(0, 64)});
  if (!fits(token)) return fail(Code::token_too_large, {.document = document});
  return TokenFields(token, expected);
}

Result<std::optional<BytesView>> TokenFields::optional(const FieldRule& rule) const {
  const std::string document(document_name(class_));
  std::optional<BytesView> found;
  for (const auto& property : token_->binary_properties) {
    if (property.name != rule.name) continue;
    if (found)
      return fail(Code::token_field_repeated,
                  {.document = document, .field = std::string(rule.name)});
    found = BytesView(property.value);
  }
  if (found && (found->size() < rule.min || found->size() > rule.max))
    return fail(Code::token_field_length, {.document = document,
                                           .field = std::string(rule.name),
                                           .expected = range(rule),
                                           .found = octets(found->size())});
  return found;
}

Result<BytesView> TokenFields::required(const FieldRule& rule) const {
  DDSSEC_ASSIGN_OR_RETURN(const auto found, optional(rule));
  if (!found)
    return fail(Code::token_field_missing,
                {.document = std::string(document_name(class_)), .field = std::string(rule.name)});
  return *found;
}

Result<spi::Challenge> TokenFields::challenge(std::string_view name) const {
  spi::Challenge challenge{};
  DDSSEC_ASSIGN_OR_RETURN(const auto found, required({name, challenge.size(), challenge.size()}));
  std::ranges::copy(found, challenge.begin());
  return challenge;
}

Result<std::optional<Sha256Digest>> TokenFields::optional_hash(std::string_view name) const {
  Sha256Digest digest{};
  DDSSEC_ASSIGN_OR_RETURN(const auto found, optional({name, digest.size(), digest.size()}));
  if (!found) return std::nullopt;
  std::ranges::copy(*found, digest.begin());
  return digest;
}

Status check_repeated(std::string_view name, const std::optional<BytesView>& received,
                      BytesView known, TokenClass token_class) {
  if (!received || std::ranges::equal(*received, known)) return {};
  return fail(Code::token_field_differs,
              {.document = std::string(document_name(token_class)),
               .field = std::string(name),
               .expected = to_hex(known.first(std::min<std::size_t>(known.size(), 16))),
               .found = to_hex(received->first(std::min<std::size_t>(received->size(), 16)))});
}

}  // namespace ddssec::authentication
