// Creates a participant: key, certificate and permissions, in one place for every command that
// issues.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "cli/ca/ca_folder.hpp"
#include "cli/frame/command.hpp"
#include "cli/frame/new_folder.hpp"
#include "governance/model.hpp"
#include "pki/participant_folder.hpp"

namespace ddssec::cli {

/// The specification of a new participant.
struct ParticipantSpec {
  std::string name;     ///< the name of its grant
  std::string subject;  ///< the subject of its certificate
  pki::Validity life;
  pki::KeySpec key = {};
  std::vector<governance::DomainRange> domains = {{0, 0}};
  std::vector<std::string> publish = {};
  std::vector<std::string> subscribe = {};
  std::vector<std::string> partitions = {};  ///< empty: only endpoints without partitions
  /// A permissions document to sign instead of one made from the lists.
  std::optional<Bytes> permissions = std::nullopt;
  bool takes_other_grants = false;  ///< accept grants of that document for other subjects
  /// A grant with rules from another source, used instead of the lists. Its subject and validity
  /// are replaced by those of the certificate.
  std::optional<governance::Grant> grant = std::nullopt;
  std::filesystem::path dropin = {};  ///< as drop_in_of returns it
  std::string ocsp_responder = {};    ///< URL for the certificate; empty: none

  bool has_permissions() const {
    return permissions || grant || !publish.empty() || !subscribe.empty();
  }
};

/// The new participant.
struct NewParticipant {
  pki::Credential self;
  std::string permissions_xml;        ///< empty if the participant has no permissions
  Bytes permissions;                  ///< `permissions_xml`, signed
  std::filesystem::path dropin = {};  ///< for the participant's configuration files
};

/// The CAs that issue and sign.
struct Issuers {
  const OpenCa& identity;
  const OpenCa* permissions = nullptr;  ///< nullptr: permissions cannot be signed
  std::string_view crl = {};            ///< from list_for_newcomers
  /// The permissions CA's certificates in PEM, also if it signs nothing now; empty: none is known.
  std::string_view permissions_trust = {};
};

/// Returns the validity `wanted`, which does not begin before the CA's. An end after the CA's is
/// cut if `clamp` is true, otherwise refused: the certificate would become invalid before its own
/// end. An end before the CA's beginning is refused. Errors: outlives_ca, ends_before_ca.
Result<pki::Validity> within_ca(pki::Validity wanted, const pki::Certificate& ca, bool clamp);

/// Adds lint's findings about topics and partitions of the spec that match nothing, that products
/// read differently, or that look like names of ROS. For a document in the spec, also adds
/// everything else that some product reads differently or refuses. Each finding is added once, and
/// none as an error, because the document is written as specified.
void warn_of_rights(const ParticipantSpec& spec, const std::string& document, Report& report);

/// Returns the permissions document of the spec for this certificate. It is the document in the
/// spec, if there is one: it must have a grant for the subject that is valid at `now`, and no
/// grants for others unless the spec accepts them. Otherwise it is a document with one grant and
/// default DENY. Its subject is the certificate's own text, which every product accepts. Errors:
/// foreign_grant, those of read_permissions and find_grant.
Result<std::string> permissions_xml(const ParticipantSpec& spec,
                                    const pki::Certificate& certificate, WallTime now);

/// Makes key, certificate and signed permissions. Errors: those of Authority::issue and
/// sign_document, and of permissions_xml.
Result<NewParticipant> make_participant(const ParticipantSpec& spec, const Issuers& issuers,
                                        const Context& context);

/// Returns the signed document. Errors: those of sign_document; smime_too_large, because ddssec's
/// plugins would refuse it (PERM042).
Result<Bytes> sign_permissions(const pki::Authority& ca, std::string_view xml, WallTime now,
                               Random& random);

/// Adds the participant to a new folder, in the flat layout, with the products' configuration
/// files. If `governance` is empty, no governance document is added.
Status add_flat(NewFolder& folder, const std::filesystem::path& below,
                const NewParticipant& participant, const Issuers& issuers, BytesView governance);

/// Returns the line of the identity CA's log about the participant. It must be written before the
/// certificate is handed out.
std::string log_line(const NewParticipant& participant, const std::filesystem::path& folder,
                     WallTime now);

/// Returns the line of the permissions CA's log about the participant's permissions; empty if it
/// has none.
std::string signed_line(const NewParticipant& participant, const OpenCa& permissions,
                        const std::filesystem::path& folder, WallTime now);

}  // namespace ddssec::cli
