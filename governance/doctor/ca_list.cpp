#include "governance/doctor/ca_list.hpp"

#include <algorithm>
#include <system_error>

#include "pki/certificate_source.hpp"

namespace ddssec::governance::doctor {
namespace {

namespace fs = std::filesystem;

// The deepest enclave (16 folders), enclaves/ and the keystore.
constexpr int kMaxFoldersAbove = 18;

// Places of CA lists relative to a folder with participants: keystore, init, ca create.
constexpr const char* kPlaces[] = {"public/identity_ca.crl.pem", "ca/identity/crl.pem",
                                   "ca/crl.pem"};

std::vector<fs::path> places(const pki::ParticipantFolder& folder) {
  std::vector<fs::path> out;
  std::error_code error;
  // A link in an enclave leads to the certificate in the keystore, wherever the link is.
  const auto ca = fs::canonical(folder.identity_ca, error);
  if (!error) out.push_back(ca.parent_path() / "identity_ca.crl.pem");
  auto at = fs::weakly_canonical(folder.folder, error);
  for (int i = 0; !error && i < kMaxFoldersAbove && at.has_relative_path(); ++i) {
    at = at.parent_path();
    for (const auto* place : kPlaces) out.push_back(at / place);
  }
  return out;
}

std::vector<pki::Crl> lists_in(const fs::path& file) {
  std::error_code ignored;
  if (!fs::is_regular_file(file, ignored)) return {};
  const auto octets =
      pki::load_uri("file://" + file.string(), file.string(), pki::kMaxDocumentOctets);
  if (!octets) return {};
  auto lists = pki::Crl::all_from(*octets);
  return lists ? *std::move(lists) : std::vector<pki::Crl>();
}

// An expired list still shows which certificates were revoked.
bool is_signed_by(const pki::Crl& list, const std::vector<pki::Certificate>& cas) {
  return std::ranges::any_of(cas, [&](const pki::Certificate& ca) {
    return list.is_named_after(ca) && list.check(ca, list.this_update()).has_value();
  });
}

}  // namespace

std::optional<CaList> newer_ca_list(const pki::ParticipantFolder& folder,
                                    const std::vector<pki::Certificate>& cas,
                                    const std::vector<pki::Crl>& own) {
  std::optional<CaList> out;
  const auto is_newer = [&](const pki::Crl& list, const pki::Crl& than) {
    return !pki::have_common_signer(list, than, cas) ||
           than.number().value_or(0) < list.number().value_or(0);
  };
  for (const auto& file : places(folder))
    for (const auto& list : lists_in(file))
      if (std::ranges::all_of(own, [&](const pki::Crl& one) { return is_newer(list, one); }) &&
          (!out || is_newer(list, out->list)) && is_signed_by(list, cas))
        out = {list, file};
  return out;
}

std::optional<CaList> outdated_ca_list(const pki::ParticipantFolder& folder,
                                       const std::vector<pki::Certificate>& cas,
                                       const std::vector<pki::Crl>& own) {
  const auto number = [](const pki::Crl& list) { return list.number().value_or(0); };
  for (const auto& one : own) {
    if (!is_signed_by(one, cas)) continue;
    std::optional<CaList> newest;
    for (const auto& file : places(folder))
      for (const auto& list : lists_in(file))
        if (pki::have_common_signer(list, one, cas) &&
            (!newest || number(newest->list) < number(list)))
          newest = {list, file};
    if (newest && number(newest->list) < number(one)) return newest;
  }
  return std::nullopt;
}

bool lists_certificate(const pki::Crl& list, const pki::Certificate& certificate) {
  const auto entries = list.revoked();
  return list.issuer() == certificate.issuer() && entries &&
         std::ranges::find(*entries, certificate.serial(), &pki::Revocation::serial) !=
             entries->end();
}

bool is_of_its_ca(const pki::Crl& list, const pki::Certificate& certificate,
                  const std::vector<pki::Certificate>& cas) {
  return std::ranges::any_of(cas, [&](const pki::Certificate& ca) {
    return certificate.is_issued_by(ca) && list.is_signed_by(ca);
  });
}

}  // namespace ddssec::governance::doctor
