// What an identity trusts: shared stores, and certificates that are judged only once.
#include "plugins/authentication/trust_store.hpp"

#include "tests/unit/authentication/ocsp_responses.hpp"

namespace ddssec::authentication {
namespace {

struct TrustStoreTest : testing::Test {
  std::shared_ptr<const TrustStore> open(const pki::Authority& ca,
                                         std::vector<pki::Crl> lists = {}) {
    return stores.open({ca.certificate()}, std::move(lists)).value();
  }

  TrustStores stores{pki::CrlPolicy::hard_fail};
  const pki::Certificate alice = make_identity(test_ca(), "CN=alice,O=Example").certificate;
};

TEST_F(TrustStoreTest, SameCasAndLists_ShareAStoreWhileItIsUsed) {
  const auto first = open(test_ca());
  EXPECT_EQ(open(test_ca()), first);
  EXPECT_EQ(first.use_count(), 1) << "the table keeps no store alive";
}

TEST_F(TrustStoreTest, OtherCaOrList_IsAnotherStore) {
  const auto store = open(test_ca());
  EXPECT_NE(open(make_ca("CN=Other CA")), store);
  const auto list =
      test_ca().make_crl({.this_update = kYear.not_before, .next_update = kYear.not_after});
  ASSERT_OK(list);
  EXPECT_NE(open(test_ca(), {*list}), store);
}

TEST_F(TrustStoreTest, Remembered_IsNotParsedAgain) {
  const auto store = open(test_ca());
  EXPECT_FALSE(store->certificate(bytes("alice")));
  store->remember(bytes("alice"), alice);
  const auto known = store->certificate(bytes("alice"));
  ASSERT_OK(known);
  EXPECT_EQ(known->pem(), alice.pem());
}

TEST_F(TrustStoreTest, MoreThanAreRemembered_TakeABoundedPlace) {
  const auto store = open(test_ca());
  for (std::size_t i = 0; i <= TrustStore::kMaxRemembered; ++i)
    store->remember(bytes(std::to_string(i)), alice);
  EXPECT_FALSE(store->certificate(bytes("0"))) << "the first ones are forgotten";
  EXPECT_TRUE(store->certificate(bytes(std::to_string(TrustStore::kMaxRemembered))));
}

TEST_F(TrustStoreTest, OcspResponse_CountsForItsCertificateUntilItEnds) {
  const auto store = open(test_ca());
  const auto bob = make_identity(test_ca(), "CN=bob,O=Example", {}, kYear, 1).certificate;
  const auto response = response_about(alice);
  EXPECT_TRUE(store->ocsp(response, alice, kNow));
  EXPECT_TRUE(store->ocsp(response, alice, kNow + 1h)) << "again";
  EXPECT_FALSE(store->ocsp(response, bob, kNow)) << "it is about another certificate";
  EXPECT_FALSE(store->ocsp(response, alice, kNow + 48h)) << "it has ended";
}

}  // namespace
}  // namespace ddssec::authentication
