// Documents whose signature does not say when it was made, such as those of `openssl smime
// -noattr`.
#pragma once

#include <string>

#include "pki/openssl.hpp"
#include "pki/pki_access.hpp"
#include "pki/unverified_document.hpp"
#include "tests/unit/pki/pki_fixture.hpp"

namespace ddssec::pki {

/// Returns the signed `file` with another signature.
inline std::string with_signature(const std::string& file, BytesView der) {
  const auto begin = file.find("smime.p7s\"\n\n") + 12;
  return file.substr(0, begin) + base64(der) + "\n" + file.substr(file.find("\n--", begin));
}

/// Returns the signed `file`, signed again by `signer` without signed attributes.
inline std::string without_signing_time(const std::string& file, const Credential& signer) {
  const auto document = read_document(as_bytes(file));
  EXPECT_TRUE(document);
  constexpr unsigned kFlags = CMS_DETACHED | CMS_BINARY | CMS_NOATTR;
  const BioPtr content = bio_over(document->signed_octets);
  const CmsPtr cms(CMS_sign(impl_of(signer.certificate).x509.get(), impl_of(signer.key).pkey.get(),
                            nullptr, content.get(), kFlags));
  EXPECT_TRUE(cms) << take_openssl_reason();
  const BioPtr der(BIO_new(BIO_s_mem()));
  EXPECT_EQ(i2d_CMS_bio(der.get(), cms.get()), 1);
  return with_signature(file, bio_octets(der));
}

}  // namespace ddssec::pki
