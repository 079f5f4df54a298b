// A participant to be: key, certificate and permissions, made in one place for every command that
// issues.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "cli/ca_folder.hpp"
#include "cli/command.hpp"
#include "governance/model.hpp"
#include "pki/participant_folder.hpp"

namespace ddssec::cli {

/// What a participant is to get.
struct ParticipantSpec {
  std::string name;     ///< of its grant
  std::string subject;  ///< of its certificate
  pki::Validity life;
  pki::KeySpec key = {};
  std::vector<governance::DomainRange> domains = {{0, 0}};
  std::vector<std::string> publish = {};
  std::vector<std::string> subscribe = {};
  std::vector<std::string> partitions = {};  ///< none: only endpoints without partitions
  /// A permissions document to sign instead of one made from the lists.
  std::optional<Bytes> permissions = std::nullopt;
  bool takes_other_grants = false;  ///< of that document, for other subjects
  /// Or rules from elsewhere; subject and validity are the certificate's.
  std::optional<governance::Grant> grant = std::nullopt;
  std::filesystem::path dropin = {};  ///< drop_in_of

  bool has_permissions() const {
    return permissions || grant || !publish.empty() || !subscribe.empty();
  }
};

/// What was made.
struct NewParticipant {
  pki::Credential self;
  std::string permissions_xml;        ///< empty if it gets none
  Bytes permissions;                  ///< the same, signed
  std::filesystem::path dropin = {};  ///< for its configuration files
};

/// Who makes it.
struct Issuers {
  const OpenCa& identity;
  const OpenCa* permissions = nullptr;  ///< null: permissions cannot be signed
  std::string_view crl = {};            ///< list_for_newcomers
};

/// `wanted`, beginning not before the CA. An end after the CA's is cut if `clamp`, else refused:
/// the certificate would stop being believed before it says so. Error: outlives_ca.
Result<pki::Validity> within_ca(pki::Validity wanted, const pki::Certificate& ca, bool clamp);

/// Adds what lint says of the topics and partitions that the spec names: those that match nothing,
/// that products read differently, or that look like names of ROS. Each sentence once, and none is
/// an error: the document is written as the spec asks.
void warn_of_topics(const ParticipantSpec& spec, const std::string& document, Report& report);

/// The permissions document of the spec, for this certificate: the one it brings, which must have a
/// grant for the subject that is valid at `now` and, unless the spec takes them, none for others;
/// or one grant with default DENY. The subject is the certificate's own text, the form that every
/// vendor reads. Errors: foreign_grant, those of read_permissions and find_grant.
Result<std::string> permissions_xml(const ParticipantSpec& spec,
                                    const pki::Certificate& certificate, WallTime now);

/// Key, certificate and signed permissions. Errors: those of Authority::issue and sign_document,
/// and of permissions_xml.
Result<NewParticipant> make_participant(const ParticipantSpec& spec, const Issuers& issuers,
                                        const Context& context);

/// The document, signed. Errors: those of sign_document; smime_too_large: ddssec's plugins
/// would refuse it (PERM042).
Result<Bytes> sign_permissions(const pki::Authority& ca, std::string_view xml, WallTime now,
                               Random& random);

/// Puts it into a folder to be, in the flat layout, with the products' configuration files.
/// `governance` may be empty: then there is none.
Status add_flat(NewFolder& folder, const std::filesystem::path& below,
                const NewParticipant& participant, const Issuers& issuers, BytesView governance);

/// The line of the identity CA's log about it; it must be written before the certificate
/// is handed out.
std::string log_line(const NewParticipant& participant, const std::filesystem::path& folder,
                     WallTime now);

/// The line of the permissions CA's log about its permissions; empty if it has none.
std::string signed_line(const NewParticipant& participant, const OpenCa& permissions,
                        const std::filesystem::path& folder, WallTime now);

/// What results say of a certificate that was issued: subject, serial, not_after, sha256.
Json certificate_json(const pki::Certificate& certificate);

}  // namespace ddssec::cli
