// The documents of a local participant, which may be replaced while the participant runs.
#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/document_watch.hpp"
#include "base/documents_in_use.hpp"
#include "pki/authority_watch.hpp"
#include "pki/renewal_list_watch.hpp"
#include "plugins/access_control/access_control.hpp"
#include "plugins/access_control/listed_permissions.hpp"
#include "plugins/access_control/local_participant.hpp"

namespace ddssec::access_control {

class PermissionsHolder;

/// The places of the documents.
struct DocumentPlaces {
  std::string permissions_ca, governance, permissions, identity_ca;  ///< URIs
  std::vector<std::string> renewal_list;                             ///< URIs, too
  std::string permissions_ca_name, governance_name, permissions_name;
};

/// The documents and the watches of their files. Not thread-safe.
class OwnDocuments {
 public:
  /// Create it before the files are read for the first time.
  OwnDocuments(const DocumentPlaces& places, const AccessControlOptions& options,
               std::chrono::seconds interval);

  /// Makes the next renew() read the files, whatever the interval is.
  void force_poll();

  /// The largest number of permissions of the renewal list that one renew() verifies, so that a
  /// long list does not stop the host. Those that were verified before are not verified again.
  static constexpr std::size_t kMaxVerifiedInAPoll = 16;
  /// Makes the next renew() read the renewal list, and verify all of it: a peer ends otherwise.
  void force_poll_of_list() {
    renewal_list_.force_poll();
    verifies_all_ = true;
  }

  /// Notes that these octets are in force.
  void note_read(Bytes governance, BytesView permissions);

  /// Returns the CAs, permissions and governance in force, the permissions on the renewal list, and
  /// the refused ones. `permissions` is the part that is in force.
  std::vector<DocumentState> states(const LocalParticipant& participant,
                                    DocumentPart permissions) const;

  /// Takes the documents in the files, if these have changed:
  /// - Other permissions CAs, if the governance and the permissions of the participant are signed
  ///   by one of them: those in force, or else those in the files now, which then come into force.
  /// - A governance document that only adds topic rules, none of them for a topic in use. A
  ///   document that protects topics in use more waits as the participant's pending document, if
  ///   the host changes endpoints that exist. Until it is applied, no other one is read.
  /// - Renewed permissions that PermissionsHolder::adopt accepts; none if the host does not present
  ///   them.
  /// - Further identity CAs, if the governance restricts algorithms. Authentication decides which
  ///   of them are trusted, and reports a file that cannot be used.
  /// - Permissions of peers in the renewal list, for LocalParticipant::listed. Authentication
  ///   reports a list that cannot be read.
  /// Returns events about documents that were taken, and about those that cannot be used (once as
  /// long as the file stays the same). A document that cannot be used changes nothing.
  std::vector<Error> renew(PermissionsHolder& holder, LocalParticipant& participant,
                           DocumentCache& documents, const Clock& clock);

 private:
  struct Renewal;  // the data for one call of renew()

  void renew_authorities(const Renewal& now, std::vector<Error>& events);
  void renew_governance(const Renewal& now, std::vector<Error>& events);
  void renew_permissions(const Renewal& now, std::vector<Error>& events);
  void renew_identity_authorities(const Renewal& now);
  void renew_list(const Renewal& now, std::vector<Error>& events);
  /// A signed file of the renewal list and its content.
  struct ListedFile {
    Sha256Digest file;
    std::shared_ptr<PermissionsDocument> document;
  };
  /// Keeps only one event about an unreadable folder, and none if authentication reports it.
  void keep_one_of_folder(std::vector<Error>& events) const;
  std::optional<ListedFile> known(const Renewal& now, BytesView file) const;
  /// The permissions of a renewal list.
  struct ListedFiles {
    std::vector<ListedFile> verified = {};
    std::vector<Bytes> waiting = {};      ///< files that were not verified yet
    std::vector<ListedFile> former = {};  ///< those of the former list, as long as some files wait
    std::optional<Error> fault = {};      ///< of the first file that does not count
    /// False if there are permissions and none of them counts.
    bool counts() const { return !waiting.empty() || !verified.empty() || !fault; }
  };
  void verify_some(const Renewal& now, ListedFiles& list) const;
  Status adopt_list(const Renewal& now, const pki::RenewalList& list);
  void use_list(const Renewal& now);
  std::optional<DocumentState> state_of_list() const;
  std::optional<Error> continue_list(const Renewal& now);
  Status adopt_authorities(const Renewal& now, const std::vector<pki::Certificate>& next);
  /// A governance document that may replace the one in force.
  struct JudgedGovernance {
    JudgingDocuments documents;
    bool is_phased = false;
  };
  Result<JudgedGovernance> judge_governance(const Renewal& now, const JudgingDocuments& documents,
                                            BytesView file) const;
  std::optional<Error> drop_withdrawn(const Renewal& now);
  /// Notes that the document that waited was applied, and returns the event about it. Empty if it
  /// still waits, or if none does.
  std::optional<Error> note_applied(const LocalParticipant& participant);
  /// Takes the document in the file, into force or as pending.
  Status adopt_governance(const Renewal& now, const JudgingDocuments& former, BytesView file);

  const AccessControlOptions options_;
  const bool keeps_permissions_;
  pki::AuthorityWatch authorities_;
  DocumentWatch governance_;
  DocumentWatch permissions_;
  DocumentWatch identity_authorities_;
  pki::RenewalListWatch renewal_list_;
  ListedFiles listed_;
  std::vector<DocumentPart> listed_parts_;  ///< one for each document that counts
  bool had_listed_ = false;                 ///< the list has had permissions that count
  bool is_list_refused_ = false;            ///< none of the permissions of the file counts
  std::optional<Error> list_refused_when_verified_;
  bool verifies_all_ = false;
  Bytes governance_in_force_;
  std::optional<Bytes> governance_waiting_;
};

}  // namespace ddssec::access_control
