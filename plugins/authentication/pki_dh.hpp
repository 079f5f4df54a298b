// The authentication plugin. Its parts: identities (authentication.cpp), handshakes
// (pki_dh_handshakes.cpp), and the questions about finished handshakes (pki_dh_sessions.cpp).
#pragma once

#include <algorithm>
#include <mutex>
#include <vector>

#include "base/plugin_services.hpp"
#include "plugins/authentication/authentication.hpp"
#include "plugins/authentication/identity_table.hpp"
#include "plugins/authentication/kept_requests.hpp"
#include "plugins/spi/session_facts.hpp"

namespace ddssec::authentication {

using spi::HandshakeHandle;
using spi::IdentityHandle;
using spi::Token;
using spi::ValidationResult;

/// True if the local participant begins the handshake, because its GUID is the lower one, compared
/// octet by octet (DDS-Security 1.2, clause 10.3.3).
inline bool initiates(const Guid& local, const Guid& remote) { return local < remote; }

struct Revocations;  // revocations.hpp

/// The builtin plugin DDS:Auth:PKI-DH (DDS-Security 1.2, clause 10.3). Thread-safe.
class PkiDh final : public spi::Authentication {
 public:
  PkiDh(const PluginServices& services, const AuthenticationOptions& options)
      : services_(services),
        stores_(options.crl_policy),
        table_(options.max_local_identities,
               {.max_claimed = options.max_remote_identities,
                .max_authenticated = options.max_remote_identities,
                .max_of_a_subject = options.max_identities_of_a_subject}) {}

  Result<LocalIdentity> validate_local_identity(DomainId domain_id,
                                                const spi::PropertyList& properties,
                                                const Guid& candidate_guid) override;
  Result<Token> identity_token(IdentityHandle local, spi::CipherMask ciphers) override;
  Result<Token> identity_status_token(IdentityHandle local) override;
  Status set_permissions_credential_and_token(IdentityHandle local, const Token& credential,
                                              const Token& permissions_token) override;
  Result<RemoteIdentity> validate_remote_identity(IdentityHandle local,
                                                  const std::optional<Token>& remote_auth_request,
                                                  const Token& remote_identity_token,
                                                  const Guid& remote_guid) override;
  Result<HandshakeStep> begin_handshake_request(IdentityHandle initiator, IdentityHandle replier,
                                                BytesView participant_data) override;
  Result<HandshakeStep> begin_handshake_reply(const Token& request, IdentityHandle initiator,
                                              IdentityHandle replier,
                                              BytesView participant_data) override;
  Result<HandshakeStep> process_handshake(HandshakeHandle handshake, const Token& message) override;
  Outline outline(const Token& message) const override;
  Result<std::shared_ptr<const spi::SharedSecret>> shared_secret(
      HandshakeHandle handshake) override;
  Result<Token> authenticated_peer_credential_token(HandshakeHandle handshake) override;
  std::string authenticated_subject(HandshakeHandle handshake) override;
  Result<std::optional<spi::OfferedRenewal>> offer_renewal(HandshakeHandle handshake) override;
  Result<Token> judge_renewal(HandshakeHandle handshake, const Token& offer) override;
  Result<Token> accept_renewal(HandshakeHandle handshake, const Token& offer) override;
  Result<spi::SessionFacts> note_renewal_accepted(HandshakeHandle handshake,
                                                  const Token& answer) override;
  Status return_handshake_handle(HandshakeHandle handshake) override;
  Status return_identity_handle(IdentityHandle identity) override;
  std::optional<WallTime> next_expiry() override { return table_.next_end(); }
  std::vector<IdentityHandle> poll(IdentityHandle local) override;

 private:
  Revocations poll_files(IdentityHandle local);
  void note_documents_in_use(IdentityHandle local) noexcept;
  void note_end(IdentityHandle identity, const Error& why, WallTime now);

  template <class T>
  Result<T> reported(Result<T> result, const PeerName& peer = {}) const {
    if (!result) services_.events.raise(event_about(peer, result.error()));
    return result;
  }
  /// Reports an error about a handshake message. The event says that the name of the peer is only
  /// claimed, because an attacker can send a message in the name of a peer that has authenticated.
  template <class T>
  Result<T> reported(Result<T> result, IdentityHandle remote) const {
    if (result) return result;
    auto name = table_.name_of(remote);
    name.proof = PeerProof::claimed;
    return reported(std::move(result), name);
  }

