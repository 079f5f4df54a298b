#include "plugins/cyclonedds/token_translation.hpp"

#include <cstdlib>
#include <cstring>
#include <utility>

#include "base/hash.hpp"
#include "plugins/cyclonedds/value_translation.hpp"

namespace ddssec::cyclonedds {
namespace {

Result<char*> malloc_string(std::string_view text) {
  if (text.find('\0') != text.npos) return fail(Code::text_holds_nul);
  auto* copy = static_cast<char*>(std::malloc(text.size() + 1));
  if (copy == nullptr) return fail(Code::out_of_memory);
  std::memcpy(copy, text.data(), text.size());
  copy[text.size()] = '\0';
  return copy;
}

// Makes a zeroed sequence buffer; nullptr for no elements.
template <class Sequence>
Status malloc_elements(Sequence& sequence, std::size_t count) {
  if (count == 0) return {};
  using Element = std::remove_pointer_t<decltype(sequence._buffer)>;
  auto* buffer = static_cast<Element*>(std::calloc(count, sizeof(Element)));
  if (buffer == nullptr) return fail(Code::out_of_memory);
  const auto length = static_cast<DDS_Security_unsigned_long>(count);
  sequence = {length, length, buffer};
  return {};
}

Status copy_octets(BytesView octets, DDS_Security_OctetSeq& out) {
  DDSSEC_RETURN_IF_ERROR(malloc_elements(out, octets.size()));
  if (!octets.empty()) std::memcpy(out._buffer, octets.data(), octets.size());
  return {};
}

Status copy_property(const spi::Property& property, DDS_Security_Property_t& out) {
  out.propagate = property.propagate;
  DDSSEC_ASSIGN_OR_RETURN(out.name, malloc_string(property.name));
  DDSSEC_ASSIGN_OR_RETURN(out.value, malloc_string(property.value));
  return {};
}

Status copy_property(const spi::BinaryProperty& property, DDS_Security_BinaryProperty_t& out) {
  out.propagate = property.propagate;
  DDSSEC_ASSIGN_OR_RETURN(out.name, malloc_string(property.name));
  return copy_octets(property.value, out.value);
}

template <class List, class Sequence>
Status copy_all(const List& list, Sequence& out) {
  DDSSEC_RETURN_IF_ERROR(malloc_elements(out, list.size()));
  for (std::size_t i = 0; i < list.size(); ++i)
    DDSSEC_RETURN_IF_ERROR(copy_property(list[i], out._buffer[i]));
  return {};
}

void free_value(DDS_Security_Property_t& property) { std::free(property.value); }
void free_value(DDS_Security_BinaryProperty_t& property) {
  auto& value = property.value;
  if (value._buffer != nullptr) wipe({value._buffer, value._length});
  std::free(value._buffer);
}

template <class Sequence>
void free_all(Sequence& properties) {
  for (DDS_Security_unsigned_long i = 0; properties._buffer && i < properties._length; ++i) {
    std::free(properties._buffer[i].name);
    free_value(properties._buffer[i]);
  }
  std::free(properties._buffer);
}

Status fill_token(const spi::Token& token, DDS_Security_DataHolder& out) {
  DDSSEC_ASSIGN_OR_RETURN(out.class_id, malloc_string(token.class_id));
  DDSSEC_RETURN_IF_ERROR(copy_all(token.properties, out.properties));
  return copy_all(token.binary_properties, out.binary_properties);
}

Status fill_tokens(std::span<const spi::Token> tokens, DDS_Security_DataHolderSeq& out) {
  DDSSEC_RETURN_IF_ERROR(malloc_elements(out, tokens.size()));
  for (std::size_t i = 0; i < tokens.size(); ++i)
    DDSSEC_RETURN_IF_ERROR(fill_token(tokens[i], out._buffer[i]));
  return {};
}

Result<spi::Property> property_from(const DDS_Security_Property_t& property) {
  if (property.name == nullptr || property.value == nullptr) return fail(Code::null_argument);
  return spi::Property{property.name, property.value, property.propagate != 0};
}

Result<spi::BinaryProperty> property_from(const DDS_Security_BinaryProperty_t& property) {
  if (property.name == nullptr) return fail(Code::null_argument);
  DDSSEC_ASSIGN_OR_RETURN(const auto value, octets_from(&property.value));
  return spi::BinaryProperty{property.name, to_bytes(value), property.propagate != 0};
}

template <class List, class Sequence>
Status append_properties(const Sequence& sequence, List& list) {
  DDSSEC_ASSIGN_OR_RETURN(const auto elements, elements_of(sequence));
  for (const auto& element : elements) {
    DDSSEC_ASSIGN_OR_RETURN(auto property, property_from(element));
    list.push_back(std::move(property));
  }
  return {};
}

}  // namespace

Status copy_token(const spi::Token& token, DDS_Security_DataHolder& out) {
  out = {};
  auto status = fill_token(token, out);
  if (!status) free_token(out);
  return status;
}

void free_token(DDS_Security_DataHolder& token) noexcept {
  std::free(token.class_id);
  free_all(token.properties);
  free_all(token.binary_properties);
  token = {};
}

Result<spi::Token> token_from(const DDS_Security_DataHolder* token) {
  if (is_nil(token)) return fail(Code::null_argument);
  if (token->properties._length > spi::kMaxPropertiesPerToken ||
      token->binary_properties._length > spi::kMaxPropertiesPerToken)
    return fail(Code::length_out_of_range);
  spi::Token copy{.class_id = token->class_id};
  DDSSEC_RETURN_IF_ERROR(append_properties(token->properties, copy.properties));
  DDSSEC_RETURN_IF_ERROR(append_properties(token->binary_properties, copy.binary_properties));
  return copy;
}

Status copy_properties(const spi::PropertyList& list, DDS_Security_PropertySeq& out) {
  out = {};
  auto status = copy_all(list, out);
  if (!status) free_properties(out);
  return status;
}

void free_properties(DDS_Security_PropertySeq& properties) noexcept {
  free_all(properties);
  properties = {};
}

Status copy_tokens(std::span<const spi::Token> tokens, DDS_Security_DataHolderSeq& out) {
  out = {};
  auto status = fill_tokens(tokens, out);
  if (!status) free_tokens(out);
  return status;
}

void free_tokens(DDS_Security_DataHolderSeq& tokens) noexcept {
  for (DDS_Security_unsigned_long i = 0; tokens._buffer != nullptr && i < tokens._length; ++i)
    free_token(tokens._buffer[i]);
  std::free(tokens._buffer);
  tokens = {};
}

Result<CryptoTokens> CryptoTokens::from(const DDS_Security_DataHolderSeq* tokens) {
  if (tokens == nullptr) return fail(Code::null_argument);
  if (tokens->_length > spi::kMaxTokensPerMessage) return fail(Code::length_out_of_range);
  CryptoTokens copy({});
  copy.tokens_.reserve(tokens->_length);
  DDSSEC_ASSIGN_OR_RETURN(const auto elements, elements_of(*tokens));
  for (const auto& token : elements) {
    DDSSEC_ASSIGN_OR_RETURN(auto token_value, token_from(&token));
    copy.tokens_.push_back(std::move(token_value));
  }
  return copy;
}

CryptoTokens::~CryptoTokens() {
  for (auto& token : tokens_)
    for (auto& property : token.binary_properties) wipe(property.value);
}

Result<spi::Token> with_text_properties(spi::Token token) {
  if (token.properties.size() + token.binary_properties.size() > spi::kMaxPropertiesPerToken)
    return fail(Code::length_out_of_range);
  for (const auto& property : token.binary_properties) {
    const auto text = as_text(property.value);
    if (text.find('\0') != text.npos)
      return fail(Code::text_holds_nul, {.document = property.name});
    token.properties.push_back({property.name, std::string(text), property.propagate});
  }
  token.binary_properties.clear();
  return token;
}

Result<spi::PropertyList> properties_from(const DDS_Security_PropertySeq& properties) {
  spi::PropertyList list;
  DDSSEC_RETURN_IF_ERROR(append_properties(properties, list));
  return list;
}

Result<spi::PropertyList> properties_from(const DDS_Security_Qos* qos) {
  if (qos == nullptr) return spi::PropertyList{};
  return properties_from(qos->property.value);
}

}  // namespace ddssec::cyclonedds
