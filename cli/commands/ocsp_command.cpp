// identity ocsp: fetches the OCSP response that a participant shows to its peers.
#include <filesystem>

#include <fmt/format.h>

#include "base/tool_code.hpp"
#include "cli/ca/ocsp_response.hpp"
#include "cli/commands/groups.hpp"
#include "cli/documents/documents.hpp"
#include "cli/folders/folder_kind.hpp"
#include "cli/frame/file_transaction.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

struct FetchedResponse {
  fs::path file;
  std::string subject, serial, url;
  WallTime this_update, until;

  static constexpr auto fields() {
    using Self = FetchedResponse;
    return std::tuple(field<&Self::file>(), field<&Self::subject>({.def = "subject"}),
                      field<&Self::serial>({.def = "serial"}),
                      field<&Self::url>({"of the responder"}), field<&Self::this_update>(),
                      field<&Self::until>());
  }
  std::string text() const {
    return fmt::format("{}  {} is good, says {}, until {}\n", file.string(), subject, url,
                       to_string(until));
  }
};

Result<Answer<FetchedResponse>> identity_ocsp(const Arguments& arguments, const Context& context) {
  const fs::path folder = arguments.text("DIR");
  DDSSEC_RETURN_IF_ERROR(check_participant_folder(folder));
  DDSSEC_ASSIGN_OR_RETURN(const auto seconds, arguments.number("--timeout", 1, 300));
  const auto files = pki::participant_folder(folder);
  DDSSEC_ASSIGN_OR_RETURN(const auto certificate, certificate_of(folder));
  DDSSEC_ASSIGN_OR_RETURN(
      const auto response,
      fetch_response({files, certificate, arguments.text("--url"), std::chrono::seconds(seconds)},
                     context.clock.calendar_seconds()));
  FileTransaction out;
  DDSSEC_RETURN_IF_ERROR(out.put(ocsp_file(files), response.octets, 0644));
  Answer<FetchedResponse> answer{{.file = ocsp_file(files),
                                  .subject = certificate.subject(),
                                  .serial = certificate.serial(),
                                  .url = response.url,
                                  .this_update = response.good.this_update(),
                                  .until = response.good.until()}};
  DDSSEC_ASSIGN_OR_RETURN(answer.report.files_written, out.commit());
  return answer;
}

}  // namespace

std::vector<Command> ocsp_commands() {
  return {{.group = "identity",
           .name = "ocsp",
           .summary = "Fetches the OCSP response that a participant shows to its peers.",
           .positionals = {{"DIR", "the participant's folder, which gets ocsp.der"}},
           .options = {{"--url", "URL",
                        "the responder (http://...), if not the one that the certificate names"},
                       {"--timeout", "SECONDS", "how long to wait for the answer", "10"}},
           .examples = {"ddssec identity ocsp talker --url http://ca.example:2560/"},
           .run = identity_ocsp}};
}

}  // namespace ddssec::cli
