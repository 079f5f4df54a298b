// keystore split-ca, keystore rotate: new CAs for a keystore that is in use, and new
// signatures of everything.
#include <filesystem>

#include <fmt/format.h>

#include "base/text.hpp"
#include "cli/ca/ca_folder.hpp"
#include "cli/ca/ca_rotation.hpp"
#include "cli/ca/certificate_facts.hpp"
#include "cli/ca/identity_ca_rotation.hpp"
#include "cli/ca/list_dates.hpp"
#include "cli/ca/permissions_ca_rotation.hpp"
#include "cli/commands/groups.hpp"
#include "cli/documents/documents.hpp"
#include "cli/folders/enclaves.hpp"
#include "cli/frame/file_transaction.hpp"
#include "cli/frame/options.hpp"
#include "cli/inputs/files.hpp"
#include "cli/participant/keystore.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

// sros2 links both roles to one CA. If a command was killed, the new keys may be in place and other
// files not: the work is finished first.
Result<bool> has_one_ca(const fs::path& keystore) {
  DDSSEC_RETURN_IF_ERROR(finish_interrupted(keystore / "private", Reach::anywhere));
  std::error_code ignored;
  return fs::equivalent(keystore / "private/identity_ca.key.pem",
                        keystore / "private/permissions_ca.key.pem", ignored);
}

std::vector<AffectedParticipant> participants_in(const fs::path& keystore,
                                                 const Enclaves& enclaves) {
  std::vector<AffectedParticipant> out;
  for (const auto& name : enclaves.names)
    out.push_back(
        {name, pki::participant_folder(keystore / enclave_folder(name), pki::FolderLayout::sros2)});
  return out;
}

// A CA that signed a keystore's enclaves again.
struct KeystoreCa {
  static constexpr std::string_view kDef = "keystore_ca";
  NewCaFacts ca;
  std::vector<std::string> enclaves;
  std::optional<std::vector<std::string>> unlogged = {};
  fs::path keystore;
  bool is_new = true;

  static constexpr auto fields() {
    return std::tuple_cat(fields_within(&KeystoreCa::ca),
                          std::tuple(field<&KeystoreCa::enclaves>({"signed again"}),
                                     field<&KeystoreCa::unlogged>(
                                         {.note = "documents signed although the log lacks them",
                                          .omits_empty = true})));
  }
  std::string text() const {
    if (!is_new) return fmt::format("{}  has two CAs already\n", keystore.string());
    auto out = fmt::format(
        "{}  {} CA is {} now, with a new key; {} signed again\nCopies of enclaves on other "
        "machines "
        "need the new files, too. Every participant must start again with them, unless it runs on "
        "ddssec's plugins: old ones and new ones do not authenticate each other.\n",
        keystore.string(), ca.role, ca.subject, count_text(enclaves.size(), "enclave"));
    for (const auto& file : unlogged.value_or(std::vector<std::string>()))
      out += fmt::format("signed although the log does not have it: {}\n", printable(file));
    return out;
  }
};

Answer<KeystoreCa> answer_of(const fs::path& keystore, std::string_view role,
                             const pki::Certificate& ca, std::vector<std::string> enclaves) {
  return {{.ca = NewCaFacts::of(role, ca), .enclaves = std::move(enclaves), .keystore = keystore}};
}

std::string subject_for(const fs::path& keystore, std::string_view role) {
  std::error_code ignored;
  return ca_subject(fs::absolute(keystore, ignored).lexically_normal().filename().string(), role);
}

void add_rotation(const RotationResult& rotation, const Enclaves& enclaves,
                  Answer<KeystoreCa>& out) {
  out.result.unlogged = rotation.unlogged;
  add_unreached(rotation, out.report);
  add_unseen(enclaves, out.report);
}

