#include "pki/crl.hpp"

#include <array>

#include <gmock/gmock.h>

#include "pki/authority.hpp"
#include "pki/pki_access.hpp"
#include "pki/self_signed.hpp"
#include "pki_fixture.hpp"
#include "tests/support/delta_list.hpp"

namespace ddssec::pki {
namespace {

const CrlTemplate kMonth{.this_update = kNow, .next_update = kNow + 30 * 24h, .number = 7};

Crl make_crl(const Authority& ca, CrlTemplate content) {
  auto crl = ca.make_crl(content);
  EXPECT_TRUE(crl) << crl.error().to_sentence();
  return *std::move(crl);
}

TEST(CrlEntries, WrittenEntries_AreReadBack) {
  const std::array<Revocation, 3> entries = {
      Revocation{"0A", kNow - 3h, RevocationReason::key_compromise},
      Revocation{"7FFF00112233445566778899AABBCCDD", kNow - 2h, RevocationReason::superseded},
      Revocation{"0B", kNow - 1h, RevocationReason::unspecified}};
  auto content = kMonth;
  content.entries = entries;
  const auto crl = make_crl(make_ca(), content);
  auto read = crl.revoked();
  ASSERT_TRUE(read) << read.error().to_sentence();
  EXPECT_THAT(*read, testing::UnorderedElementsAreArray(entries));
  EXPECT_EQ(crl.number(), 7u);
}

TEST(CrlEntries, TheFirstOfASerialNumber_Counts) {
  const std::array<Revocation, 2> entries = {
      Revocation{"0A", kNow - 3h, RevocationReason::key_compromise},
      Revocation{"0A", kNow, RevocationReason::unspecified}};
  auto content = kMonth;
  content.entries = entries;
  EXPECT_THAT(*make_crl(make_ca(), content).revoked(), testing::ElementsAre(entries[0]));
}

TEST(CrlEntries, ASerialNumberThatIsNone_IsRefused) {
  const auto ca = make_ca();
  for (const auto* serial : {"", "xyz", "0A ", "-", "0Ag"}) {
    const std::array<Revocation, 1> entries = {Revocation{serial, kNow}};
    auto content = kMonth;
    content.entries = entries;
    EXPECT_CODE(ca.make_crl(content), crl_malformed);
  }
}

// RFC 5280 5.3.1 allows this reason in a delta list only. One product would treat the entry as
// revoked, another one would not.
TEST(CrlEntries, EntriesWithTheReasonRemoveFromCrl_AreRefused) {
  const auto ca = make_ca();
  auto content = kMonth;
  const std::array revoked = {make_leaf(ca).certificate};
  content.revoked = revoked;
  const Asn1EnumeratedPtr reason(ASN1_ENUMERATED_new());
  const auto with_reason = [&](long number) {
    ASN1_ENUMERATED_set(reason.get(), number);
    return Crl::all_from(as_bytes(test::with_entry_extension(make_crl(ca, content), ca,
                                                             NID_crl_reason, reason.get(), false)));
  };
  EXPECT_TRUE(with_reason(6)) << "certificateHold";
  EXPECT_CODE(with_reason(8), crl_malformed);
}

// RFC 5280 5.2 and 5.3: such a list must not be used. OpenSSL notices this only when it judges by
// the list.
TEST(CrlExtensions, CriticalOnesThatAreNotUnderstood_AreRefused) {
  const auto ca = make_ca();
  auto content = kMonth;
  const std::array revoked = {make_leaf(ca).certificate};
  content.revoked = revoked;
  const auto list = make_crl(ca, content);
  const Asn1TimePtr time(ASN1_TIME_set(nullptr, 0));
  for (const bool is_critical : {false, true}) {
    const auto of_list =
        test::with_extension(list, ca, NID_invalidity_date, time.get(), is_critical);
    const auto of_entry =
        test::with_entry_extension(list, ca, NID_invalidity_date, time.get(), is_critical);
    for (const auto& text : {of_list, of_entry}) {
      ASSERT_FALSE(text.empty());
      const auto read = Crl::all_from(as_bytes(text));
      if (is_critical) {
        EXPECT_CODE(read, crl_malformed);
        EXPECT_THAT(read.error().to_sentence(), testing::HasSubstr("Invalidity Date"));
      } else {
        EXPECT_TRUE(read);
      }
    }
  }
}

TEST(CrlCheck, IssuersList_IsTakenInItsTime) {
  const auto ca = make_ca();
  const auto crl = make_crl(ca, kMonth);
  EXPECT_TRUE(crl.check(ca.certificate(), kNow));
  EXPECT_CODE(crl.check(ca.certificate(), kNow - 1s), crl_not_yet_valid);
  EXPECT_CODE(crl.check(ca.certificate(), kNow + 30 * 24h), crl_expired);
}

TEST(CrlCheck, OtherSigners_AreRefused) {
  const auto ca = make_ca();
  const auto crl = make_crl(ca, kMonth);
  // This CA has the same name.
  EXPECT_CODE(crl.check(make_ca().certificate(), kNow), crl_signature_invalid);
  EXPECT_CODE(crl.check(make_ca("CN=Other").certificate(), kNow), crl_signature_invalid);
}

TEST(CrlCheck, CaThatMayNotSignLists_IsRefused) {
  auto self = self_sign({.subject = "CN=Root",
                         .validity = kYear,
                         .is_ca = true,
                         .key_usage = "critical,digitalSignature,keyCertSign"},
                        *PrivateKey::generate(KeyKind::ec_p256), test_random());
  ASSERT_TRUE(self);
  const auto ca = Authority::load(self->certificate, self->key);
  ASSERT_TRUE(ca);
  EXPECT_CODE(make_crl(*ca, kMonth).check(ca->certificate(), kNow), crl_signature_invalid);
}

TEST(RevocationReason, EachReason_HasTheWordsOfRfc5280) {
  for (const int number : {0, 1, 2, 3, 4, 5, 6, 9}) {
    const auto reason = static_cast<RevocationReason>(number);
    EXPECT_EQ(revocation_reason_from(to_string(reason)), reason);
  }
  EXPECT_EQ(to_string(RevocationReason::key_compromise), "keyCompromise");
  EXPECT_FALSE(revocation_reason_from("keycompromise"));
}

TEST(Request, RequestWithAnotherSignature_IsRefused) {
  const auto key = PrivateKey::generate(KeyKind::rsa, 2048);
  auto pem = make_request(*key, "CN=device,O=Example");
  ASSERT_TRUE(pem);
  const auto content = read_request(as_bytes(*pem));
  ASSERT_TRUE(content) << content.error().to_sentence();
  EXPECT_EQ(content->subject, "CN=device,O=Example");
  EXPECT_EQ(to_string(content->key), "RSA-2048");
  EXPECT_CODE(read_request(as_bytes("no request")), request_invalid);
  EXPECT_CODE(read_request(Bytes(100'000, 'A')), request_invalid);
  for (std::size_t at = pem->find('\n') + 20; at < pem->size() - 40; at += 97) {
    auto changed = *pem;
    changed[at] = changed[at] == 'A' ? 'B' : 'A';
    EXPECT_CODE(read_request(as_bytes(changed)), request_invalid);
  }
}

// ---- one list in the place of another

TEST(CrlSupersedes, NumberAndTime_MustBothBeLater) {
  const auto ca = make_ca();
  const auto list = [&](std::uint64_t number, WallTime from) {
    return make_crl(ca, {.this_update = from, .next_update = kNow + 24h, .number = number});
  };
  const auto held = list(7, kNow);
  EXPECT_TRUE(list(8, kNow + 1s).is_not_older_than(held));
  EXPECT_TRUE(list(8, kNow).is_not_older_than(held));
  EXPECT_TRUE(list(7, kNow).is_not_older_than(held));
  EXPECT_FALSE(list(6, kNow + 1s).is_not_older_than(held));
  EXPECT_FALSE(list(8, kNow - 1s).is_not_older_than(held));
  // The numbers are compared as numbers, whatever their lengths are.
  EXPECT_TRUE(list(0x1'0000'0000, kNow).is_not_older_than(list(0xff, kNow)));
  EXPECT_FALSE(list(0xff, kNow).is_not_older_than(list(0x100, kNow)));
}

// RFC 5280 5.2.3 allows 20 octets.
TEST(CrlNumberOf, AList_MayBeLong) {
  const auto ca = make_ca();
  const auto number = CrlNumber::from_octets(Bytes(20, 0x7f));
  const auto list = [&](const CrlNumber& of) {
    return make_crl(ca, {.this_update = kNow, .next_update = kNow + 24h, .number = of});
  };
  EXPECT_EQ(list(number).number(), number);
  EXPECT_EQ(list(CrlNumber(UINT64_MAX)).number(), CrlNumber(UINT64_MAX));
  EXPECT_EQ(list(0).number(), CrlNumber(0));
  EXPECT_TRUE(list(number.next()).is_not_older_than(list(number)));
  EXPECT_FALSE(list(UINT64_MAX).is_not_older_than(list(number)));
}

TEST(CrlReplaces, ListOfTheFuture_NeedsAHigherNumberAndAllEntries) {
  const auto ca = make_ca();
  const std::vector revoked{make_leaf(ca, "CN=a").certificate, make_leaf(ca, "CN=b").certificate};
  const auto list = [&](std::uint64_t number, WallTime from, std::size_t entries) {
    return make_crl(ca, {.revoked = std::span(revoked).first(entries),
                         .this_update = from,
                         .next_update = kNow + 500 * 24h,
                         .number = number});
  };
  const auto future = list(7, kNow + 300 * 24h, 1);
  EXPECT_TRUE(list(8, kNow, 1).may_replace_at(future, kNow));
  EXPECT_TRUE(list(8, kNow, 2).may_replace_at(future, kNow));
  EXPECT_FALSE(list(8, kNow, 0).may_replace_at(future, kNow))
      << "the certificate that it leaves out would count again";
  EXPECT_FALSE(list(7, kNow, 2).may_replace_at(future, kNow));
  EXPECT_FALSE(list(6, kNow, 2).may_replace_at(future, kNow));
  EXPECT_FALSE(list(8, kNow, 2).may_replace_at(future, kNow + 300 * 24h)) << "its time has come";
  EXPECT_FALSE(
      make_crl(make_ca("CN=Other"), {.this_update = kNow, .next_update = kNow + 24h, .number = 8})
          .may_replace_at(list(7, kNow + 300 * 24h, 0), kNow));
  EXPECT_TRUE(list(7, kNow + 300 * 24h, 0).may_replace_at(list(7, kNow, 1), kNow))
      << "as is_not_older_than";
}

TEST(CrlCheck, TwoKeysOfOneName_AreBothNamed) {
  const auto old = make_ca(), ca = make_ca();
  const auto checked = make_crl(old, kMonth).check(ca.certificate(), kNow);
  EXPECT_CODE(checked, crl_signature_invalid);
  const auto& details = checked.error().details();
  EXPECT_NE(details.found.find(make_crl(old, kMonth).authority_key_id()), std::string::npos);
  EXPECT_NE(details.expected.find(make_crl(ca, kMonth).authority_key_id()), std::string::npos);
  EXPECT_NE(details.note.find("rotated"), std::string::npos);
  EXPECT_NE(details.hint.find("start it again"), std::string::npos);
}

TEST(CrlSupersedes, ListOfAnotherIssuer_SupersedesNothing) {
  EXPECT_TRUE(make_crl(make_ca(), kMonth).is_named_after(make_ca().certificate()));
  EXPECT_FALSE(make_crl(make_ca(), kMonth).is_named_after(make_ca("CN=Other").certificate()));
  const auto held = make_crl(make_ca(), kMonth);
  auto later = kMonth;
  later.number = 8;
  EXPECT_FALSE(make_crl(make_ca("CN=Other"), later).is_not_older_than(held));
}

Crl pkits(const std::string& name) {
  return Crl::all_from(data_file("nist-pkits/crls/" + name + ".crl"))->front();
}

// OpenSSL 3.0.19 treats a delta list as a complete one. If a newer delta list does not repeat an
// entry of the complete list, it accepts the revoked certificate.
TEST(DeltaCrl, DeltaList_IsRefusedWhereListsAreRead) {
  const auto ca = make_ca();
  const auto leaf = make_leaf(ca);
  const std::array revoked = {leaf.certificate};
  auto content = kMonth;
  content.revoked = revoked;
  const auto complete = make_crl(ca, content);
  content = {.this_update = kNow + 1h, .next_update = kNow + 30 * 24h, .number = 8};
  const auto delta = test::delta_pem(make_crl(ca, content), ca, kMonth.number.as_uint64().value());
  ASSERT_NE(delta, "");
  const auto alone = Crl::all_from(as_bytes(delta));
  EXPECT_CODE(alone, crl_is_delta);
  EXPECT_EQ(alone.error().details().expected, "a complete list of CN=Test CA,O=Example");
  for (const auto& file : {complete.pem() + delta, delta + complete.pem()})
    EXPECT_CODE(Crl::all_from(as_bytes(file)), crl_is_delta);
  EXPECT_CODE(Crl::all_from(data_file("nist-pkits/crls/deltaCRLCA1deltaCRL.crl")), crl_is_delta);
  EXPECT_CODE(make_verifier({ca.certificate()}, *Crl::all_from(as_bytes(complete.pem())))
                  .verify(leaf.certificate, kNow + 2h),
              certificate_revoked);
}

// Such a list is complete in itself. The delta lists that it names only bring it up to date sooner.
TEST(DeltaCrl, ACompleteListThatNamesDeltaLists_IsRead) {
  const auto crls = Crl::all_from(data_file("nist-pkits/crls/deltaCRLCA1CRL.crl"));
  ASSERT_TRUE(crls) << crls.error().to_sentence();
  EXPECT_GE(X509_CRL_get_ext_by_NID(impl_of(crls->front()).crl.get(), NID_freshest_crl, -1), 0);
}

TEST(CrlSupersedes, ListAboutOtherCertificates_SupersedesNothing) {
  const auto some = pkits("onlySomeReasonsCA1compromiseCRL");
  const auto others = pkits("onlySomeReasonsCA1otherreasonsCRL");
  ASSERT_EQ(some.issuer(), others.issuer());
  EXPECT_TRUE(some.is_not_older_than(some));
  EXPECT_FALSE(some.is_not_older_than(others));
  EXPECT_FALSE(others.is_not_older_than(some));
}

}  // namespace
}  // namespace ddssec::pki
