// The time at which a document was signed, according to its signature.
#include "pki/signing_time.hpp"

#include <algorithm>

#include "pki/smime.hpp"
#include "pki/smime_diagnosis.hpp"
#include "pki_fixture.hpp"
#include "untimed_signature.hpp"

namespace ddssec::pki {
namespace {

class SigningTime : public testing::Test {
 protected:
  Result<SignedDocument> check(const std::string& file) const {
    return DocumentVerifier::make({ca_.certificate()})->verify(as_bytes(file), kNow);
  }
  std::string sign(WallTime time) const {
    return std::string(
        as_text(*ca_.sign_document(as_bytes("<dds>\n</dds>\n"), time, test_random())));
  }

  Authority ca_ = make_ca("CN=Permissions CA");
};

TEST_F(SigningTime, SignedDocument_HasTheTimeOfTheSigner) {
  // The times are written as UTCTime and, from 2050 on, as GeneralizedTime.
  for (const auto time : {kNow, kNow - std::chrono::years(1), kNow + std::chrono::years(40)}) {
    const auto file = sign(time);
    const auto document = check(file);
    ASSERT_TRUE(document) << document.error().to_sentence();
    EXPECT_EQ(document->signing_time(), time);
    EXPECT_EQ(examine_document(as_bytes(file)).signing_time, time);
  }
}

TEST_F(SigningTime, SignatureWithoutIt_HasNone) {
  const auto file = without_signing_time(sign(kNow), {ca_.certificate(), ca_.key()});
  const auto document = check(file);
  ASSERT_TRUE(document) << document.error().to_sentence();
  EXPECT_EQ(document->signing_time(), std::nullopt);
  EXPECT_EQ(examine_document(as_bytes(file)).signing_time, std::nullopt);
}

TEST_F(SigningTime, ChangedTime_IsNoSignature) {
  auto file = sign(kNow);
  const auto document = read_document(as_bytes(file));
  ASSERT_TRUE(document);
  auto der = document->signature;
  // Changes the seconds of "YYMMDDhhmmssZ".
  const auto text = ddssec::to_string(kNow);
  std::string utc;
  for (const char c : text.substr(2))
    if (c >= '0' && c <= '9') utc += c;
  const auto place = std::ranges::search(der, as_bytes(utc));
  ASSERT_FALSE(place.empty()) << utc;
  place[11] ^= 1;
  EXPECT_CODE(check(with_signature(file, der)), smime_signature_invalid);
}

}  // namespace
}  // namespace ddssec::pki
