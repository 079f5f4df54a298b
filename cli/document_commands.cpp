// governance, permissions: signing and verifying documents.
#include <filesystem>

#include <fmt/format.h>

#include "cli/documents.hpp"
#include "cli/groups.hpp"
#include "cli/inputs.hpp"
#include "cli/options.hpp"
#include "cli/transaction.hpp"
#include "governance/read.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

/// How a kind of document is read.
template <class T>
using Reader = Result<T> (*)(BytesView);

/// What other products may read in another way, one line each.
template <class T>
void add_notes(Report& report, const T& document, const fs::path& path) {
  report.result["notes"] = Json::array();
  for (const auto& note : document.notes) {
    report.text += fmt::format("note: {}, line {}: {}\n", path.string(), note.line, note.text);
    report.result["notes"].push_back({{"line", note.line}, {"text", note.text}});
  }
}

// A document that cannot be read is not worth a signature.
template <class T>
Result<Report> sign(Reader<T> read, const Arguments& arguments, const Context& context) {
  const fs::path from = arguments.text("FILE");
  const fs::path to = arguments.has("-o") ? fs::path(arguments.text("-o"))
                                          : fs::path(from).replace_extension("p7s");
  const auto octets = DDSSEC_TRY(read_file(from, pki::kMostDocumentOctets));
  const auto document = DDSSEC_TRY(named(read(octets), from));
  const auto ca = DDSSEC_TRY(load_ca(ca_folder(arguments.text("--ca"), "permissions"), arguments));
  const auto signed_octets =
      DDSSEC_TRY(named(ca.sign_document(octets, context.clock.now(), context.random), from));
  Report report;
  report.files_written.push_back(DDSSEC_TRY(write_new_file(to, signed_octets, 0644)));
  report.text = fmt::format("{}  signed by {}\n", to.string(), ca.certificate().subject());
  report.result = {{"file", to.string()}, {"signer", ca.certificate().subject()}};
  add_notes(report, document, from);
  return report;
}

template <class T>
Result<Report> verify(Reader<T> read, const Arguments& arguments, const Context& context) {
  const fs::path file = arguments.text("FILE");
  const auto proof = DDSSEC_TRY(verified(file, arguments.text("--ca"), context.clock.now()));
  const auto document = DDSSEC_TRY(named(read(proof.content()), file));
  Report report;
  report.text = fmt::format("{}: signed by {}, valid until {}\n", file.string(),
                            proof.signer().subject(), date(proof.signer_not_after()));
  report.result = {{"file", file.string()},
                   {"signer", proof.signer().subject()},
                   {"signer_sha256", to_hex(proof.signer().fingerprint())},
                   {"signer_not_after", to_string(proof.signer_not_after())}};
  add_notes(report, document, file);
  return report;
}

Result<Report> governance_sign(const Arguments& arguments, const Context& context) {
  return sign(&governance::read_governance, arguments, context);
}
Result<Report> governance_verify(const Arguments& arguments, const Context& context) {
  return verify(&governance::read_governance, arguments, context);
}
Result<Report> permissions_sign(const Arguments& arguments, const Context& context) {
  return sign(&governance::read_permissions, arguments, context);
}
Result<Report> permissions_verify(const Arguments& arguments, const Context& context) {
  return verify(&governance::read_permissions, arguments, context);
}

const Option kCaCertificate{.name = "--ca",
                            .value = "FILE",
                            .summary = "the permissions CA's certificate",
                            .required = true};

std::vector<Option> signing_options() {
  return {ca_option("the folder that ca create made"),
          {"-o", "FILE", "the signed document, if not FILE with the ending p7s"},
          kPassphraseFile,
          kPassphraseEnv,
          kInsecureKeyMode};
}

}  // namespace

std::vector<Command> document_commands() {
  return {
      {.group = "governance",
       .name = "sign",
       .summary = "Signs a governance document that can be read, in the form every vendor reads.",
       .positionals = {{"FILE", "the XML document"}},
       .options = signing_options(),
       .examples = {"ddssec governance sign governance.xml --ca ca"},
       .run = governance_sign},
      {.group = "governance",
       .name = "verify",
       .summary = "Verifies a signed governance document and reads it.",
       .positionals = {{"FILE", "the signed document"}},
       .options = {kCaCertificate},
       .examples = {"ddssec governance verify governance.p7s --ca ca/permissions/ca.pem"},
       .run = governance_verify},
      {.group = "permissions",
       .name = "sign",
       .summary = "Signs a permissions document that can be read, in the form every vendor reads.",
       .positionals = {{"FILE", "the XML document"}},
       .options = signing_options(),
       .examples = {"ddssec permissions sign permissions.xml --ca ca -o talker/permissions.p7s"},
       .run = permissions_sign},
      {.group = "permissions",
       .name = "verify",
       .summary = "Verifies a signed permissions document and reads it.",
       .positionals = {{"FILE", "the signed document"}},
       .options = {kCaCertificate},
       .examples = {"ddssec permissions verify permissions.p7s --ca ca/permissions/ca.pem"},
       .run = permissions_verify}};
}

}  // namespace ddssec::cli
