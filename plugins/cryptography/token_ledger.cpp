#include "plugins/cryptography/token_ledger.hpp"

#include <algorithm>

namespace ddssec::cryptography {
namespace {

/// Chains what is hashed, each part with its length.
class Chain {
 public:
  void add(BytesView octets) {
    std::array<std::uint8_t, 8> size;
    for (std::size_t i = 0; i < size.size(); ++i)
      size[i] = static_cast<std::uint8_t>(std::uint64_t{octets.size()} >> (8 * i));
    digest_ = sha256({digest_, size, octets});
  }
  const Sha256Digest& digest() const { return digest_; }

 private:
  Sha256Digest digest_{};
};

constexpr std::string_view kDocument = "a key token message";
constexpr std::size_t kEncapsulationSize = 4;

Result<Guid> read_guid(Reader& in) {
  const auto octets = DDSSEC_TRY(in.read_bytes(GuidPrefix::size + EntityId::size));
  return Guid{GuidPrefix::from(octets.first(GuidPrefix::size)),
              EntityId::from(octets.subspan(GuidPrefix::size))};
}

Result<Sha256Digest> read_tokens(Reader& in) {
  constexpr std::size_t kLeastToken = 12;
  const auto count = DDSSEC_TRY(in.read_count(kLeastToken));
  if (count > spi::kMostTokensPerMessage) return fail(Code::length_out_of_range);
  std::vector<spi::Token> tokens;
  for (std::uint32_t i = 0; i < count; ++i) tokens.push_back(DDSSEC_TRY(spi::read_token(in)));
  return digest_of(tokens);
}

/// ParticipantGenericMessage (DDS-Security 7.4.4.4).
Result<std::optional<TokenMessage>> read_generic_message(const DataPiece& piece) {
  constexpr std::size_t kAfterSource = 8 + 24;  // its number, and related_message_identity
  const bool little = (piece.payload[1] & 1) != 0;
  Reader in(piece.payload.subspan(kEncapsulationSize), little ? Endian::little : Endian::big);
  const auto source = DDSSEC_TRY(read_guid(in));
  DDSSEC_TRY(in.skip(kAfterSource));
  const auto participant = DDSSEC_TRY(read_guid(in));
  const auto endpoint = DDSSEC_TRY(read_guid(in));
  const auto source_endpoint = DDSSEC_TRY(read_guid(in));
  const auto class_at = kEncapsulationSize + in.position() + sizeof(std::uint32_t);
  const auto class_id = DDSSEC_TRY(in.read_string());
  TokenMessage message{source_endpoint, endpoint, piece.number, {}, class_at};
  if (class_id == "dds.sec.participant_crypto_tokens") {
    message.remote = {source.prefix, kEntityIdParticipant};
    message.local = participant;
  } else if (class_id != "dds.sec.datawriter_crypto_tokens" &&
             class_id != "dds.sec.datareader_crypto_tokens") {
    return std::nullopt;
  }
  message.tokens = DDSSEC_TRY(read_tokens(in));
  return message;
}

}  // namespace

Result<std::optional<TokenMessage>> read_token_message(const DataPiece& piece) {
  if (!piece.begins_sample) return std::nullopt;
  auto message = read_generic_message(piece);
  if (message) return message;
  return fail(Code::token_source_unreadable,
              {.document = "a key token message", .note = "its tokens cannot be read"});
}

Sha256Digest digest_of(std::span<const spi::Token> tokens) {
  Chain chain;
  for (const auto& token : tokens) {
    chain.add(as_bytes(token.class_id));
    for (const auto& one : token.binary_properties) {
      chain.add(as_bytes(one.name));
      chain.add(one.value);
    }
  }
  return chain.digest();
}

TokenLedger::Subject TokenLedger::subject_of(const Key& key) {
  Subject subject;
  std::copy_n(key.remote.prefix.octets.begin(), subject.size(), subject.begin());
  return subject;
}

Status TokenLedger::note(const TokenMessage& message, std::uint64_t exchange,
                         std::chrono::nanoseconds now) {
  const std::lock_guard lock(mutex_);
  forget_old(now);
  const Key key{message.remote, message.local};
  if (const auto known = entries_.find(key); known != entries_.end()) {
    const auto& entry = known->second;
    const bool is_same = message.number == entry.number && message.tokens == entry.tokens;
    const bool is_past = message.number < entry.number && !entry.is_pending;
    if (entry.exchange == exchange && (is_same || is_past)) return {};
    if (entry.is_pending)
      return fail(Code::crypto_tokens_repeated, {.document = std::string(kDocument),
                                                 .found = key.remote.to_string(),
                                                 .note = "for " + key.local.to_string()});
    erase(known);
  }
  const auto subject = subject_of(key);
  if (counts_[subject].pending >= kMostPending)
    return fail(Code::crypto_tokens_crowded, {.document = std::string(kDocument),
                                              .expected = std::to_string(kMostPending),
                                              .note = "of " + key.remote.to_string()});
  if (counts_[subject].all >= 2 * kMostPending) forget_used(subject);
  auto& counts = counts_[subject];
  ++counts.pending, ++counts.all;
  order_.push_back(key);
  entries_.emplace(
      key, Entry{exchange, message.number, now, true, message.tokens, std::prev(order_.end())});
  groups_[message.tokens].keys.push_back(key);
  return {};
}

void TokenLedger::note_used(std::span<const spi::Token> tokens) {
  const auto digest = digest_of(tokens);
  const std::lock_guard lock(mutex_);
  const auto found = groups_.find(digest);
  if (found == groups_.end()) return;
  auto& group = found->second;
  if (++group.used < group.keys.size()) return;
  for (const auto& key : group.keys) {
    auto& entry = entries_.at(key);
    entry.is_pending = false;
    --counts_.at(subject_of(key)).pending;
  }
  groups_.erase(found);
}

void TokenLedger::forget_old(std::chrono::nanoseconds now) {
  while (!order_.empty()) {
    const auto oldest = entries_.find(order_.front());
    if (now - oldest->second.since < kMemory) return;
    erase(oldest);
  }
}

/// They are remembered only to know repetitions by.
void TokenLedger::forget_used(const Subject& subject) {
  Key first{};
  std::ranges::copy(subject, first.remote.prefix.octets.begin());
  for (auto entry = entries_.lower_bound(first);
       entry != entries_.end() && subject_of(entry->first) == subject;) {
    const auto next = std::next(entry);
    if (!entry->second.is_pending) erase(entry);
    entry = next;
  }
}

void TokenLedger::erase(Entries::iterator entry) {
  leave_group(entry->first, entry->second);
  const auto counts = counts_.find(subject_of(entry->first));
  if (entry->second.is_pending) --counts->second.pending;
  if (--counts->second.all == 0) counts_.erase(counts);
  order_.erase(entry->second.place);
  entries_.erase(entry);
}

/// One that leaves by age counts as used if any was: the others' use must not be taken for granted.
void TokenLedger::leave_group(const Key& key, const Entry& entry) {
  if (!entry.is_pending) return;
  const auto found = groups_.find(entry.tokens);
  auto& group = found->second;
  std::erase(group.keys, key);
  if (group.used > 0) --group.used;
  if (group.keys.empty()) groups_.erase(found);
}

std::size_t TokenLedger::size() const {
  const std::lock_guard lock(mutex_);
  return entries_.size();
}

}  // namespace ddssec::cryptography
