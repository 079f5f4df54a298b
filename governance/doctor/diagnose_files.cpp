// Checks that the files exist, have the right kind and are not accessible for other users.
#include <algorithm>
#include <array>
#include <sys/stat.h>
#include <system_error>

#include <fmt/format.h>

#include "base/uri_source.hpp"
#include "governance/doctor/checks.hpp"
#include "governance/doctor/measured_outcomes.hpp"
#include "governance/doctor/secrets_in_text.hpp"
#include "governance/doctor/stock_spelling.hpp"
#include "governance/doctor/writable_places.hpp"
#include "pki/certificate_source.hpp"

namespace ddssec::governance::doctor {
namespace {

namespace fs = std::filesystem;

// The largest number of files in a folder that are searched for keys of a CA.
constexpr int kMaxFiles = 64;

// The reason why `path` does not exist: it may be a dangling link.
std::string absence(const fs::path& path) {
  std::error_code ignored;
  if (!fs::is_symlink(fs::symlink_status(path, ignored)))
    return fmt::format("{} is missing", name_of(path));
  return fmt::format("{} is a link to {}, which does not exist", name_of(path),
                     fs::read_symlink(path, ignored).string());
}

void report_key(const LoadedFolder& folder, const fs::path& path, const Error& error,
                const Settings& settings, Diagnosis& out) {
  const auto outcomes = outcomes_of_key(folder.paths, path, error, settings.lineup);
  std::string who = "ddssec's plugins", unjudged;
  for (const auto product : {Product::cyclonedds, Product::fastdds}) {
    const auto outcome = outcomes.of(product);
    if (outcome == Outcome::fail) who += " and " + name(product, settings.lineup);
    if (outcome == Outcome::unsafe)
      unjudged +=
          fmt::format("; {} may start with it, and what else is wrong with it is not judged",
                      name(product, settings.lineup));
  }
  out.report(outcomes, {.rule = Rule::DOC014,
                        .message = fmt::format("{}: {}; {} refuse it{}", name_of(path),
                                               error.message(), who, unjudged),
                        .document = path});
}

// What makes a missing document; empty for other files, for which the rule's hint is right.
std::string hint_of_missing(const pki::ParticipantFolder& paths, const fs::path& path) {
  if (path != paths.permissions || paths.layout == pki::FolderLayout::sros2) return {};
  return fmt::format(
      "copy it from where the participant was issued; or make new permissions with "
      "all topics of the participant: ddssec permissions new --cert {} --publish "
      "TOPIC --subscribe TOPIC --sign --ca CA -o {}",
      paths.certificate.string(), fs::path(path).replace_extension("xml").string());
}

// Reports a file that could not be loaded. An encrypted key has a rule of its own.
void report_unloaded(const pki::ParticipantFolder& paths, const fs::path& path, const Error& error,
                     Diagnosis& out) {
  const auto say = [&](Rule rule, std::string message, std::string_view hint = {}) {
    auto outcomes = kAllFail;
    if (rule == Rule::DOC002 && has_certificate_for_openssl(path))
      outcomes.cyclonedds = outcomes.fastdds = Outcome::unsafe;
    out.report(
        outcomes,
        {.rule = rule, .message = std::move(message), .document = path, .hint = std::string(hint)});
  };
  switch (error.code()) {
    case Code::file_not_found:
      return say(Rule::DOC001, absence(path), hint_of_missing(paths, path));
    case Code::passphrase_missing:
      return say(Rule::DOC013, fmt::format("{} is encrypted and no product is given a password "
                                           "for it by its files",
                                           name_of(path)));
    case Code::pkcs11_unavailable:
    case Code::pkcs11_not_found:
    case Code::pkcs11_pin_missing:
    case Code::pkcs11_pin_wrong:
      return say(Rule::DOC005, fmt::format("{}: {}", name_of(path), error.message()));
    case Code::file_unreadable:
      return say(Rule::DOC002, fmt::format("{}: {}", name_of(path), error.message()), error.hint());
    default:
      return say(Rule::DOC002, fmt::format("{}: {}", name_of(path), error.message()),
                 error.details().hint);
  }
}

// Reports a key that opens with the password that only some products are given.
void diagnose_password(const LoadedFolder& folder, const Settings& settings, Diagnosis& out) {
  if (!folder.password) return;
  out.pass(Rule::DOC013);
  Outcomes outcomes;
  std::string who;
  const auto look_at = [&](Product product, Outcome& outcome) {
    if (folder.password->is_given_to(product)) return;
    outcome = Outcome::fail;
    who += (who.empty() ? "" : " and ") + name(product, settings.lineup);
  };
  look_at(Product::cyclonedds, outcomes.cyclonedds);
  look_at(Product::fastdds, outcomes.fastdds);
  look_at(Product::ddssec, outcomes.ddssec);
  if (who.empty()) return;
  out.report(outcomes, {.rule = Rule::DOC013,
                        .message = fmt::format("{} is encrypted, and {} {} given no password that "
                                               "opens it by the files",
                                               name_of(folder.paths.key), who,
                                               who.contains(" and ") ? "are" : "is"),
                        .document = folder.paths.key});
}

void diagnose_loaded(const LoadedFolder& folder, const Settings& settings, Diagnosis& out) {
  const auto look = [&](const auto& piece, const fs::path& path) {
    if (piece) return;
    if (piece.error().code() == Code::key_not_allowed)
      return report_key(folder, path, piece.error(), settings, out);
    report_unloaded(folder.paths, path, piece.error(), out);
  };
  look(folder.identity_cas, folder.paths.identity_ca);
  look(folder.certificate, folder.paths.certificate);
  look(folder.key, folder.paths.key);
  diagnose_password(folder, settings, out);
  look(folder.permissions_cas, folder.paths.permissions_ca);
  look(folder.governance.readable, folder.paths.governance);
  look(folder.permissions.readable, folder.paths.permissions);
  // Otherwise diagnose_identity reports it.
  if (folder.crls_with_deltas.empty()) look(folder.crls, folder.paths.crl);
}

bool is_in_token(const fs::path& path) { return path.extension() == ".p11"; }

// Measured: Cyclone DDS refuses the scheme, and Fast DDS accepts it for the private key only.
void diagnose_tokens(const LoadedFolder& folder, Diagnosis& out) {
  const auto look = [&](const fs::path& path, Outcome fastdds) {
    if (!is_in_token(path)) return;
    out.report({.cyclonedds = Outcome::fail, .fastdds = fastdds},
               {.rule = Rule::DOC005,
                .message = fmt::format(
                    "{} names what is in a token (pkcs11:), which {}", name_of(path),
                    fastdds == Outcome::ok ? "Cyclone DDS does not read"
                                           : "neither Cyclone DDS nor Fast DDS reads there"),
                .document = path});
  };
  look(folder.paths.key, Outcome::ok);
  for (const auto* path :
       {&folder.paths.identity_ca, &folder.paths.certificate, &folder.paths.permissions_ca})
    look(*path, Outcome::fail);
}

// False for a key in a token, unless the file contains the PIN.
bool is_secret(const fs::path& key) {
  if (!is_in_token(key)) return true;
  const auto uri = pki::uri_of(key);
  return uri && uri->find("pin-value") != uri->npos;
}

void diagnose_mode(const fs::path& key, Diagnosis& out) {
  struct stat status {};
  if (::stat(key.c_str(), &status) != 0) return;
  if ((status.st_mode & 077) == 0 || !is_secret(key)) return out.pass(Rule::DOC003);
  out.report({}, {.rule = Rule::DOC003,
                  .message = fmt::format("{} has mode {:04o}, others than its owner can read or "
                                         "change it; it should have 0600",
                                         name_of(key), status.st_mode & 07777),
                  .document = key});
}

// True if others than its owner can read the file.
bool is_readable_by_others(const fs::path& path, unsigned& mode) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) return false;
  mode = status.st_mode & 07777;
  return (mode & 077) != 0;
}

