#include "rtps/security/memory_messages.hpp"

#include "base/writer.hpp"

namespace ddssec::rtps {
namespace {

constexpr std::string_view kOfferClass = "org.ddssec.memory_offer:1.0";
constexpr std::string_view kAnswerClass = "org.ddssec.memory_answer:1.0";
constexpr std::string_view kContent = "content";
constexpr std::size_t kTokenSize = 32;
constexpr std::uint32_t kMapped = 0;

spi::Token token_with(std::string_view class_id, Writer content) {
  spi::Token out{.class_id = std::string(class_id)};
  out.binary_properties.resize(1);
  out.binary_properties[0].name = kContent;
  out.binary_properties[0].value = content.take();
  return out;
}

// Returns nullptr for a token of another class.
const Bytes* content_of(const spi::Token& token, std::string_view class_id) {
  return token.class_id == class_id ? spi::find_binary_property(token, kContent) : nullptr;
}

Result<EntityId> read_entity(Reader& reader) {
  DDSSEC_ASSIGN_OR_RETURN(const auto octets, reader.read_bytes(EntityId::size));
  return EntityId::from(octets);
}

Result<MemoryOffer> read_offer(BytesView content) {
  Reader reader(content, Endian::little);
  MemoryOffer out;
  auto& offer = out.offer;
  DDSSEC_ASSIGN_OR_RETURN(out.writer, read_entity(reader));
  DDSSEC_RETURN_IF_ERROR(reader.read_into(offer.name));
  DDSSEC_ASSIGN_OR_RETURN(const auto token, reader.read_bytes(kTokenSize));
  DDSSEC_ASSIGN_OR_RETURN(offer.token, memory::Token::copy_of(token));
  DDSSEC_ASSIGN_OR_RETURN(offer.process, reader.read<std::int32_t>());
  DDSSEC_ASSIGN_OR_RETURN(offer.segment, reader.read<std::uint64_t>());
  DDSSEC_ASSIGN_OR_RETURN(offer.memory.device, reader.read<std::uint64_t>());
  DDSSEC_ASSIGN_OR_RETURN(offer.memory.inode, reader.read<std::uint64_t>());
  DDSSEC_RETURN_IF_ERROR(reader.finish());
  return out;
}

Result<MemoryAnswer> read_answer(BytesView content) {
  Reader reader(content, Endian::little);
  MemoryAnswer out;
  DDSSEC_ASSIGN_OR_RETURN(out.writer, read_entity(reader));
  DDSSEC_ASSIGN_OR_RETURN(out.segment, reader.read<std::uint64_t>());
  DDSSEC_ASSIGN_OR_RETURN(const auto reason, reader.read<std::uint32_t>());
  DDSSEC_RETURN_IF_ERROR(reader.finish());
  if (reason == kMapped) return out;
  out.refusal = reason <= memory::kRefusals ? static_cast<memory::MemoryRefusal>(reason - 1)
                                            : memory::MemoryRefusal::no_answer;
  return out;
}

template <class T>
std::optional<T> as_optional(Result<T> result) {
  return result ? std::optional<T>(*std::move(result)) : std::nullopt;
}

}  // namespace

spi::Token token_of(const MemoryOffer& it) {
  Writer out(Endian::little, 128);  // reserved, so that no reallocation leaves the token behind
  const auto& offer = it.offer;
  out.write_bytes(it.writer.view());
  out.write_bytes(offer.name);
  offer.token.expose([&](BytesView octets) { out.write_bytes(octets); });
  out.write(static_cast<std::int32_t>(offer.process));
  out.write(offer.segment);
  out.write(offer.memory.device);
  out.write(offer.memory.inode);
  return token_with(kOfferClass, std::move(out));
}

spi::Token token_of(const MemoryAnswer& answer) {
  Writer out(Endian::little);
  out.write_bytes(answer.writer.view());
  out.write(answer.segment);
  out.write(answer.refusal ? 1 + static_cast<std::uint32_t>(*answer.refusal) : kMapped);
  return token_with(kAnswerClass, std::move(out));
}

std::optional<MemoryOffer> offer_in(const spi::Token& token) {
  const auto* const content = content_of(token, kOfferClass);
  return content == nullptr ? std::nullopt : as_optional(read_offer(*content));
}

std::optional<MemoryAnswer> answer_in(const spi::Token& token) {
  const auto* const content = content_of(token, kAnswerClass);
  return content == nullptr ? std::nullopt : as_optional(read_answer(*content));
}

}  // namespace ddssec::rtps
