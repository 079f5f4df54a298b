#include "tests/sim/stolen_keys.hpp"

#include "tests/unit/cryptography/insider.hpp"
#include "tests/unit/rtps_security/attacker.hpp"
#include "wire/gap.hpp"
#include "wire/info_source.hpp"

namespace ddssec::rtps::sim {
namespace {

using testing::forged;

GuidPrefix name_in(BytesView datagram) { return GuidPrefix::from(datagram.subspan(8, 12)); }

// Returns a datagram without the header of the message.
Bytes content_of(const Bytes& datagram) { return {datagram.begin() + kHeaderSize, datagram.end()}; }

}  // namespace

const Datagram* StolenKeys::protected_by(const KeyId& sender) {
  for (int attempt = 0; attempt < 300; ++attempt) {
    const auto& datagram = dice_.of(recorded_);
    if (!std::ranges::search(datagram.octets, sender.octets).empty()) return &datagram;
  }
  return nullptr;
}

std::vector<KeyId> StolenKeys::receivers_of(BytesView datagram) {
  std::vector<KeyId> out;
  for (const auto& part : submessages_of(datagram)) {
    constexpr std::size_t kFixed = kSubmessageHeaderSize + 16 + 4, kEach = 20;
    const bool ends = part[0] == static_cast<std::uint8_t>(SubmessageId::secure_postfix) ||
                      part[0] == static_cast<std::uint8_t>(SubmessageId::secure_rtps_postfix);
    for (auto at = kFixed; ends && at + kEach <= part.size(); at += kEach)
      out.push_back(KeyId::from(part.subspan(at, 4)));
  }
  return out;
}

// Returns a position in the IVs that the key's owner will use soon, because its receivers remember
// those that they had.
cryptography::SendStart StolenKeys::after(BytesView datagram, const KeyId& sender) {
  const auto found = std::ranges::search(datagram, sender.octets);
  const auto at = static_cast<std::size_t>(found.end() - datagram.begin());
  cryptography::Iv iv{};
  if (at + iv.size() > datagram.size()) return {5, 6};
  std::ranges::copy(datagram.subspan(at, iv.size()), iv.begin());
  const auto [session, suffix] = cryptography::parts_of(iv);
  return {session, suffix + 1000 + dice_.below(100'000)};
}

// Protects a sample with a key that its owner gave to all its receivers.
Bytes StolenKeys::sample(const spi::Token& token) {
  auto material = cryptography::read_crypto_token(token);
  if (!material || material->is_none()) return {};
  const auto* heard = protected_by(material->sender_key_id);
  if (heard == nullptr) return {};
  auto macs = receivers_of(heard->octets);
  if (material->has_receiver_key()) macs.push_back(material->receiver_key_id);
  if (!material->has_receiver_key() || dice_.chance(200)) macs.clear();
  const bool whole = dice_.chance(500);
  auto datagram = forger_.sample_by(name_in(heard->octets));
  const auto header = to_bytes(BytesView(datagram).first(kHeaderSize));
  Bytes content(datagram.begin() + kHeaderSize, datagram.end());
  if (whole) {
    InfoSource source;
    source.source.prefix = name_in(header);
    content = forged({}, source);
    content.erase(content.begin(), content.begin() + kHeaderSize);
    content.insert(content.end(), datagram.begin() + kHeaderSize, datagram.end());
  }
  const auto start = after(heard->octets, material->sender_key_id);
  cryptography::testing::Insider insider(std::move(*material), start);
  const auto group = insider.group(
      whole ? cryptography::kMessageFrame : cryptography::kSubmessageFrame, content, macs);
  auto out = header;
  out.insert(out.end(), group.begin(), group.end());
  return out;
}

Bytes StolenKeys::key_exchange(const spi::Token& token, const GuidPrefix& to) {
  auto material = cryptography::read_crypto_token(token);
  if (!material || material->is_none()) return {};
  const auto* heard = protected_by(material->sender_key_id);
  if (heard == nullptr || name_in(heard->octets) == to) return {};
  const auto contents =
      dice_.chance(300) ? std::vector<Bytes>{horizon()} : tokens(name_in(heard->octets), to);
  const auto start = after(heard->octets, material->sender_key_id);
  cryptography::testing::Insider insider(std::move(*material), start);
  auto out = to_bytes(BytesView(heard->octets).first(kHeaderSize));
  for (const auto& content : contents) {
    const auto group = insider.group(cryptography::kSubmessageFrame, content);
    out.insert(out.end(), group.begin(), group.end());
  }
  return out;
}

// The number that comes next is not known, because the honest keys of the pair took the first ones.
std::vector<Bytes> StolenKeys::tokens(const GuidPrefix& from, const GuidPrefix& to) {
  constexpr std::int64_t kNumbers = 64;
  GenericMessage message;
  message.identity.source = {from, kVolatileMessageWriter};
  message.destination_participant = {to, kEntityIdParticipant};
  message.message_class = message_class::kParticipantTokens;
  if (dice_.chance(500)) {
    message.message_class = message_class::kDatawriterTokens;
    message.source_endpoint = forger_.endpoint_guid(true, from);
    message.destination_endpoint = forger_.endpoint_guid(false, to);
  }
  message.data = {cryptography::testing::Insider(cryptography::kAes256Gcm).token()};
  std::vector<Bytes> out;
  for (std::int64_t number = 1; number <= kNumbers; ++number) {
    message.identity.sequence_number = number;
    const auto payload = write_generic_message(message);
    out.push_back(content_of(forged(from, Data{kVolatileMessageReader,
                                               kVolatileMessageWriter,
                                               {number},
                                               {},
                                               PayloadKind::data,
                                               payload})));
  }
  return out;
}

Bytes StolenKeys::horizon() {
  const SequenceNumber later{1'000'000 + static_cast<std::int64_t>(dice_.below(1000))};
  if (dice_.chance(500))
    return content_of(forged({}, Heartbeat{.reader = kVolatileMessageReader,
                                           .writer = kVolatileMessageWriter,
                                           .first = later,
                                           .last = later,
                                           .count = static_cast<std::int32_t>(dice_.next())}));
  return content_of(forged({}, Gap{.reader = kVolatileMessageReader,
                                   .writer = kVolatileMessageWriter,
                                   .start = {1},
                                   .list = SequenceNumberSet(later)}));
}

}  // namespace ddssec::rtps::sim
