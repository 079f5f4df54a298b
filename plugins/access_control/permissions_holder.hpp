// The object behind a permissions handle: a subject, its document and the grant that counts now.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "base/hash.hpp"
#include "plugins/access_control/allowed_endpoints.hpp"
#include "plugins/access_control/documents.hpp"
#include "plugins/access_control/listed_permissions.hpp"
#include "plugins/access_control/local_participant.hpp"
#include "plugins/access_control/own_documents.hpp"
#include "plugins/spi/session_facts.hpp"

namespace ddssec::access_control {

/// The subject that is judged.
struct HolderSubject {
  pki::SubjectName name;
  std::string shown;  ///< RFC 2253
};

/// How permissions that a peer presents compare with those in force.
enum class PresentedRights : std::uint8_t {
  same,      ///< the same document
  no_fewer,  ///< another document that gives the same rights or more
  fewer,     ///< another document that may give fewer rights
};

/// The permissions of one subject as one local participant sees them. Thread-safe.
class PermissionsHolder {
 public:
  /// `remote` is the identity of a peer, and empty for a local participant. If `document` is null,
  /// it is a peer without usable permissions, which may use only unprotected topics.
  PermissionsHolder(std::shared_ptr<LocalParticipant> participant,
                    std::optional<spi::IdentityHandle> remote, HolderSubject subject,
                    std::string document_name, std::shared_ptr<PermissionsDocument> document)
      : participant_(std::move(participant)),
        remote_(remote),
        subject_(std::move(subject)),
        document_name_(std::move(document_name)),
        document_(std::move(document)),
        warning_(participant_->warn_before_end) {}

  const std::shared_ptr<LocalParticipant>& participant() const { return participant_; }
  const std::optional<spi::IdentityHandle>& remote() const { return remote_; }
  /// Returns the subject of a peer, for events; empty for a local participant.
  std::string peer_subject() const { return remote_ ? subject_.shown : std::string(); }
  bool has_document() const { return document() != nullptr; }

  /// For a local participant: sets the signed file as it is sent to peers, and the places of
  /// renewed documents. Call it before the holder is shared.
  void set_own(std::string text, std::unique_ptr<OwnDocuments> documents);
  std::string text() const;
  /// For a local participant: takes the documents that have replaced those in force. Returns
  /// events, as OwnDocuments::renew does.
  std::vector<Error> renew(DocumentCache& documents, const Clock& clock);
  /// For a local participant: returns the documents in force, and the refused ones.
  std::vector<DocumentState> documents() const;
  /// For a local participant: returns the permissions in force, including their end if that was
  /// reported.
  DocumentPart permissions_part() const;
  const std::string& subject() const { return subject_.shown; }
  /// For a local participant: makes the next renew() read the files, whatever the poll interval is.
  void force_poll();
  void force_poll_of_list();  ///< the same for the renewal list only
  /// Puts renewed permissions, with their file, into force. They must have a grant for the subject
  /// that is valid now and does not begin earlier than the one in force. The document must not have
  /// been signed earlier, because an older document that was put back would restore rights that
  /// were removed. A document without a signing time may only follow another one without it. The
  /// permissions may give less, and end earlier. Error: permissions_renewal_refused, also after the
  /// end was reported; those of grant_for.
  Status adopt(std::shared_ptr<PermissionsDocument> document, BytesView file, WallTime now);
  /// For a peer: does the same with permissions that it has shown within its session, and compares
  /// them with those in force.
  Result<PresentedRights> adopt_presented(std::shared_ptr<PermissionsDocument> document,
                                          WallTime now);
  /// For a peer: lets permissions of the participant's renewal list extend those that the peer
  /// presented. They do if they give the same or more and end later, or if the CA of the presented
  /// ones was removed from its file (ListedPermissions::extension_of). They count until their own
  /// end, whatever the list contains then. The peer does not get additional rights from them.
  /// Returns the event peer_permissions_listed if they begin to do so.
  std::optional<Error> follow_list(WallTime now);
  /// For a peer: notes that the permissions that it presented do not allow this. Permissions that
  /// do allow it will not extend them, so that the session ends and the peer presents the others.
  void note_denied(governance::Action action, const spi::EndpointRequest& asked);
  /// Returns the number of times that renewed permissions were taken.
  std::uint64_t renewals() const;

