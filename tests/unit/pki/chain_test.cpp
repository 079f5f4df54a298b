#include "pki/chain.hpp"

#include <thread>

#include "pki/openssl.hpp"
#include "pki/pki_access.hpp"
#include "pki_fixture.hpp"
#include "tests/support/delta_list.hpp"

namespace ddssec::pki {
namespace {

Credential odd_leaf(const Authority& ca, const CertificateTemplate& content) {
  const auto key = *PrivateKey::generate(KeyKind::ec_p256);
  return {*ca.certify(content, key, test_random()), key};
}

// Returns a copy of `certificate` that is signed again with SHA-1, which our own issuing never
// does.
Certificate with_sha1(const Certificate& certificate, const PrivateKey& key) {
  const X509Ptr x509(X509_dup(impl_of(certificate).x509.get()));
  X509_sign(x509.get(), impl_of(key).pkey.get(), EVP_sha1());
  unsigned char* raw = nullptr;
  const int size = i2d_X509(x509.get(), &raw);
  const OpensslMemoryPtr owner(raw);
  return *Certificate::from_der(BytesView(raw, static_cast<std::size_t>(size)));
}

// Returns the certificate that `openssl x509 -req` makes without an extension file.
Certificate as_version_1(const Certificate& certificate, const PrivateKey& key) {
  const X509Ptr x509(X509_dup(impl_of(certificate).x509.get()));
  while (X509_get_ext_count(x509.get()) > 0) X509_EXTENSION_free(X509_delete_ext(x509.get(), 0));
  X509_set_version(x509.get(), X509_VERSION_1);
  X509_sign(x509.get(), impl_of(key).pkey.get(), EVP_sha256());
  unsigned char* raw = nullptr;
  const int size = i2d_X509(x509.get(), &raw);
  const OpensslMemoryPtr owner(raw);
  return *Certificate::from_der(BytesView(raw, static_cast<std::size_t>(size)));
}

TEST(Chain, Validity_IsJudgedAtEveryCall) {
  const auto ca = make_ca();
  const auto leaf = make_leaf(ca, "CN=short", {}, {kNow, kNow + 10s}).certificate;
  const auto verifier = make_verifier({ca.certificate()});
  EXPECT_TRUE(verifier.verify(leaf, kNow));
  EXPECT_CODE(verifier.verify(leaf, kNow + 11s), certificate_expired);
  EXPECT_CODE(verifier.verify(leaf, kNow - 1s), certificate_not_yet_valid);
  EXPECT_TRUE(verifier.verify(leaf, kNow + 5s));
}

TEST(Chain, Proof_EndsWithTheFirstCertificateOfTheChainThatExpires) {
  const auto ca = make_ca();
  const auto leaf = make_leaf(ca, "CN=short", {}, {kNow, kNow + 10s}).certificate;
  const auto proof = make_verifier({ca.certificate()}).verify(leaf, kNow);
  ASSERT_OK(proof);
  EXPECT_EQ(proof->not_after(), kNow + 10s);
  EXPECT_EQ(proof->first_to_expire(), "CN=short");
}

TEST(Chain, ExpiredCertificate_IsNamedWithItsEnd) {
  const auto ca = make_ca();
  const auto leaf = make_leaf(ca, "CN=short", {}, {kNow, kNow + 10s}).certificate;
  const auto refused = make_verifier({ca.certificate()}).verify(leaf, kNow + 11s);
  ASSERT_FALSE(refused);
  const auto& error = refused.error();
  EXPECT_EQ(error.code(), Code::certificate_expired);
  EXPECT_EQ(error.details().field, "CN=short");
  EXPECT_NE(error.to_sentence().find("2026-11-21T00:00:10Z"), std::string::npos)
      << error.to_sentence();
}

TEST(Chain, Strangers_AreRefused) {
  const auto ca = make_ca("CN=Root");
  const auto other = make_ca("CN=Other");
  const auto twin = make_ca("CN=Root");
  const auto verifier = make_verifier({ca.certificate()});
  EXPECT_CODE(verifier.verify(make_leaf(other).certificate, kNow), issuer_unknown);
  EXPECT_CODE(verifier.verify(other.certificate(), kNow), issuer_unknown);
  EXPECT_CODE(verifier.verify(make_leaf(twin).certificate, kNow), issuer_unknown);
}

TEST(Chain, AnotherCaOfTheSameName_IsToldByItsKey) {
  const auto ca = make_ca("CN=Root");
  const auto twin = make_ca("CN=Root");
  const auto proof = make_verifier({ca.certificate()}).verify(make_leaf(twin).certificate, kNow);
  ASSERT_FALSE(proof);
  EXPECT_EQ(proof.error().code(), Code::issuer_unknown);
  EXPECT_NE(proof.error().details().note.find("has another key"), std::string::npos)
      << proof.error().to_sentence();
}

// A certificate of version 1 has no extension that would name the CA's key.
TEST(Chain, TwoCasOfOneName_AreToldApartByTheSignature) {
  const auto first = make_ca("CN=Root");
  const auto second = make_ca("CN=Root");
  const auto third = make_ca("CN=Root");
  const auto verifier = make_verifier({first.certificate(), second.certificate()});
  for (const auto* ca : {&first, &second}) {
    EXPECT_TRUE(verifier.verify(make_leaf(*ca).certificate, kNow));
    const auto proof = verifier.verify(as_version_1(make_leaf(*ca).certificate, ca->key()), kNow);
    EXPECT_TRUE(proof) << proof.error().to_sentence();
  }
  EXPECT_CODE(verifier.verify(make_leaf(third).certificate, kNow), issuer_unknown);
  EXPECT_CODE(verifier.verify(as_version_1(make_leaf(third).certificate, third.key()), kNow),
              issuer_unknown);
}

TEST(Chain, AForgedSignature_IsRefused) {
  const auto ca = make_ca();
  auto der = to_bytes(make_leaf(ca).certificate.der());
  der.back() ^= 1;
  const auto forged = Certificate::from_der(der);
  ASSERT_TRUE(forged);
  EXPECT_CODE(make_verifier({ca.certificate()}).verify(*forged, kNow),
              certificate_signature_invalid);
}

TEST(Chain, SubordinateCas_VerifyWithAndWithoutTheirRoot) {
  const auto root = make_ca("CN=Root", {}, {kNow - 48h, kNow + 48h});
  const auto sub = *root.subordinate("CN=Sub", {}, kYear, test_random());
  const auto leaf = make_leaf(sub).certificate;
  // Its CA is not in the file, and a CA that a peer sends with its certificate does not count.
  EXPECT_CODE(make_verifier({root.certificate()}).verify(leaf, kNow), issuer_unknown);
  const auto both = make_verifier({root.certificate(), sub.certificate()});
  const auto proof = both.verify(leaf, kNow);
  ASSERT_TRUE(proof) << proof.error().to_sentence();
  EXPECT_EQ(proof->not_after(), kNow + 48h);
  EXPECT_EQ(proof->first_to_expire(), "CN=Root");
  EXPECT_CODE(both.verify(leaf, kNow + 49h), certificate_expired);
  // A subordinate CA that is alone in the file is an anchor.
  const auto alone = make_verifier({sub.certificate()});
  EXPECT_TRUE(alone.verify(leaf, kNow + 49h));
  EXPECT_EQ(alone.verify(leaf, kNow)->not_after(), kYear.not_after);
}

// T2 (docs/attacks.md): a chain whose middle has expired.
TEST(Chain, AnExpiredMiddle_IsRefused) {
  const auto root = make_ca("CN=Root");
  const auto sub = *root.subordinate("CN=Sub", {}, {kNow - 24h, kNow + 1h}, test_random());
  const auto leaf = make_leaf(sub).certificate;
  for (const auto& anchors :
       {std::vector{root.certificate(), sub.certificate()}, std::vector{sub.certificate()}}) {
    const auto verifier = make_verifier(anchors);
    EXPECT_TRUE(verifier.verify(leaf, kNow));
    EXPECT_CODE(verifier.verify(leaf, kNow + 2h), certificate_expired);
  }
}

TEST(Chain, CertificateOfAParticipant_IsNoAnchor) {
  EXPECT_CODE(ChainVerifier::make({make_leaf(make_ca()).certificate}), not_a_ca);
}

TEST(Chain, CertificateOfAParticipant_IssuesNothing) {
  const auto leaf = make_leaf(make_ca());
  EXPECT_CODE(Authority::load(leaf.certificate, leaf.key), not_a_ca);
}

// Decided in docs/decisions: the certificate is a CA because of its place, since it has no
// extensions that could say so.
TEST(Chain, ASelfSignedVersion1Certificate_MayBeAnAnchorAndNothingElse) {
  const auto root = make_ca("CN=Root");
  const auto version_1 = as_version_1(root.certificate(), root.key());
  EXPECT_TRUE(version_1.is_version_1());
  EXPECT_FALSE(version_1.is_ca());
  EXPECT_TRUE(version_1.can_be_anchor());
  const auto leaf = make_leaf(root).certificate;
  EXPECT_TRUE(make_verifier({version_1}).verify(leaf, kNow));
  EXPECT_CODE(make_verifier({version_1}).verify(leaf, kYear.not_after + 24h), certificate_expired);
  EXPECT_CODE(Authority::load(version_1, root.key()), not_a_ca);

  // A certificate of version 1 that another CA signed is no anchor, alone or between a CA and a
  // leaf.
  const auto sub = *root.subordinate("CN=Sub", {}, kYear, test_random());
  const auto middle = as_version_1(sub.certificate(), root.key());
  EXPECT_FALSE(middle.can_be_anchor());
  EXPECT_CODE(ChainVerifier::make({middle}), not_a_ca);
  EXPECT_CODE(ChainVerifier::make({root.certificate(), middle}), not_a_ca);
  // A participant whose certificate has version 1 issues nothing either.
  const auto talker = make_leaf(root);
  const auto participant = as_version_1(talker.certificate, root.key());
  EXPECT_TRUE(make_verifier({version_1}).verify(participant, kNow));
  EXPECT_CODE(ChainVerifier::make({participant}), not_a_ca);
}

TEST(Chain, ChainLongerThanPathLength_IsRefused) {
  const auto root = make_ca("CN=Root");
  const auto sub = *root.subordinate("CN=Sub", {}, kYear, test_random());  // its path length is 0
  const auto deep = *sub.subordinate("CN=Deep", {}, kYear, test_random());
  const auto verifier = make_verifier({root.certificate(), sub.certificate(), deep.certificate()});
  EXPECT_CODE(verifier.verify(make_leaf(deep).certificate, kNow), path_too_long);
}

TEST(Chain, KeyUsage_MustAllowSignatures) {
  const auto ca = make_ca();
  const auto verifier = make_verifier({ca.certificate()});
  const auto with = [&](const std::string& usage) {
    return verifier.verify(
        odd_leaf(ca, {.subject = "CN=x", .validity = kYear, .key_usage = usage}).certificate, kNow);
  };
  EXPECT_TRUE(with(""));
  EXPECT_TRUE(with("digitalSignature,keyEncipherment"));
  EXPECT_CODE(with("keyEncipherment"), key_usage_forbids);
}

TEST(Chain, AnIdentity_MayBeACaItself) {
  const auto ca = make_ca();
  const auto leaf = odd_leaf(
      ca,
      {.subject = "CN=x", .validity = kYear, .is_ca = true, .key_usage = std::string(kCaKeyUsage)});
  EXPECT_TRUE(make_verifier({ca.certificate()}).verify(leaf.certificate, kNow));
}

TEST(Chain, Sha1_CountsOnlyAsAnAnchorsSignatureOnItself) {
  const auto ca = make_ca();
  const auto old_root = with_sha1(ca.certificate(), ca.key());
  const auto leaf = make_leaf(ca);
  EXPECT_TRUE(make_verifier({old_root}).verify(leaf.certificate, kNow));
  const auto weak = with_sha1(leaf.certificate, ca.key());
  EXPECT_CODE(make_verifier({ca.certificate()}).verify(weak, kNow), digest_too_weak);
}

TEST(Chain, UnknownCriticalExtensions_AreRefused) {
  const auto ca = make_ca();
  const X509Ptr x509(X509_dup(impl_of(make_leaf(ca).certificate).x509.get()));
  const Asn1ObjectPtr type(OBJ_txt2obj("1.2.3.4.5", 1));
  const Asn1StringPtr value(ASN1_OCTET_STRING_new());
  const ExtensionPtr extension(X509_EXTENSION_create_by_OBJ(nullptr, type.get(), 1, value.get()));
  X509_add_ext(x509.get(), extension.get(), -1);
  X509_sign(x509.get(), impl_of(ca.key()).pkey.get(), EVP_sha256());
  unsigned char* raw = nullptr;
  const int size = i2d_X509(x509.get(), &raw);
  const OpensslMemoryPtr owner(raw);
  const auto odd = *Certificate::from_der(BytesView(raw, static_cast<std::size_t>(size)));
  EXPECT_CODE(make_verifier({ca.certificate()}).verify(odd, kNow), chain_refused);
}

// T13 (docs/attacks.md): a certificate is revoked while its participant runs.
class RevocationByChain : public testing::Test {
 protected:
  Crl list(const Authority& by, std::vector<Certificate> revoked,
           Validity span = {kNow, kNow + 24h}) {
    return *by.make_crl({revoked, span.not_before, span.not_after});
  }
  Authority ca_ = make_ca("CN=Root");
  Credential good_ = make_leaf(ca_, "CN=good");
  Credential bad_ = make_leaf(ca_, "CN=bad");
};

TEST_F(RevocationByChain, RevokedOnes_AreRefusedAndOthersAreNot) {
  const auto verifier = make_verifier({ca_.certificate()}, {list(ca_, {bad_.certificate})});
  const auto proof = verifier.verify(good_.certificate, kNow + 1s);
  ASSERT_TRUE(proof) << proof.error().to_sentence();
  EXPECT_EQ(proof->crl_next_update(), kNow + 24h);
  EXPECT_CODE(verifier.verify(bad_.certificate, kNow + 1s), certificate_revoked);
  EXPECT_CODE(
      make_verifier({ca_.certificate()}, {list(ca_, {bad_.certificate})}, CrlPolicy::soft_fail)
          .verify(bad_.certificate, kNow + 1s),
      certificate_revoked);
}

TEST_F(RevocationByChain, AMissingOrOldList_FailsHardUnlessToldOtherwise) {
  const auto other = make_ca("CN=Other");
  const auto check = [&](Crl crl, WallTime now, Code code) {
    const auto hard = make_verifier({ca_.certificate()}, {crl}).verify(good_.certificate, now);
    ASSERT_FALSE(hard);
    EXPECT_EQ(hard.error().code(), code) << hard.error().to_sentence();
    const auto soft = make_verifier({ca_.certificate()}, {crl}, CrlPolicy::soft_fail)
                          .verify(good_.certificate, now);
    EXPECT_TRUE(soft) << soft.error().to_sentence();
  };
  check(list(other, {}), kNow + 1s, Code::crl_missing);
  check(list(ca_, {}), kNow + 25h, Code::crl_expired);
  check(list(ca_, {}), kNow - 1s, Code::crl_not_yet_valid);
}

TEST_F(RevocationByChain, ARevokedOne_IsRefusedFromAnOldListToo) {
  const auto verifier =
      make_verifier({ca_.certificate()}, {list(ca_, {bad_.certificate})}, CrlPolicy::soft_fail);
  EXPECT_CODE(verifier.verify(bad_.certificate, kNow + 25h), certificate_revoked);
}

// An attacker may still have the former list. Once the newest list has ended, the former one must
// not count again.
TEST_F(RevocationByChain, AnOlderListBesideTheNewest_NeverCounts) {
  const auto numbered = [&](std::uint64_t number, WallTime from, WallTime until,
                            std::vector<Certificate> revoked) {
    return *ca_.make_crl({std::move(revoked), from, until, number});
  };
  const auto newest = numbered(5, kNow + 1h, kNow + 48h, {bad_.certificate});
  for (const auto& older :
       {numbered(4, kNow, kNow + 24h * 300, {}), numbered(4, kNow + 1h, kNow + 24h * 300, {})}) {
    for (const auto& lists : {std::vector{older, newest}, std::vector{newest, older}}) {
      const auto verifier = make_verifier({ca_.certificate()}, lists);
      EXPECT_CODE(verifier.verify(bad_.certificate, kNow + 2h), certificate_revoked);
      EXPECT_CODE(verifier.verify(bad_.certificate, kNow + 72h), crl_expired);
      EXPECT_TRUE(verifier.verify(good_.certificate, kNow + 2h));
    }
  }
}

// OpenSSL uses only one of them, and which one depends on their order and scope.
TEST_F(RevocationByChain, OneOfSeveralListsInForceThatNamesIt_IsEnough) {
  const auto numbered = [&](std::uint64_t number, std::vector<Certificate> revoked) {
    return *ca_.make_crl({std::move(revoked), kNow, kNow + 24h, number});
  };
  const auto of_user_certificates = [&](const Crl& list) {
    const std::unique_ptr<ISSUING_DIST_POINT, Deleter<ISSUING_DIST_POINT_free>> point(
        ISSUING_DIST_POINT_new());
    point->onlyuser = 1;
    const auto pem =
        test::with_extension(list, ca_, NID_issuing_distribution_point, point.get(), true);
    return Crl::all_from(as_bytes(pem))->front();
  };
  const std::pair<Crl, Crl> pairs[] = {
      {numbered(5, {}), numbered(5, {bad_.certificate})},
      {numbered(9, {}), of_user_certificates(numbered(5, {bad_.certificate}))},
      {of_user_certificates(numbered(9, {})), numbered(5, {bad_.certificate})}};
  for (const auto& [clean, revoking] : pairs) {
    for (const auto& lists : {std::vector{clean, revoking}, std::vector{revoking, clean}}) {
      const auto verifier = make_verifier({ca_.certificate()}, lists);
      EXPECT_CODE(verifier.verify(bad_.certificate, kNow + 1h), certificate_revoked);
      EXPECT_TRUE(verifier.verify(good_.certificate, kNow + 1h));
    }
  }
}

TEST_F(RevocationByChain, AForgedListThatNamesIt_RevokesNothing) {
  const auto twin = make_ca("CN=Root");
  const auto forged = list(twin, {good_.certificate});
  EXPECT_TRUE(make_verifier({ca_.certificate()}, {list(ca_, {}), forged})
                  .verify(good_.certificate, kNow + 1h));
  EXPECT_TRUE(make_verifier({ca_.certificate(), twin.certificate()}, {list(ca_, {}), forged})
                  .verify(good_.certificate, kNow + 1h))
      << "another CA's list";
}

// Otherwise a user who can write to the file could take the list of the CA away.
TEST_F(RevocationByChain, AForgedNewerList_TakesNoListsPlace) {
  const auto twin = make_ca("CN=Root");
  const auto genuine = list(ca_, {bad_.certificate});
  const auto forged = *twin.make_crl({{}, kNow + 1h, kNow + 48h, 1'000'000});
  EXPECT_CODE(
      make_verifier({ca_.certificate()}, {genuine, forged}).verify(bad_.certificate, kNow + 2h),
      certificate_revoked);
}

// Returns `list` without the identifier of the key that signed it.
Crl without_key_id(const Crl& list, const Authority& by) {
  const CrlPtr crl(X509_CRL_dup(impl_of(list).crl.get()));
  X509_EXTENSION_free(X509_CRL_delete_ext(
      crl.get(), X509_CRL_get_ext_by_NID(crl.get(), NID_authority_key_identifier, -1)));
  X509_CRL_sign(crl.get(), impl_of(by.key()).pkey.get(), EVP_sha256());
  const BioPtr bio(BIO_new(BIO_s_mem()));
  i2d_X509_CRL_bio(bio.get(), crl.get());
  return Crl::all_from(bio_octets(bio))->front();
}

// A CA that rolled over has two keys, and a list belongs to the key that signed it.
TEST_F(RevocationByChain, TwoCasOfOneName_HaveAListEach) {
  const auto twin = make_ca("CN=Root");
  const auto good = make_leaf(twin, "CN=good"), bad = make_leaf(twin, "CN=bad");
  for (const auto& [mine, others] : {std::pair{1u, 9u}, {9u, 1u}})
    for (const bool has_key_id : {true, false}) {
      const auto later = kNow + std::chrono::hours(others);
      auto own = *ca_.make_crl({{&bad_.certificate, 1}, kNow + 5h, kNow + 48h, mine});
      auto other = *twin.make_crl({{&bad.certificate, 1}, later, kNow + 48h, others});
      if (!has_key_id) own = without_key_id(own, ca_), other = without_key_id(other, twin);
      const auto verifier = make_verifier({ca_.certificate(), twin.certificate()}, {own, other});
      for (const auto& one : {good_.certificate, good.certificate})
        EXPECT_TRUE(verifier.verify(one, kNow + 10h)) << mine << has_key_id;
      for (const auto& one : {bad_.certificate, bad.certificate})
        EXPECT_CODE(verifier.verify(one, kNow + 10h), certificate_revoked);
    }
}

TEST_F(RevocationByChain, AListOfTheOtherCaOfTheName_IsNone) {
  const auto twin = make_ca("CN=Root");
  const auto verifier = make_verifier({ca_.certificate(), twin.certificate()}, {list(twin, {})});
  EXPECT_CODE(verifier.verify(good_.certificate, kNow + 1s), crl_missing);
}

TEST_F(RevocationByChain, AForgedList_IsRefusedUnderEitherPolicy) {
  const auto twin = make_ca("CN=Root");
  auto der = list(ca_, {});
  // The other CA has the same name and another key. The key identifier, which would show this
  // early, is removed.
  const CrlPtr forged(X509_CRL_dup(impl_of(list(twin, {})).crl.get()));
  X509_EXTENSION_free(X509_CRL_delete_ext(
      forged.get(), X509_CRL_get_ext_by_NID(forged.get(), NID_authority_key_identifier, -1)));
  X509_CRL_sign(forged.get(), impl_of(twin.key()).pkey.get(), EVP_sha256());
  const BioPtr bio(BIO_new(BIO_s_mem()));
  i2d_X509_CRL_bio(bio.get(), forged.get());
  const auto crls = *Crl::all_from(bio_octets(bio));
  for (const auto policy : {CrlPolicy::hard_fail, CrlPolicy::soft_fail})
    EXPECT_CODE(
        make_verifier({ca_.certificate()}, crls, policy).verify(good_.certificate, kNow + 1s),
        crl_signature_invalid);
}

TEST_F(RevocationByChain, Cas_AreLookedUpWhereTheirIssuerHasAList) {
  const auto sub = *ca_.subordinate("CN=Sub", {}, kYear, test_random());
  const auto leaf = make_leaf(sub).certificate;
  const std::vector anchors = {ca_.certificate(), sub.certificate()};
  EXPECT_TRUE(make_verifier(anchors, {list(sub, {})}).verify(leaf, kNow + 1s));
  EXPECT_TRUE(make_verifier(anchors, {list(sub, {}), list(ca_, {})}).verify(leaf, kNow + 1s));
  EXPECT_CODE(make_verifier(anchors, {list(sub, {}), list(ca_, {sub.certificate()})})
                  .verify(leaf, kNow + 1s),
              certificate_revoked);
  EXPECT_CODE(make_verifier(anchors, {list(ca_, {})}).verify(leaf, kNow + 1s), crl_missing);
}

TEST(MayBeRevoked, CertificateAndCaOnNoList_AreNotRevoked) {
  const auto root = make_ca("CN=Root");
  const auto sub = *root.subordinate("CN=Sub", {}, kYear, test_random());
  const auto good = make_leaf(sub, "CN=good").certificate,
             bad = make_leaf(sub, "CN=bad").certificate;
  const auto verifier_with = [&](std::vector<Crl> lists) {
    return make_verifier({root.certificate(), sub.certificate()}, std::move(lists));
  };
  const auto list = [](const Authority& ca, const std::vector<Certificate>& revoked) {
    return *ca.make_crl({.revoked = revoked, .this_update = kNow, .next_update = kNow + 24h});
  };
  const auto none = verifier_with({});
  EXPECT_FALSE(none.is_on_any_list(bad));
  const auto of_sub = verifier_with({list(root, {}), list(sub, {bad})});
  EXPECT_FALSE(of_sub.is_on_any_list(good));
  EXPECT_TRUE(of_sub.is_on_any_list(bad));
  // The revocation of a CA concerns every certificate below it.
  const auto of_root = verifier_with({list(root, {sub.certificate()}), list(sub, {})});
  EXPECT_TRUE(of_root.is_on_any_list(good));
  EXPECT_CODE(of_root.verify(good, kNow), certificate_revoked);
}

TEST_F(RevocationByChain, Files_HoldSeveralListsAmongOtherBlocks) {
  const auto sub = *ca_.subordinate("CN=Sub", {}, kYear, test_random());
  const auto text = ca_.certificate().pem() + list(ca_, {}).pem() + list(sub, {}).pem();
  const auto crls = Crl::all_from(as_bytes(text));
  ASSERT_TRUE(crls);
  ASSERT_EQ(crls->size(), 2u);
  EXPECT_EQ((*crls)[0].issuer(), "CN=Root");
  EXPECT_EQ((*crls)[1].this_update(), kNow);
  EXPECT_EQ((*crls)[1].next_update(), kNow + 24h);
  EXPECT_TRUE(Crl::all_from(as_bytes(ca_.certificate().pem()))->empty());
  std::string many;
  for (std::size_t i = 0; i <= kMaxCrlsInFile; ++i) many += list(ca_, {}).pem();
  EXPECT_CODE(Crl::all_from(as_bytes(many)), crl_too_large);
  EXPECT_CODE(Crl::all_from(Bytes(17 * 1024 * 1024)), crl_too_large);
  EXPECT_CODE(Crl::all_from(Bytes{0x30, 0x00}), crl_malformed);
  EXPECT_CODE(Crl::all_from(as_bytes("-----BEGIN X509 CRL-----\nMIIB!\n")), crl_malformed);
  const std::string pyca = "pyca-cryptography-vectors/x509/";
  EXPECT_CODE(Crl::all_from(data_file(pyca + "crl_invalid_time.der")), crl_malformed);
  EXPECT_FALSE(Crl::all_from(data_file(pyca + "crl_no_next_update.pem"))->front().next_update());
}

TEST(ChainCache, ManyEntriesAndThreads_StayBounded) {
  const auto ca = make_ca();
  const auto leaf = make_leaf(ca).certificate;
  const auto verifier = make_verifier({ca.certificate()});
  std::vector<std::thread> threads;
  for (int i = 0; i < 4; ++i)
    threads.emplace_back([&] {
      for (int n = 0; n < 200; ++n) EXPECT_TRUE(verifier.verify(leaf, kNow + n * 1s));
    });
  for (auto& thread : threads) thread.join();
  const auto key = *PrivateKey::generate(KeyKind::ec_p256);
  for (std::size_t i = 0; i < ChainVerifier::kMaxRemembered + 10; ++i) {
    const auto many =
        ca.certify({.subject = "CN=" + std::to_string(i), .validity = kYear}, key, test_random());
    ASSERT_TRUE(verifier.verify(*many, kNow));
  }
  EXPECT_TRUE(verifier.verify(leaf, kNow));
}

TEST(Requests, JunkAndForgedOnes_AreRefused) {
  const auto ca = make_ca();
  EXPECT_CODE(ca.sign_request(as_bytes("junk"), kYear, test_random()), request_invalid);
  EXPECT_CODE(ca.sign_request(Bytes(100000), kYear, test_random()), request_invalid);
  const auto pem = *make_request(*PrivateKey::generate(KeyKind::ec_p256), "CN=abcdefgh");
  const BioPtr bio = bio_over(as_bytes(pem));
  const RequestPtr request(PEM_read_bio_X509_REQ(bio.get(), nullptr, nullptr, nullptr));
  const auto other = *PrivateKey::generate(KeyKind::ec_p256);
  X509_REQ_sign(request.get(), impl_of(other).pkey.get(), EVP_sha256());
  const BioPtr out(BIO_new(BIO_s_mem()));
  PEM_write_bio_X509_REQ(out.get(), request.get());
  EXPECT_CODE(ca.sign_request(bio_octets(out), kYear, test_random()), request_invalid);
}

}  // namespace
}  // namespace ddssec::pki
