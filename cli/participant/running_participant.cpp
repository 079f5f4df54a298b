#include "cli/participant/running_participant.hpp"

#include "base/text.hpp"
#include "base/tool_code.hpp"
#include "cli/documents/documents.hpp"
#include "cli/inputs/files.hpp"
#include "cli/inputs/keys.hpp"

namespace ddssec::cli {
namespace {

Error not_taken_error(ErrorDetails details) {
  return Error(tool_code::renewal_not_taken, std::move(details));
}

// False for a key in a token or one with a passphrase, about which nothing is known.
bool is_another_key(const pki::ParticipantFolder& files, const pki::Certificate& certificate) {
  const auto encrypted = is_encrypted(files.key);
  if (!encrypted || *encrypted) return false;
  const auto key = read_key(files.key, nullptr);
  return key && !key->check_fits(certificate);
}

}  // namespace

std::optional<Error> key_not_there(const pki::ParticipantFolder& files,
                                   const pki::Certificate& certificate) {
  if (files.key.extension() == ".p11" || !path_exists(files.identity_ca)) return std::nullopt;
  const bool is_missing = !path_exists(files.key);
  if (!is_missing && !is_another_key(files, certificate)) return std::nullopt;
  return not_taken_error({.document = files.key,
                          .note = is_missing ? "the private key is not in the folder"
                                             : "the private key in the folder belongs to another "
                                               "certificate",
                          .hint =
                              "put the key of the certificate back; if it is lost: ddssec identity "
                              "issue --replace, and restart the participant"});
}

std::optional<Error> certificate_refusal_warning(const pki::ParticipantFolder& files,
                                                 const pki::Certificate& old,
                                                 const pki::Certificate& renewed, bool has_key) {
  const bool ends_earlier = renewed.not_after() < old.not_after();
  if (ends_earlier || renewed.not_before() < old.not_before())
    return not_taken_error(
        {.document = files.certificate,
         .expected = ends_earlier ? "an end not before " + to_string(old.not_after())
                                  : "a begin not before " + to_string(old.not_before()),
         .found = to_string(ends_earlier ? renewed.not_after() : renewed.not_before()),
         .note = "it keeps the former certificate until that one ends (1372)",
         .hint = ends_earlier ? "restart the participant to take the shorter one; or renew it once "
                                "more, with more --days"
                              : "restart the participant"});
  return has_key ? std::nullopt : key_not_there(files, renewed);
}

std::optional<Error> permissions_not_there(const pki::ParticipantFolder& files) {
  if (path_exists(files.permissions) || !path_exists(files.permissions_ca)) return std::nullopt;
  return not_taken_error({.document = files.permissions,
                          .note = "the permissions are not in the folder",
                          .hint =
                              "put the permissions into their place and make this step again, or "
                              "sign new ones: ddssec permissions new"});
}

}  // namespace ddssec::cli
