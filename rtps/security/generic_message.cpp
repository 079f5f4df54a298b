#include "rtps/security/generic_message.hpp"

#include <algorithm>
#include <utility>

#include "base/hash.hpp"
#include "rtps/cdr/encapsulation.hpp"
#include "wire/submessage.hpp"

namespace ddssec::rtps {
namespace {

// The size of a class id and two counts.
constexpr std::size_t kMinTokenSize = 12;

void write(Writer& out, const MessageIdentity& identity) {
  out.write_bytes(identity.source.octets());
  out.write_aligned(identity.sequence_number);
}

Result<MessageIdentity> read_identity(Reader& reader) {
  DDSSEC_ASSIGN_OR_RETURN(const auto guid, read_guid(reader));
  MessageIdentity identity{guid, 0};
  DDSSEC_ASSIGN_OR_RETURN(identity.sequence_number, reader.read_aligned<std::int64_t>());
  return identity;
}

// Upper bound for the name, the value and their lengths, each aligned and terminated by NUL.
std::size_t max_size_of(const auto& property) {
  return property.name.size() + property.value.size() + 16;
}

std::size_t max_size_of(const GenericMessage& message) {
  std::size_t size = 192 + message.message_class.size();
  for (const auto& token : message.data) {
    size += token.class_id.size() + 24;
    for (const auto& property : token.properties) size += max_size_of(property);
    for (const auto& property : token.binary_properties) size += max_size_of(property);
  }
  return size;
}

}  // namespace

Bytes write_generic_message(const GenericMessage& message) {
  // The memory is reserved at once, so that no reallocation leaves an unwiped block with keys
  // behind.
  Writer out(Endian::little, max_size_of(message));
  write(out, message.identity);
  write(out, message.related);
  for (const auto* guid :
       {&message.destination_participant, &message.destination_endpoint, &message.source_endpoint})
    out.write_bytes(guid->octets());
  out.write_string(message.message_class);
  out.write_aligned(static_cast<std::uint32_t>(message.data.size()));
  for (const auto& token : message.data) spi::write_token(out, token);
  out.align(4);
  // Alignment counts from the end of the encapsulation.
  Bytes payload(kEncapsulationSize + out.size());
  payload[1] = 1;
  std::ranges::copy(out.view(), payload.begin() + kEncapsulationSize);
  auto written = out.take();
  wipe(written);
  return payload;
}

Result<GenericMessage> read_generic_message(BytesView payload) {
  DDSSEC_ASSIGN_OR_RETURN(const auto opened, open_payload(payload));
  if (opened.encapsulation != Encapsulation::cdr) return fail(Code::rtps_encapsulation_unsupported);
  Reader reader(opened.body, opened.endian);
  GenericMessage message;
  DDSSEC_ASSIGN_OR_RETURN(message.identity, read_identity(reader));
  DDSSEC_ASSIGN_OR_RETURN(message.related, read_identity(reader));
  DDSSEC_ASSIGN_OR_RETURN(message.destination_participant, read_guid(reader));
  DDSSEC_ASSIGN_OR_RETURN(message.destination_endpoint, read_guid(reader));
  DDSSEC_ASSIGN_OR_RETURN(message.source_endpoint, read_guid(reader));
  DDSSEC_ASSIGN_OR_RETURN(message.message_class, reader.read_string());
  DDSSEC_ASSIGN_OR_RETURN(const auto count, reader.read_count(kMinTokenSize));
  if (count > spi::kMaxTokensPerMessage) return fail(Code::length_out_of_range);
  for (std::uint32_t i = 0; i < count; ++i) {
    DDSSEC_ASSIGN_OR_RETURN(auto token, spi::read_token(reader));
    message.data.push_back(std::move(token));
  }
  return message;
}

}  // namespace ddssec::rtps