Result<Answer<KeystoreCa>> new_permissions_ca(const fs::path& keystore, const std::string& subject,
                                              const Arguments& arguments, const Context& context) {
  CaOpener opener(arguments);
  DDSSEC_ASSIGN_OR_RETURN(const auto old, opener.open(ca_paths(keystore, "permissions")));
  DDSSEC_ASSIGN_OR_RETURN(const auto ca, new_root(old.certificate(), subject, context));
  const CaRotation change{old, ca, ca.certificate().pem(), opener.used_passphrase(),
                          arguments.has("--unlogged")};
  FileTransaction out;
  const auto enclaves = enclaves_of(keystore);
  DDSSEC_ASSIGN_OR_RETURN(auto rotation,
                          rotate_permissions_ca(out, change, participants_in(keystore, enclaves),
                                                {keystore / "enclaves/governance.p7s"}, context));
  DDSSEC_ASSIGN_OR_RETURN(auto files, put_in_place(out, rotation));
  auto answer = answer_of(keystore, "permissions", ca.certificate(), rotation.updated);
  add_rotation(rotation, enclaves, answer);
  answer.report.files_written = std::move(files);
  return answer;
}

// Before a keystore is split, its identity CA also signs the documents.
Result<OpenCa> former_signer(const fs::path& keystore, CaOpener& opener) {
  DDSSEC_ASSIGN_OR_RETURN(auto out, opener.open(ca_paths(keystore, "identity")));
  auto certificate = std::move(out.paths.certificate);
  out.paths = ca_paths(keystore, "permissions");
  out.paths.certificate = std::move(certificate);
  return out;
}

// Handles the enclaves whose folders could not be written when the keystore was split.
Result<Answer<KeystoreCa>> finish_split(const fs::path& keystore, const Enclaves& enclaves,
                                        const std::vector<AffectedParticipant>& left,
                                        const Arguments& arguments, const Context& context) {
  CaOpener opener(arguments);
  DDSSEC_ASSIGN_OR_RETURN(const auto former, former_signer(keystore, opener));
  DDSSEC_ASSIGN_OR_RETURN(const auto present, opener.open(ca_paths(keystore, "permissions")));
  const CaRotation change{former, present.authority, present.trust_pem, nullptr,
                          arguments.has("--unlogged")};
  FileTransaction out;
  DDSSEC_ASSIGN_OR_RETURN(
      auto rotation, finish_permissions_rotation(out, change, left,
                                                 {keystore / "enclaves/governance.p7s"}, context));
  DDSSEC_ASSIGN_OR_RETURN(auto files, put_in_place(out, rotation));
  auto answer = answer_of(keystore, "permissions", present.certificate(), rotation.updated);
  add_rotation(rotation, enclaves, answer);
  answer.report.files_written = std::move(files);
  return answer;
}

Result<Answer<KeystoreCa>> already_split(const fs::path& keystore, const Arguments& arguments,
                                         const Context& context) {
  DDSSEC_ASSIGN_OR_RETURN(const auto trusted,
                          read_certificates(ca_paths(keystore, "permissions").certificate));
  const auto enclaves = enclaves_of(keystore);
  const auto left = left_with_another_ca(participants_in(keystore, enclaves), to_pem(trusted),
                                         context.clock.calendar_seconds());
  if (!left.empty()) return finish_split(keystore, enclaves, left, arguments, context);
  auto answer = answer_of(keystore, "permissions", trusted.front(), {});
  answer.result.is_new = false;
  add_unseen(enclaves, answer.report);
  return answer;
}

