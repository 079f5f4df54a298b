#include "plugins/cryptography/derivation.hpp"

namespace ddssec::cryptography {
namespace {

// Makes a secret from a digest, cut to `size`; the digest itself is wiped.
template <class Key>
Key secret_from(Sha256Digest digest, std::size_t size) {
  auto key = Key::copy_of(BytesView(digest).first(std::min(size, digest.size())));
  wipe(digest);
  return std::move(*key);
}

template <class Derived, class Master>
Derived derive(std::string_view label, const Master& master, const MasterSalt& salt,
               SessionId session) {
  return master.expose([&](BytesView key) {
    return salt.expose([&](BytesView salt_octets) {
      return secret_from<Derived>(hmac_sha256(key, {as_bytes(label), salt_octets, session.view()}),
                                  key.size());
    });
  });
}

template <class Key>
Key derive_from_shared(const spi::SharedSecret& shared, BytesView first, std::string_view cookie,
                       BytesView second) {
  auto hmac_key = sha256({first, as_bytes(cookie), second});
  return shared.secret.expose([&](BytesView secret) {
    return secret_from<Key>(hmac_sha256(hmac_key, {secret}), Key::capacity);
  });
}

}  // namespace

SessionKey derive_session_key(const MasterKey& key, const MasterSalt& salt, SessionId session) {
  return derive<SessionKey>("SessionKey", key, salt, session);
}

SessionReceiverKey derive_session_receiver_key(const MasterReceiverKey& key, const MasterSalt& salt,
                                               SessionId session) {
  return derive<SessionReceiverKey>("SessionReceiverKey", key, salt, session);
}

KeyMaterial derive_key_exchange_material(const spi::SharedSecret& shared) {
  // The cookies have 16 octets each, without a NUL. "keyexchange" is one word in the first one
  // only.
  KeyMaterial material{.kind = kAes256Gcm};
  material.salt = derive_from_shared<MasterSalt>(shared, shared.challenge1, "keyexchange salt",
                                                 shared.challenge2);
  material.sender_key = derive_from_shared<MasterKey>(shared, shared.challenge2, "key exchange key",
                                                      shared.challenge1);
  return material;
}

}  // namespace ddssec::cryptography
