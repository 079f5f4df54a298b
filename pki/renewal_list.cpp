#include "pki/renewal_list.hpp"

#include "pki/certificate_source.hpp"
#include "pki/openssl.hpp"
#include "pki/pem_block.hpp"

namespace ddssec::pki {
namespace {

constexpr std::string_view kCertificateLabel = "CERTIFICATE";
constexpr std::string_view kPermissionsLabel = "SIGNED PERMISSIONS";
// An empty list contains exactly this line. A file that was truncated to zero octets therefore does
// not count as an empty list.
constexpr std::string_view kNoEntry = "# no renewed certificate or permissions\n";

std::unexpected<Error> malformed_error(std::string expected, std::string found) {
  return fail(Code::renewal_list_malformed,
              {.expected = std::move(expected), .found = std::move(found)});
}

Status check_room(std::size_t count, std::string_view what) {
  if (count < kMaxRenewals) return {};
  return malformed_error("at most " + std::to_string(kMaxRenewals) + " " + std::string(what),
                         "more");
}

Status add(RenewalList& out, PemBlock block) {
  if (block.label == kCertificateLabel) {
    DDSSEC_RETURN_IF_ERROR(check_room(out.certificates.size(), "certificates"));
    DDSSEC_ASSIGN_OR_RETURN(auto certificate, Certificate::from_der(block.der));
    out.certificates.push_back(std::move(certificate));
    return {};
  }
  if (block.label != kPermissionsLabel)
    return malformed_error(std::string(kCertificateLabel) + " or " + std::string(kPermissionsLabel),
                           "a block " + block.label.substr(0, 64));
  DDSSEC_RETURN_IF_ERROR(check_room(out.permissions.size(), "permissions"));
  if (block.der.size() > kMaxSentPermissionsOctets)
    return malformed_error(
        "permissions of at most " + std::to_string(kMaxSentPermissionsOctets) + " octets",
        std::to_string(block.der.size()));
  out.permissions.push_back(std::move(block.der));
  return {};
}

}  // namespace

Result<RenewalList> RenewalList::parse(BytesView file) {
  if (file.size() > kMaxRenewalListOctets)
    return malformed_error("at most " + std::to_string(kMaxRenewalListOctets) + " octets",
                           std::to_string(file.size()));
  const BioPtr bio = bio_over(file);
  RenewalList out;
  while (true) {
    auto block = next_pem_block(bio.get());
    if (!block)
      return fail(Code::renewal_list_malformed, {.found = "a block that is cut short or damaged",
                                                 .note = block.error().details().note});
    if (!*block) break;
    DDSSEC_RETURN_IF_ERROR(add(out, **std::move(block)));
  }
  if (out.is_empty() && as_text(file) != kNoEntry)
    return malformed_error("at least one entry", "none");
  return out;
}

Result<std::string> RenewalList::text() const {
  std::string out(is_empty() ? kNoEntry : "");
  for (const auto& certificate : certificates) out += certificate.pem();
  for (const auto& one : permissions) {
    const BioPtr bio(BIO_new(BIO_s_mem()));
    if (!bio || PEM_write_bio(bio.get(), kPermissionsLabel.data(), "", one.data(),
                              static_cast<long>(one.size())) <= 0)
      return openssl_error(Code::internal);
    out += as_text(bio_octets(bio));
  }
  return out;
}

}  // namespace ddssec::pki