void report_readable_secret(const fs::path& path, std::string_view what, Diagnosis& out,
                            std::string hint = {}) {
  unsigned mode = 0;
  if (!is_readable_by_others(path, mode)) return;
  out.report({},
             {.rule = Rule::DOC003,
              .message = fmt::format("{} {} and has mode {:04o}: others than its owner can read "
                                     "it; it should have 0600",
                                     name_of(path), what, mode),
              .document = path,
              .hint = std::move(hint)});
}

// Where the governance demands pre-shared keys, DOC091 judges their passphrases.
bool uses_pre_shared_keys(const LoadedFolder& folder, const Settings& settings) {
  const auto* const rule =
      folder.governance.model ? folder.governance.model->find(settings.domain) : nullptr;
  return rule != nullptr && is_protected(rule->rtps_psk_protection_kind);
}

void diagnose_configuration_modes(const LoadedFolder& folder, const Settings& settings,
                                  Diagnosis& out) {
  const auto& paths = folder.paths;
  for (const auto& path :
       {paths.folder / "cyclonedds.xml", paths.folder / "fastdds.xml", paths.properties}) {
    const auto text = ddssec::load_uri("file:" + path.string(), "", pki::kMaxDocumentOctets);
    if (!text) continue;
    const auto secrets = secrets_in(as_text(*text));
    if (secrets.are_there)
      report_readable_secret(path, "holds a password, a PIN or a private key", out);
    for (const auto& file : secrets.files)
      report_readable_secret(file, fmt::format("is named as a secret by {}", name_of(path)), out);
    if (uses_pre_shared_keys(folder, settings)) continue;
    for (const auto& file : secrets.passphrase_files)
      report_readable_secret(
          file, fmt::format("is named for a passphrase by {}", name_of(path)), out,
          "chmod 600 the file; if others may have read it, change the passphrase at all "
          "participants (docs/pre-shared-keys.md)");
  }
}

