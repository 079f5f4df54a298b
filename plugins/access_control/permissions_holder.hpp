// What a permissions handle stands for: a subject, its document and the grant that counts now.
#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "base/hash.hpp"
#include "plugins/access_control/announced.hpp"
#include "plugins/access_control/documents.hpp"
#include "plugins/access_control/listed_permissions.hpp"
#include "plugins/access_control/local_participant.hpp"
#include "plugins/access_control/own_documents.hpp"
#include "plugins/spi/session_facts.hpp"

namespace ddssec::access_control {

/// Who is judged.
struct Subject {
  pki::SubjectName name;
  std::string shown;  ///< RFC 2253
};

/// The permissions of one subject as one local participant sees them. Thread-safe.
class PermissionsHolder {
 public:
  /// `remote`: the peer's identity, if it is one. `document` null: a peer without usable
  /// permissions, to which only unprotected topics are open.
  PermissionsHolder(std::shared_ptr<LocalParticipant> participant,
                    std::optional<spi::IdentityHandle> remote, Subject subject,
                    std::string document_name, std::shared_ptr<PermissionsDocument> document)
      : participant_(std::move(participant)),
        remote_(remote),
        subject_(std::move(subject)),
        document_name_(std::move(document_name)),
        document_(std::move(document)),
        warning_(participant_->warn_before_end) {}

  const std::shared_ptr<LocalParticipant>& participant() const { return participant_; }
  const std::optional<spi::IdentityHandle>& remote() const { return remote_; }
  /// Subject of a peer, for events; empty for a local participant.
  std::string peer_subject() const { return remote_ ? subject_.shown : std::string(); }
  bool has_document() const { return document() != nullptr; }

  /// Of a local participant: the signed file as it goes to peers, and where renewed documents may
  /// come. Before the holder is shared.
  void set_own(std::string text, std::unique_ptr<OwnDocuments> documents);
  std::string text() const;
  /// Of a local participant: takes the documents that were put in place of those in force. Returns
  /// events, as OwnDocuments::renew does.
  std::vector<Error> renew(DocumentCache& documents, const Clock& clock);
  /// Of a local participant: what is in force, and what was refused.
  std::vector<DocumentState> documents() const;
  /// Of a local participant: the permissions in force, with the end also if it was reported.
  DocumentPart permissions_part() const;
  const std::string& subject() const { return subject_.shown; }
  /// Of a local participant: the next renew() reads the files, whatever the poll interval is.
  void force_poll();
  void force_poll_of_list();  ///< the same for the renewal list alone
  /// Renewed permissions, with the file, come into force if they have a grant for the subject that
  /// is valid now and does not begin earlier than the one in force, and if the document was not
  /// signed earlier: an older document that was put back would give again what was taken away. One
  /// without a signing time follows only another without one. They may give less, and end earlier.
  /// Error: permissions_renewal_refused, also after the end was reported; those of grant_for.
  Status adopt(std::shared_ptr<PermissionsDocument> document, BytesView file, WallTime now);
  /// Of a peer: the same for permissions that it has shown within its session. True: they are
  /// others than those in force.
  Result<bool> adopt_presented(std::shared_ptr<PermissionsDocument> document, WallTime now);
  /// Of a peer: permissions of the participant's renewal list extend those that the peer presented,
  /// if they give the same or more and end later, or if the CA of the others has left its file
  /// (ListedPermissions::extension_of). They count until their own end, whatever the list has then.
  /// The peer gets no rights of theirs.
  /// The event: peer_permissions_listed.
  std::optional<Error> follow_list(WallTime now);
  /// Of a peer: the permissions that it presented do not allow this. Those that do will not extend
  /// them, so that the session ends, and the peer presents the others.
  void note_denied(governance::Action action, const spi::EndpointRequest& asked);
  /// How often it has taken permissions.
  std::uint64_t renewals() const;

  /// Of a peer: it has seen the document of `own` with the digest in `facts`. Without one: the
  /// first document, which another vendor's authentication goes on presenting.
  void note_seen(std::shared_ptr<const PermissionsHolder> own, const spi::SessionFacts& facts);
  /// Of a peer.
  AnnouncedEndpoints& announced() { return announced_; }
  const std::string& document_name() const { return document_name_; }

  /// The grant that is valid at `now`: by the wall clock at every call, so that neither a host that
  /// forgets to call expire nor a clock that jumps lets a peer in. One that was valid has not ended
  /// because the clock goes back to a time before it began. When a grant ends, another of
  /// the same document takes over; a peer's only if it gives the same: else the peer ends, and what
  /// it may have is judged when it comes again. Errors: those of PermissionsDocument::grant_for,
  /// peer_has_no_permissions, permissions_ca_withdrawn.
  Result<SharedGrant> grant(WallTime now);

  /// When the grant found last ends, if it was not reported as ended.
  std::optional<WallTime> ends() const;
  /// The error why nothing is valid now, if that was not reported. Of a peer also
  /// session_outlived_documents: what it has seen of us has ended and was renewed since, so it ends
  /// the session, too. A clock that goes back to a time before it began ends nothing.
  std::optional<Error> newly_ended(WallTime now);
  /// permissions_end_soon, once for each time that the participant's properties ask for. Nothing
  /// if another grant of the document takes over.
  std::optional<Error> ends_soon(WallTime now);
  /// There is nothing more to report. Needs no memory.
  void mark_reported();

 private:
  const std::shared_ptr<LocalParticipant> participant_;
  const std::optional<spi::IdentityHandle> remote_;
  const Subject subject_;
  const std::string document_name_;
  AnnouncedEndpoints announced_;
  AnnouncedEndpoints denied_;  ///< of a peer: what it announced in vain

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
  std::optional<GrantOfDocument> extension_of(const GrantOfDocument& presented,
                                              bool only_by_the_same, WallTime now) const;

  mutable std::mutex renewal_mutex_;  ///< before mutex_: no check waits while a file is read
  std::unique_ptr<OwnDocuments> own_documents_;
  mutable std::mutex mutex_;
  std::shared_ptr<const PermissionsHolder> own_;   ///< of a peer: what we are to it
  std::optional<GrantOfDocument> seen_;            ///< and what it has seen of that
  std::optional<GrantOfDocument> seen_extension_;  ///< by which it goes on
  bool reads_lists_ = false;                       ///< as SessionFacts has it
  std::shared_ptr<PermissionsDocument> document_;
  std::optional<GrantOfDocument> extension_;  ///< of a peer, by the renewal list
  std::string text_;
  Sha256Digest digest_ = {};  ///< of text_, as session_facts.hpp counts it
  struct Former {
    Sha256Digest digest;
    GrantOfDocument permissions;
  };
  /// Those renewed since: the first, and the last few, which handshakes under way still present.
  std::vector<Former> former_;
  std::uint64_t renewals_ = 0;
  std::shared_ptr<const PermissionsCa> accepted_by_;  ///< of a peer: what it presented
  SharedGrant grant_;
  bool is_reported_ = false;
  spi::EndWarning warning_;
};

}  // namespace ddssec::access_control