Result<Answer<KeystoreCa>> new_identity_ca(const fs::path& keystore, const Arguments& arguments,
                                           const Context& context) {
  CaOpener opener(arguments);
  DDSSEC_ASSIGN_OR_RETURN(const auto old, opener.open(ca_paths(keystore, "identity")));
  DDSSEC_ASSIGN_OR_RETURN(const auto ca,
                          new_root(old.certificate(), old.certificate().subject(), context));
  const CaRotation change{old, ca, ca.certificate().pem(), opener.used_passphrase(),
                          arguments.has("--unlogged")};
  FileTransaction out;
  const auto enclaves = enclaves_of(keystore);
  DDSSEC_ASSIGN_OR_RETURN(
      auto rotation, rotate_identity_ca(out, change, participants_in(keystore, enclaves), context));
  DDSSEC_ASSIGN_OR_RETURN(auto files, put_in_place(out, rotation));
  auto answer = answer_of(keystore, "identity", ca.certificate(), rotation.updated);
  for (const auto& name : rotation.revoked)
    answer.report.text += printable(name) + " is revoked and was left out\n";
  add_unreached(rotation, answer.report);
  add_unseen(enclaves, answer.report);
  answer.report.files_written = std::move(files);
  return answer;
}

Result<Answer<KeystoreCa>> keystore_split_ca(const Arguments& arguments, const Context& context) {
  const fs::path keystore = arguments.text("KEYSTORE");
  DDSSEC_RETURN_IF_ERROR(check_keystore(keystore));
  DDSSEC_ASSIGN_OR_RETURN(const auto one_ca, has_one_ca(keystore));
  if (!one_ca) return already_split(keystore, arguments, context);
  return new_permissions_ca(keystore, subject_for(keystore, "Permissions"), arguments, context);
}

Result<Answer<KeystoreCa>> keystore_rotate(const Arguments& arguments, const Context& context) {
  const fs::path keystore = arguments.text("KEYSTORE");
  DDSSEC_ASSIGN_OR_RETURN(const auto role, role_option(arguments));
  std::error_code ignored;
  if (fs::is_directory(keystore, ignored) && !fs::exists(keystore / "public", ignored))
    return fail(Code::usage, {.field = "KEYSTORE",
                              .note = "without a folder public it is no keystore of ROS 2; for a "
                                      "CA of ca create or init it is: ddssec ca rotate"});
  DDSSEC_RETURN_IF_ERROR(check_keystore(keystore));
  DDSSEC_ASSIGN_OR_RETURN(const auto one_ca, has_one_ca(keystore));
  if (one_ca)
    return fail(Code::usage, {.field = "KEYSTORE",
                              .note = "it has one CA for both: ddssec keystore split-ca first"});
  DDSSEC_RETURN_IF_ERROR(
      check_list_date(context.clock.calendar_seconds(), ca_paths(keystore, "identity"), arguments));
  if (role == "identity") return new_identity_ca(keystore, arguments, context);
  DDSSEC_ASSIGN_OR_RETURN(const auto ca,
                          read_certificate(ca_paths(keystore, "permissions").certificate));
  return new_permissions_ca(keystore, ca.subject(), arguments, context);
}

const Option kUnlogged{
    "--unlogged", "",
    "also what the CA's log does not have, such as what sros2 made; after a key was stolen, never "
    "without reading it"};

}  // namespace

std::vector<Command> keystore_ca_commands() {
  return {{.group = "keystore",
           .name = "split-ca",
           .summary = "Gives a keystore with one CA a permissions CA of its own; signs all again.",
           .positionals = {{"KEYSTORE", "the keystore's folder"}},
           .options = {kUnlogged, kPassphraseFile, kPassphraseEnv, kInsecureKeyMode},
           .examples = {"ddssec keystore split-ca keystore",
                        "ddssec keystore split-ca keystore --unlogged"},
           .run = keystore_split_ca},
          {.group = "keystore",
           .name = "rotate",
           .summary = "Replaces a CA and its key; issues or signs everything of it again.",
           .positionals = {{"KEYSTORE", "the keystore's folder"}},
           .options = {{.name = "--role",
                        .value = "ROLE",
                        .summary = "identity or permissions",
                        .required = true},
                       kClockIsRight,
                       kUnlogged,
                       kPassphraseFile,
                       kPassphraseEnv,
                       kInsecureKeyMode},
           .examples = {"ddssec keystore rotate keystore --role permissions"},
           .run = keystore_rotate}};
}

}  // namespace ddssec::cli
