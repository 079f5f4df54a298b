// A peer whose certificate was believed and fits its GUID: not yet that it holds the key.
#pragma once

#include <optional>

#include "base/ids.hpp"
#include "pki/chain.hpp"
#include "plugins/authentication/credentials.hpp"
#include "plugins/authentication/trust_store.hpp"

namespace ddssec::authentication {

/// Proof that c.id chains to a CA of ours, belongs to the GUID, and that c.pdata is about that
/// GUID. Only `judge` makes one.
class JudgedPeer {
 public:
  /// Cheap checks first, public-key work last. Errors: participant_data_malformed,
  /// participant_guid_missing, participant_guid_differs, guid_not_bound_to_subject, those of
  /// Certificate::from_pem and ChainVerifier::verify.
  static Result<JudgedPeer> judge(const Credentials& credentials, const Guid& guid,
                                  const TrustStore& trust, WallTime now);

  const pki::ChainValid& chain() const { return chain_; }
  const pki::Certificate& certificate() const { return chain_.certificate(); }

  /// AuthenticatedPeerCredentialToken: binary c.id and c.perm (DDS-Security 9.3.2.2). c.perm comes
  /// without the NUL that Cyclone DDS appends; it is empty if the peer has no permissions. Then
  /// c.kagree_algo, for access control, which knows what the governance allows.
  /// Nothing once it was dropped.
  const std::optional<spi::Token>& credential() const { return credential_; }
  /// It is not asked for again; the peer chose how large it is.
  void drop_credential() { credential_.reset(); }

  /// What its participant data says that it can decrypt; proven once a signature is.
  spi::CipherMask ciphers() const { return ciphers_; }
  std::uint32_t builtin_endpoints() const { return builtin_endpoints_; }
  /// Where its participant data says that it receives discovery.
  const std::vector<spi::UdpAddress>& addresses() const { return addresses_; }

 private:
  JudgedPeer(pki::ChainValid chain, spi::Token credential, BytesView participant_data);

  pki::ChainValid chain_;
  std::optional<spi::Token> credential_;
  spi::CipherMask ciphers_;
  std::uint32_t builtin_endpoints_;
  std::vector<spi::UdpAddress> addresses_;
};

}  // namespace ddssec::authentication