  void drop_credentials_given_out();
  bool has_outlived(const std::vector<IdentityTable::EndedIdentity>& all,
                    const IdentityTable::EndedIdentity& session) const;
  bool may_continue(const IdentityPair& pair, const PairHandshake& handshake,
                    const std::shared_ptr<const PresentedDocuments>& own) const;
  Result<LocalIdentity> load_local(const spi::PropertyList& properties, const Guid& candidate);
  Result<RemoteIdentity> admit(IdentityHandle local, const std::optional<Token>& auth_request,
                               const Token& identity_token, const Guid& guid);
  Result<HandshakeStep> begin_request(IdentityHandle local, IdentityHandle remote,
                                      BytesView participant_data);
  Result<HandshakeStep> begin_reply(const Token& request, IdentityHandle local,
                                    IdentityHandle remote, BytesView participant_data);
  Result<HandshakeStep> answer_request(const std::shared_ptr<IdentityPair>& pair,
                                       const Token& request, BytesView participant_data);
  void drop_excess(HandshakeHandle newest);
  Result<HandshakeStep> process_step(HandshakeHandle handle, const Token& message);
  Result<HandshakeContext> handshake_context(const IdentityPair& pair) const;
  Status note_authenticated(const IdentityPair& pair, const EstablishedSession& done);
  void note_unused_ocsp(const IdentityPair& pair, const EstablishedSession& done) const;
  Result<JudgedOffer> judge_peer_offer(const IdentityPair& pair, const EstablishedSession& session,
                                       const Token& offer) const;
  Event renewed_peer(const IdentityPair& pair, const EstablishedSession& session) const;
  void restore_kept_request(const std::shared_ptr<IdentityPair>& pair);
  Token presented_token(const Token& message, const IdentityPair& pair,
                        const PresentedDocuments& own) const;
  Status check_room(const IdentityPair& pair) const;
  void make_room(IdentityPair& pair);
  HandshakeStep keep(const std::shared_ptr<IdentityPair>& pair, HandshakeOutcome outcome,
                     BytesView participant_data, UnprovenOctets::Share unproven = {});
  UnprovenOctets::Share share_of(const IdentityPair& pair, const Token& request,
                                 const HandshakeOutcome& outcome);
  /// Calls `f(const IdentityPair&, PairHandshake&, EstablishedSession&)` under the pair's lock.
  template <class F>
  auto with_session(HandshakeHandle handle, F&& f) const
      -> std::invoke_result_t<F, const IdentityPair&, PairHandshake&, EstablishedSession&>;
  /// Calls `f(const EstablishedSession&)` in the same way, if `f` only reads.
  template <class F>
  auto with_established(HandshakeHandle handle, F&& f) const
      -> Result<std::invoke_result_t<F, const EstablishedSession&>>;

  const PluginServices services_;
  TrustStores stores_;
  UnprovenOctets unproven_;
  IdentityTable table_;
  KeptRequests kept_requests_{services_.random};
  std::mutex noting_mutex_;  ///< prevents an identity that has left from being noted again
  std::mutex given_out_mutex_;
  /// Handles whose credentials were given out since the last `poll`.
  std::vector<HandshakeHandle> given_out_;
};

template <class F>
auto PkiDh::with_session(HandshakeHandle handle, F&& f) const
    -> std::invoke_result_t<F, const IdentityPair&, PairHandshake&, EstablishedSession&> {
  DDSSEC_ASSIGN_OR_RETURN(const auto pair, table_.pair_of(handle));
  const std::scoped_lock lock(pair->mutex);
  const auto handshake = std::ranges::find(pair->handshakes, handle, &PairHandshake::handle);
  if (handshake == pair->handshakes.end()) return fail(Code::unknown_handshake);
  auto* const done = std::get_if<EstablishedSession>(&handshake->state);
  if (done == nullptr) return fail(Code::handshake_not_finished);
  return f(*pair, *handshake, *done);
}

template <class F>
auto PkiDh::with_established(HandshakeHandle handle, F&& f) const
    -> Result<std::invoke_result_t<F, const EstablishedSession&>> {
  using Answer = Result<std::invoke_result_t<F, const EstablishedSession&>>;
  return with_session(
      handle, [&](const IdentityPair&, PairHandshake&, const EstablishedSession& done) -> Answer {
        return f(done);
      });
}

}  // namespace ddssec::authentication
