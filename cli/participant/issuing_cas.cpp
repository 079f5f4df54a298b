#include "cli/participant/issuing_cas.hpp"

#include "cli/ca/ca_overlap.hpp"
#include "cli/ca/revocation_lists.hpp"
#include "cli/ca/signed_documents.hpp"
#include "cli/ca/subject_overlap.hpp"
#include "cli/documents/documents.hpp"
#include "cli/frame/interruption.hpp"
#include "cli/inputs/files.hpp"

namespace ddssec::cli {

Result<std::string> permissions_trust(const Arguments& arguments, bool signs_documents) {
  const std::filesystem::path given = arguments.text("--ca");
  const auto file = ca_paths(given, "permissions").certificate;
  const bool is_other = path_exists(file) && file != ca_paths(given, "identity").certificate;
  if (!is_other && !signs_documents) return std::string();
  DDSSEC_ASSIGN_OR_RETURN(const auto certificates, read_certificates(file));
  return to_pem(certificates);
}

Result<IssuingCas> open_issuing_cas(const Arguments& arguments, bool with_permissions,
                                    WallTime now) {
  CaOpener opener(arguments);
  DDSSEC_ASSIGN_OR_RETURN(auto identity, opener.open("identity"));
  IssuingCas out{std::move(identity), std::nullopt, std::nullopt, {}, {}};
  if (with_permissions) {
    DDSSEC_ASSIGN_OR_RETURN(out.permissions, opener.open("permissions"));
  }
  DDSSEC_ASSIGN_OR_RETURN(
      out.permissions_trust,
      permissions_trust(arguments, with_permissions || arguments.has("--governance")));
  DDSSEC_ASSIGN_OR_RETURN(out.list, list_for_newcomers(out.identity.paths, now));
  if (out.list) {
    DDSSEC_ASSIGN_OR_RETURN(out.crl, file_of_lists(out.identity.paths, *out.list));
  }
  return out;
}

Result<NewParticipant> make_participant_within_ca(ParticipantSpec& spec, const IssuingCas& cas,
                                                  const Arguments& arguments,
                                                  const Context& context,
                                                  const std::filesystem::path& from) {
  DDSSEC_ASSIGN_OR_RETURN(
      spec.life, within_ca(spec.life, cas.identity.certificate(), arguments.has("--clamp")));
  return with_default_document(make_participant(spec, cas.issuers(spec.has_permissions()), context),
                               from);
}

Status log_participants(const IssuingCas& cas, std::string_view issued,
                        std::string_view signed_lines) {
  DDSSEC_RETURN_IF_ERROR(check_not_interrupted());
  if (cas.permissions) DDSSEC_RETURN_IF_ERROR(log_signed(cas.permissions->paths, signed_lines));
  return log_issued(cas.identity.paths, issued);
}

Status log_participant(const IssuingCas& cas, const NewParticipant& made,
                       const std::filesystem::path& folder, WallTime now) {
  DDSSEC_ASSIGN_OR_RETURN(const auto log, read_issue_log(cas.identity.paths));
  DDSSEC_RETURN_IF_ERROR(SubjectsInUse(log, folder, now).check(made.self.certificate.subject()));
  return log_participants(cas, log_line(made, folder, now),
                          cas.permissions ? signed_line(made, *cas.permissions, folder, now) : "");
}

}  // namespace ddssec::cli
