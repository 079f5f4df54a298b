#include "plugins/cyclonedds/shared_secrets.hpp"

#include <algorithm>

#include "base/hash.hpp"
#include "base/rollback.hpp"

namespace ddssec::cyclonedds {

SharedSecrets::Block::Block(const spi::SharedSecret& secret) {
  static_assert(sizeof content.octets == spi::SharedSecretOctets::capacity);
  auto& layout = content.layout;
  secret.secret.expose([&](BytesView view) { std::ranges::copy(view, content.octets); });
  layout.shared_secret = content.octets;
  layout.shared_secret_size = static_cast<DDS_Security_long>(secret.secret.size());
  std::ranges::copy(secret.challenge1, layout.challenge1);
  std::ranges::copy(secret.challenge2, layout.challenge2);
  content.peer_ciphers = secret.peer_ciphers;
  content.peer_builtin_endpoints = secret.peer_builtin_endpoints;
  if (secret.peer_prefix) std::ranges::copy(secret.peer_prefix->octets, content.peer_prefix);
  if (secret.own_prefix)
    std::ranges::copy(Guid{*secret.own_prefix, kEntityIdParticipant}.octets(), content.own_guid);
}

SharedSecrets::Block::~Block() { wipe(content.octets); }

void SharedSecrets::note(spi::HandshakeHandle handshake, spi::IdentityHandle initiator,
                         spi::IdentityHandle replier) {
  const std::lock_guard lock(mutex_);
  const HandlePair pair{initiator, replier};
  const auto [noted, is_new] = pair_of_.try_emplace(handshake, pair);
  if (!is_new) return;
  Rollback forget([&] { pair_of_.erase(noted); });
  auto& entries = entries_[pair];
  entries.push_back({handshake, nullptr});
  forget.release();
  forget_oldest_unfinished(entries);
}

void SharedSecrets::forget_oldest_unfinished(std::vector<Entry>& entries) {
  const auto unfinished = [](const Entry& entry) { return entry.block == nullptr; };
  if (std::ranges::count_if(entries, unfinished) <= std::ptrdiff_t{kMaxUnfinishedPerPair}) return;
  const auto oldest = std::ranges::find_if(entries, unfinished);
  pair_of_.erase(oldest->handshake);
  entries.erase(oldest);
}

Result<DDS_Security_SharedSecretHandle> SharedSecrets::pointer_for(
    spi::HandshakeHandle handshake, const spi::SharedSecret& secret) {
  const std::lock_guard lock(mutex_);
  const auto pair = pair_of_.find(handshake);
  if (pair == pair_of_.end()) return fail(Code::foreign_shared_secret);
  auto& entries = entries_[pair->second];
  auto& block = std::ranges::find(entries, handshake, &Entry::handshake)->block;
  if (!block) block = std::make_unique<Block>(secret);
  return reinterpret_cast<DDS_Security_SharedSecretHandle>(&block->content.layout);
}

std::optional<std::pair<spi::IdentityHandle, spi::IdentityHandle>> SharedSecrets::pair_of(
    spi::HandshakeHandle handshake) const {
  const std::lock_guard lock(mutex_);
  const auto known = pair_of_.find(handshake);
  return known == pair_of_.end() ? std::nullopt : std::optional(known->second);
}

void SharedSecrets::drop(spi::IdentityHandle identity) {
  const std::lock_guard lock(mutex_);
  const auto is_of = [&](const HandlePair& pair) {
    return pair.first == identity || pair.second == identity;
  };
  std::erase_if(pair_of_, [&](const auto& entry) { return is_of(entry.second); });
  std::erase_if(entries_, [&](const auto& entry) { return is_of(entry.first); });
}

}  // namespace ddssec::cyclonedds
