#include "plugins/authentication/pki_dh.hpp"

namespace ddssec::authentication {
namespace {

spi::SessionFacts facts_of(const EstablishedSession& session) {
  return {.presented_permissions = sha256(session.own->permissions),
          .peer_keeps_session = session.peer.keeps_session(),
          .peer_reads_lists = session.peer.reads_lists()};
}

}  // namespace

Result<std::shared_ptr<const spi::SharedSecret>> PkiDh::shared_secret(HandshakeHandle handshake) {
  return reported(
      with_established(handshake, [](const EstablishedSession& done) { return done.secret; }));
}

Result<Token> PkiDh::authenticated_peer_credential_token(HandshakeHandle handshake) {
  const auto with_facts = [](const EstablishedSession& done) {
    auto credential = done.peer.credential();
    if (credential) spi::add_session_facts(*credential, facts_of(done));
    return credential;
  };
  DDSSEC_ASSIGN_OR_RETURN(auto credential, reported(with_established(handshake, with_facts)));
  if (!credential) return reported(Result<Token>(fail(Code::credential_given_out)));
  const std::scoped_lock lock(given_out_mutex_);
  if (std::ranges::find(given_out_, handshake) == given_out_.end()) given_out_.push_back(handshake);
  return *std::move(credential);
}

std::string PkiDh::authenticated_subject(HandshakeHandle handshake) {
  return with_established(handshake,
                          [](const EstablishedSession& done) {
                            return done.peer.chain().certificate().subject();
                          })
      .value_or(std::string());
}

// The credentials are not dropped at once, because a host without memory for them asks again.
void PkiDh::drop_credentials_given_out() {
  std::vector<HandshakeHandle> handles;
  {
    const std::scoped_lock lock(given_out_mutex_);
    handles.swap(given_out_);
  }
  for (const auto handle : handles) {
    const auto pair = table_.pair_of(handle);
    if (!pair) continue;
    const std::scoped_lock lock((*pair)->mutex);
    const auto handshake = std::ranges::find((*pair)->handshakes, handle, &PairHandshake::handle);
    if (handshake == (*pair)->handshakes.end()) continue;
    if (auto* const done = std::get_if<EstablishedSession>(&handshake->state))
      done->peer.drop_credential();
  }
}

// ---- renewed documents within a session

Result<std::optional<spi::OfferedRenewal>> PkiDh::offer_renewal(HandshakeHandle handle) {
  using Offered = Result<std::optional<spi::OfferedRenewal>>;
  return with_session(
      handle,
      [&](const IdentityPair& pair, PairHandshake& handshake, EstablishedSession& done) -> Offered {
        return next_offer(done, *pair.local, handshake.offer, services_.clock);
      });
}

Result<JudgedOffer> PkiDh::judge_peer_offer(const IdentityPair& pair,
                                            const EstablishedSession& session,
                                            const Token& offer) const {
  const auto trust = pair.local->peer_trust();
  auto judged =
      judge_offer(session, offer, pair.remote_guid,
                  {*trust, pair.local->ocsp_policy(), services_.clock.calendar_seconds()});
  if (judged) return judged;
  return reported(Result<JudgedOffer>(std::unexpected(judged.error().with_default_document(
                      "renewed documents of " + session.peer.certificate().subject()))),
                  table_.name_of(pair.remote_handle));
}

Result<Token> PkiDh::judge_renewal(HandshakeHandle handle, const Token& offer) {
  return with_session(
      handle,
      [&](const IdentityPair& pair, PairHandshake&, EstablishedSession& done) -> Result<Token> {
        DDSSEC_ASSIGN_OR_RETURN(const auto found, judge_peer_offer(pair, done, offer));
        return *found.peer.credential();
      });
}

Result<Token> PkiDh::accept_renewal(HandshakeHandle handle, const Token& offer) {
  return with_session(
      handle,
      [&](const IdentityPair& pair, PairHandshake&, EstablishedSession& done) -> Result<Token> {
        DDSSEC_ASSIGN_OR_RETURN(auto found, judge_peer_offer(pair, done, offer));
        const bool is_new = found.peer.certificate() != done.peer.certificate();
        auto former = std::exchange(done.peer, std::move(found.peer));
        done.peer.drop_credential();
        if (auto noted = note_authenticated(pair, done); !noted) {
          done.peer = std::move(former);
          return std::unexpected(noted.error());
        }
        if (is_new) services_.events.raise(renewed_peer(pair, done));
        return found.answer;
      });
}

Event PkiDh::renewed_peer(const IdentityPair& pair, const EstablishedSession& session) const {
  const auto& chain = session.peer.chain();
  return event_about(table_.name_of(pair.remote_handle),
                     Error(Code::peer_identity_renewed,
                           {.document = "certificate of " + chain.certificate().subject(),
                            .field = "notAfter",
                            .found = to_string(chain.not_after()),
                            .note = "serial number " + chain.certificate().serial()}));
}

Result<spi::SessionFacts> PkiDh::note_renewal_accepted(HandshakeHandle handle,
                                                       const Token& answer) {
  using Facts = Result<spi::SessionFacts>;
  return reported(with_session(
      handle,
      [&](const IdentityPair& pair, PairHandshake& handshake, EstablishedSession& done) -> Facts {
        if (const auto fits = check_answer(handshake.offer, answer); !fits)
          return std::unexpected(
              fits.error().with_default_document("answer of " + done.peer.certificate().subject()));
        const auto former = std::exchange(done.own, handshake.offer->documents);
        if (auto noted = note_authenticated(pair, done); !noted) {
          done.own = former;
          return std::unexpected(noted.error());
        }
        return facts_of(done);
      }));
}

}  // namespace ddssec::authentication
