#include "plugins/cyclonedds/shared_secrets.hpp"

#include <algorithm>

#include "base/hash.hpp"

namespace ddssec::cyclonedds {

SharedSecrets::Block::Block(const spi::SharedSecret& secret) {
  secret.secret.expose([&](BytesView view) { std::ranges::copy(view, octets.begin()); });
  layout.shared_secret = octets.data();
  layout.shared_secret_size = static_cast<DDS_Security_long>(secret.secret.size());
  std::ranges::copy(secret.challenge1, layout.challenge1);
  std::ranges::copy(secret.challenge2, layout.challenge2);
}

SharedSecrets::Block::~Block() { wipe(octets); }

void SharedSecrets::note(spi::HandshakeHandle handshake, spi::IdentityHandle initiator,
                         spi::IdentityHandle replier) {
  const std::lock_guard lock(mutex_);
  entries_.try_emplace(handshake, Entry{initiator, replier, nullptr});
}

Result<DDS_Security_SharedSecretHandle> SharedSecrets::hand_out(spi::HandshakeHandle handshake,
                                                                const spi::SharedSecret& secret) {
  const std::lock_guard lock(mutex_);
  const auto entry = entries_.find(handshake);
  if (entry == entries_.end()) return fail(Code::foreign_shared_secret);
  auto& block = entry->second.block;
  if (!block) block = std::make_unique<Block>(secret);
  return reinterpret_cast<DDS_Security_SharedSecretHandle>(&block->layout);
}

void SharedSecrets::drop(spi::IdentityHandle identity) {
  const std::lock_guard lock(mutex_);
  std::erase_if(entries_, [&](const auto& entry) {
    return entry.second.initiator == identity || entry.second.replier == identity;
  });
}

}  // namespace ddssec::cyclonedds