  /// For a peer: notes that it has seen the document of `own` with the digest in `facts`. Without a
  /// digest it is the first document, which another vendor's authentication continues to present.
  void note_seen(std::shared_ptr<const PermissionsHolder> own, const spi::SessionFacts& facts);
  /// For a peer that runs ddssec: returns the grant of our permissions that it has seen, if these
  /// were renewed since. No grant otherwise.
  struct OutdatedGrant {
    SharedGrant grant = {};
    bool must_end = false;  ///< see note_must_end
  };
  OutdatedGrant outdated_grant_seen() const;
  /// For a peer: notes that its session is to end because of that grant. Its handle is returned
  /// then, except after an error in the host.
  void note_must_end();
  /// For a peer: returns the endpoints that it announced.
  AllowedEndpoints& announced() { return announced_; }
  const std::string& document_name() const { return document_name_; }

  /// Returns the grant that is valid at `now`. The wall clock is compared at every call, so that
  /// neither a host that forgets to call expire nor a clock that jumps lets a peer in. A grant that
  /// was valid does not end because the clock goes back to a time before it began. When a grant
  /// ends, another one of the same document replaces it. For a peer, it must give the same:
  /// otherwise the peer ends, and its rights are judged when it comes again. Errors: those of
  /// PermissionsDocument::grant_for, peer_has_no_permissions, permissions_ca_withdrawn.
  Result<SharedGrant> grant(WallTime now);

  /// Returns the time when the last grant that was found ends, if that was not reported.
  std::optional<WallTime> ends() const;
  /// Returns the reason why nothing is valid now, if that was not reported. For a peer this may
  /// also be session_outlived_documents: our documents that it has seen have ended and were renewed
  /// since, so it ends the session, too. A clock that goes back to a time before the beginning ends
  /// nothing.
  std::optional<Error> newly_ended(WallTime now);
  /// Returns the warning permissions_end_soon, once for each time that the participant's properties
  /// request. Empty if another grant of the document replaces this one.
  std::optional<Error> ends_soon(WallTime now);
  /// Notes that nothing more is to be reported. Needs no memory.
  void mark_reported();

 private:
  const std::shared_ptr<LocalParticipant> participant_;
  const std::optional<spi::IdentityHandle> remote_;
  const HolderSubject subject_;
  const std::string document_name_;
  AllowedEndpoints announced_;
  AllowedEndpoints denied_;  ///< for a peer: announcements that its permissions did not allow

  Status check_signer(const PermissionsDocument& document) const;
  Status check_extension(WallTime now) const;
  Result<SharedGrant> presented_grant(WallTime now);
  Result<SharedGrant> valid_grant(WallTime now);
  std::optional<WallTime> last_end() const;
  std::shared_ptr<PermissionsDocument> document() const;
  GrantOfDocument presented(const std::optional<Sha256Digest>& digest) const;
  Result<SharedGrant> grant_in(PermissionsDocument& document, WallTime now) const;
  Status check_follows(const PermissionsDocument& document, const SharedGrant& renewed) const;
  std::optional<Error> outlived(WallTime now);
  bool are_wanted(const SharedGrant& others) const;
  std::optional<GrantOfDocument> extension_of(const GrantOfDocument& presented, ExtendingRights by,
                                              WallTime now) const;

  mutable std::mutex renewal_mutex_;  ///< before mutex_: no check waits while a file is read
  std::unique_ptr<OwnDocuments> own_documents_;
  mutable std::mutex mutex_;
  /// For a peer: our own permissions that it judges.
  std::shared_ptr<const PermissionsHolder> own_;
  std::optional<GrantOfDocument> seen_;            ///< the document of these that it has seen
  std::optional<GrantOfDocument> seen_extension_;  ///< the extension by which it continues
  bool reads_lists_ = false;                       ///< see SessionFacts
  bool must_end_ = false;                          ///< see note_must_end
  std::shared_ptr<PermissionsDocument> document_;
  std::optional<GrantOfDocument> extension_;  ///< for a peer: the extension by the renewal list
  std::string text_;
  Sha256Digest digest_ = {};  ///< digest of text_ (session_facts.hpp)
  struct FormerDocument {
    Sha256Digest digest;
    GrantOfDocument permissions;
  };
  /// The permissions that were renewed: the first, and the last few, which handshakes under way
  /// still present.
  std::vector<FormerDocument> former_;
  std::uint64_t renewals_ = 0;
  /// For a peer: the CA that accepted what it presented.
  std::shared_ptr<const PermissionsCa> accepted_by_;
  SharedGrant grant_;
  bool is_reported_ = false;
  spi::EndWarning warning_;
};

}  // namespace ddssec::access_control
