// A peer whose certificate is valid and belongs to its GUID. It is not proven yet that the peer has
// the private key.
#pragma once

#include <optional>

#include "base/ids.hpp"
#include "pki/chain.hpp"
#include "plugins/authentication/credentials.hpp"
#include "plugins/authentication/ocsp_status.hpp"
#include "plugins/authentication/participant_data.hpp"
#include "plugins/authentication/trust_store.hpp"

namespace ddssec::authentication {

/// Proof that c.id chains to a trusted CA and belongs to the GUID, and that c.pdata is about that
/// GUID. Only `judge` creates one.
class JudgedPeer {
 public:
  /// Checks the credentials. Cheap checks come first, public-key operations last. Errors:
  /// participant_data_malformed, participant_guid_missing, participant_guid_differs,
  /// guid_not_bound_to_subject, those of Certificate::from_pem and ChainVerifier::verify.
  static Result<JudgedPeer> judge(const Credentials& credentials, const Guid& guid,
                                  const TrustStore& trust, WallTime now);

  /// Makes the same peer with another certificate and other permissions. Errors: those of the
  /// certificate as above, guid_not_bound_to_subject (another subject).
  Result<JudgedPeer> renewed(BytesView certificate, BytesView permissions, const Guid& guid,
                             const TrustStore& trust, WallTime now) const;

  /// Judges the OCSP response that came with the credentials. Errors: those of check_ocsp_status.
  Status check_ocsp(const std::optional<BytesView>& response, const TrustStore& trust,
                    OcspPolicy policy, WallTime now);
  /// Returns the reason why the peer's response counts as none, if it sent one that cannot be used.
  const std::optional<Error>& ocsp_unused() const { return ocsp_unused_; }

  const pki::ValidChain& chain() const { return chain_; }
  const pki::Certificate& certificate() const { return chain_.certificate(); }

  /// Returns the AuthenticatedPeerCredentialToken: binary c.id and c.perm (DDS-Security 1.2,
  /// clause 10.3.2.3). c.perm comes without the NUL that Cyclone DDS appends, and is empty if the
  /// peer has no permissions. The token also has c.kagree_algo, for access control, which knows
  /// what the governance allows. It is empty after drop_credential.
  const std::optional<spi::Token>& credential() const { return credential_; }
  /// Frees the credential when it is no longer needed, because the peer chose its size.
  void drop_credential() { credential_.reset(); }

  /// Returns the ciphers that the peer's participant data announces. They are proven once a
  /// signature has been verified. That also applies to the next four functions.
  spi::CipherMask ciphers() const { return ciphers_; }
  std::uint32_t builtin_endpoints() const { return builtin_endpoints_; }
  /// True if the peer's product judges documents only during the handshake: Fast DDS (measured with
  /// 2.9.1).
  bool keeps_session() const { return keeps_session_; }
  /// True if the peer runs ddssec, which alone announces this cipher. It may then have a renewal
  /// list.
  bool reads_lists() const { return (ciphers_ & spi::kChaCha20Poly1305Bit) != 0; }
  /// Returns the addresses at which the peer receives discovery traffic.
  const std::vector<spi::UdpAddress>& addresses() const { return addresses_; }
  const SignedDomain& domain() const { return domain_; }

 private:
  JudgedPeer(pki::ValidChain chain, const Credentials& credentials);
  void set_credential(BytesView permissions);

  pki::ValidChain chain_;
  std::string_view key_agreement_;  ///< name of the key agreement
  std::optional<spi::Token> credential_;
  spi::CipherMask ciphers_;
  std::uint32_t builtin_endpoints_;
  bool keeps_session_;
  std::vector<spi::UdpAddress> addresses_;
  SignedDomain domain_;
  std::optional<Error> ocsp_unused_;
};

}  // namespace ddssec::authentication