// The folder's owner is usually the participant's user, who must be able to read the key.
void diagnose_owner(const fs::path& key, Diagnosis& out) {
  struct stat status {};
  struct stat folder {};
  if (::stat(key.c_str(), &status) != 0 || ::stat(key.parent_path().c_str(), &folder) != 0) return;
  const bool can_read = (status.st_mode & 044) != 0 || folder.st_uid == 0;
  if (status.st_uid == folder.st_uid || can_read) return out.pass(Rule::DOC003);
  out.report({}, {.rule = Rule::DOC003,
                  .message = fmt::format(
                      "{} belongs to user {} with mode {:04o}, and its folder to "
                      "user {}, who cannot read it",
                      name_of(key), status.st_uid, status.st_mode & 07777, folder.st_uid),
                  .document = key,
                  .hint = "give the key to the user that runs the participant: chown"});
}

// The CA whose private key `path` holds, or "" if it holds none.
std::string ca_of_key(const fs::path& path, const LoadedFolder& folder) {
  const auto key = pki::PrivateKey::load("file://" + path.string(), "");
  if (!key) return key.error().code() == Code::passphrase_missing ? "a CA, encrypted" : "";
  for (const auto* cas : {&folder.identity_cas, &folder.permissions_cas}) {
    if (!*cas) continue;
    for (const auto& ca : **cas)
      if (key->check_fits(ca)) return ca.subject();
  }
  return {};
}

void diagnose_strangers(const LoadedFolder& folder, Diagnosis& out) {
  std::error_code error;
  int seen = 0;
  for (const auto& entry : fs::directory_iterator(folder.paths.folder, error)) {
    if (++seen > kMaxFiles) break;
    const auto& path = entry.path();
    const bool may_be_key = path.extension() == ".pem" || path.extension() == ".key";
    if (!may_be_key || path == folder.paths.key || !entry.is_regular_file(error)) continue;
    const auto ca = ca_of_key(path, folder);
    if (ca.empty()) continue;
    out.report({}, {.rule = Rule::DOC004,
                    .message = fmt::format("{} holds the private key of {}", name_of(path), ca),
                    .document = path});
  }
  if (!error) out.pass(Rule::DOC004);
}

// ROS 2 reads the CA files of an enclave by their names there. Other applications read the files
// that they are given. If both exist and differ, one of them was not judged.
void diagnose_layouts(const LoadedFolder& folder, Diagnosis& out) {
  using pki::FolderLayout;
  const auto flat = pki::participant_folder(folder.paths.folder, FolderLayout::flat);
  const auto sros2 = pki::participant_folder(folder.paths.folder, FolderLayout::sros2);
  out.pass(Rule::DOC009);
  for (const auto file :
       {&pki::ParticipantFolder::identity_ca, &pki::ParticipantFolder::permissions_ca}) {
    const auto& judged = folder.paths.*file;
    const auto& other = judged == flat.*file ? sros2.*file : flat.*file;
    std::error_code ignored;
    if (fs::symlink_status(other, ignored).type() <= fs::file_type::not_found ||
        has_same_octets(other, judged))
      continue;
    out.report(kAllFail, {.rule = Rule::DOC009,
                          .message = fmt::format("{} stands beside {}, which was judged, and holds "
                                                 "something else: which of them counts depends on "
                                                 "the application",
                                                 name_of(other), name_of(judged)),
                          .document = other});
  }
}

