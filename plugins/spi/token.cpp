#include "plugins/spi/token.hpp"

#include <algorithm>

#include "base/hash.hpp"

namespace ddssec::spi {
namespace {

template <class List, class WriteValue>
void write_propagated(Writer& writer, const List& list, WriteValue&& write_value) {
  const auto count = std::ranges::count_if(list, [](const auto& p) { return p.propagate; });
  writer.write_aligned(static_cast<std::uint32_t>(count));
  for (const auto& property : list) {
    if (!property.propagate) continue;
    writer.write_string(property.name);
    write_value(property.value);
  }
}

// A property has at least two length fields. This smallest size bounds a count.
constexpr std::size_t kMinPropertySize = 8;

Result<std::uint32_t> read_property_count(Reader& reader) {
  DDSSEC_ASSIGN_OR_RETURN(const auto count, reader.read_count(kMinPropertySize));
  if (count > kMaxPropertiesPerToken) return fail(Code::length_out_of_range);
  return count;
}

}  // namespace

BinaryProperty::~BinaryProperty() { wipe(value); }

const Bytes* find_binary_property(const Token& token, std::string_view name) {
  const auto found = std::ranges::find(token.binary_properties, name, &BinaryProperty::name);
  return found == token.binary_properties.end() ? nullptr : &found->value;
}

std::size_t binary_octets(const Token& token) {
  std::size_t octets = 0;
  for (const auto& property : token.binary_properties) octets += property.value.size();
  return octets;
}

void write_token(Writer& writer, const Token& token) {
  writer.write_string(token.class_id);
  write_propagated(writer, token.properties,
                   [&](const std::string& value) { writer.write_string(value); });
  write_propagated(writer, token.binary_properties,
                   [&](const Bytes& value) { writer.write_octet_sequence(value); });
}

Result<Token> read_token(Reader& reader) {
  Token token;
  DDSSEC_ASSIGN_OR_RETURN(token.class_id, reader.read_string());
  DDSSEC_ASSIGN_OR_RETURN(const auto properties, read_property_count(reader));
  for (std::uint32_t i = 0; i < properties; ++i) {
    DDSSEC_ASSIGN_OR_RETURN(const auto name, reader.read_string());
    DDSSEC_ASSIGN_OR_RETURN(const auto value, reader.read_string());
    token.properties.push_back({std::string(name), std::string(value)});
  }
  DDSSEC_ASSIGN_OR_RETURN(const auto binary_properties, read_property_count(reader));
  for (std::uint32_t i = 0; i < binary_properties; ++i) {
    DDSSEC_ASSIGN_OR_RETURN(const auto name, reader.read_string());
    DDSSEC_ASSIGN_OR_RETURN(const auto value, reader.read_octet_sequence());
    token.binary_properties.push_back({std::string(name), to_bytes(value)});
  }
  return token;
}

Bytes serialize_binary_properties(std::span<const NamedOctets> properties) {
  Writer writer(Endian::big);
  writer.write(static_cast<std::uint32_t>(properties.size()));
  for (const auto& property : properties) {
    writer.write_string(property.name);
    writer.write_octet_sequence(property.value);
  }
  return writer.take();
}

}  // namespace ddssec::spi