// True for files that a participant or its tools read from the folder.
bool is_read(const fs::path& path) {
  constexpr std::array kExtensions = {".pem",        ".p7s", ".der", ".xml",
                                      ".properties", ".p11", ".key"};
  return std::ranges::find(kExtensions, path.extension()) != kExtensions.end();
}

void diagnose_writable_places(const LoadedFolder& folder, const Settings& settings,
                              Diagnosis& out) {
  WritablePlaces places(user_of(folder.paths));
  const auto add = [&](const fs::path& path) {
    settings.may_run_elsewhere ? places.add(path) : places.add_with_way(path);
  };
  const auto& paths = folder.paths;
  add(paths.folder);
  // Files that are known by name come first, because the folder may have more files than are
  // examined.
  for (const auto& file : {paths.key, paths.certificate, paths.identity_ca, paths.permissions_ca,
                           paths.crl, paths.governance, paths.permissions, paths.properties,
                           paths.folder / "cyclonedds.xml", paths.folder / "fastdds.xml"})
    if (!file.empty()) add(file);
  std::error_code error;
  int seen = 0;
  for (const auto& entry : fs::directory_iterator(folder.paths.folder, error)) {
    if (++seen > kMaxFiles) break;
    if (is_read(entry.path())) add(entry.path());
  }
  places.report(Outcomes::all(Outcome::unsafe), out);
}

}  // namespace

// The outcomes for a key that DDS-Security does not allow. A product that starts with it is
// "unsafe": ddssec does not read the certificate, so nothing else about it is judged. The documents
// that a permissions CA signed are still judged. Measured with Cyclone DDS 0.10.2 and Fast DDS
// 2.9.1:
// - Both take every key of a permissions CA that OpenSSL takes (RSA-1024, P-224, P-521, secp256k1),
//   except that Fast DDS does not take RSASSA-PSS.
// - Fast DDS also does not start with an Ed25519 or Ed448 key of an identity CA.
Outcomes outcomes_of_key(const pki::ParticipantFolder& paths, const fs::path& path,
                         const Error& error, const Lineup& lineup) {
  const bool is_of_permissions_ca = path == paths.permissions_ca;
  const bool is_explicit = is_key_of_explicit_curve(error);
  const std::string_view key = error.details().found;
  const bool is_edwards = key.contains("ED");
  auto out = kAllFail;
  if (is_key_of_another_curve(error) || is_explicit) out.cyclonedds = Outcome::unsafe;
  if (is_of_permissions_ca) {
    if (!is_explicit) out.cyclonedds = Outcome::ok;
    out.fastdds = key.contains("RSA-PSS") ? Outcome::fail : Outcome::ok;
    return out;
  }
  const bool is_refused = is_explicit || (path == paths.identity_ca && is_edwards);
  const auto variant = is_edwards ? Variant::ed25519 : Variant::rsa_1024;
  out.fastdds = is_refused ? Outcome::fail : measured(variant, lineup).fastdds;
  return out;
}

bool is_key_of_another_curve(const Error& error) {
  const auto& found = error.details().found;
  return error.code() == Code::key_not_allowed && found.starts_with("EC ") &&
         !found.starts_with("EC of") && found.ends_with(" of 256 bits");
}

bool has_same_octets(const fs::path& one, const fs::path& other) {
  std::error_code ignored;
  if (fs::equivalent(one, other, ignored)) return true;
  const auto load = [](const fs::path& path) {
    return ddssec::load_uri("file://" + path.string(), "", pki::kMaxDocumentOctets);
  };
  const auto a = load(one), b = load(other);
  return a && b && *a == *b;
}

void diagnose_files(const LoadedFolder& folder, const Settings& settings, Diagnosis& out) {
  for (const auto rule : {Rule::DOC001, Rule::DOC002}) out.pass(rule);
  diagnose_loaded(folder, settings, out);
  diagnose_tokens(folder, out);
  diagnose_mode(folder.paths.key, out);
  diagnose_configuration_modes(folder, settings, out);
  diagnose_owner(folder.paths.key, out);
  diagnose_writable_places(folder, settings, out);
  diagnose_strangers(folder, out);
  diagnose_layouts(folder, out);
  diagnose_configurations(folder, settings, out);
}

}  // namespace ddssec::governance::doctor
