// How many certificates of a renewal list one poll verifies. This is a program of its own, because
// it replaces OpenSSL's function and counts the calls.
#include <bit>
#include <dlfcn.h>

#include <openssl/x509_vfy.h>

#include "plugins/authentication/listed_renewals.hpp"
#include "tests/unit/authentication/listed.hpp"

namespace {

int chains = 0;  // chains that were verified

}  // namespace

extern "C" int X509_verify_cert(X509_STORE_CTX* context) {
  static const auto real =
      std::bit_cast<int (*)(X509_STORE_CTX*)>(dlsym(RTLD_NEXT, "X509_verify_cert"));
  ++chains;
  return real(context);
}

namespace ddssec::authentication::listed {
namespace {

using testing::IsEmpty;

constexpr int kMax = ListedRenewals::kMaxVerifiedInAPoll;

const pki::Authority& other_ca() {
  static const auto ca = make_ca("CN=Other CA,O=Example");
  return ca;
}

class LongList : public Listed {
 protected:
  static std::vector<pki::Certificate> of_others(int count, const pki::Authority& ca = test_ca()) {
    std::vector<pki::Certificate> out;
    for (int i = 0; i < count; ++i)
      out.push_back(bob_with(kNext, 2, ca, "CN=peer " + std::to_string(i)).certificate);
    return out;
  }
  // Returns the number of chains that a poll verifies for the list.
  int chains_of_poll() {
    chains = 0;
    EXPECT_THAT(poll(1s), IsEmpty());
    return chains - idle_;
  }
  void SetUp() override {
    Listed::SetUp();
    poll(1s);
    idle_ = chains_of_poll();
    events().clear();
  }
  int idle_ = 0;  // chains of a poll without a list
};

TEST_F(LongList, FirstTime_IsVerifiedOverSeveralPolls) {
  put(list_of(of_others(5 * kMax)));
  for (int i = 0; i < 5; ++i) {
    EXPECT_THAT(codes(), IsEmpty()) << "before all entries are verified";
    EXPECT_EQ(chains_of_poll(), kMax);
  }
  EXPECT_THAT(codes(), ElementsAre(Code::renewal_list_taken));
  EXPECT_EQ(chains_of_poll(), 0);
  EXPECT_THAT(codes(), IsEmpty());
}

TEST_F(LongList, OneEntryChanges_OnlyThatOneIsVerified) {
  auto entries = of_others(3 * kMax);
  put(list_of(entries));
  for (int i = 0; i < 3; ++i) poll(1s);
  entries[5] = bob_with(kNext, 3, test_ca(), "CN=peer 5").certificate;
  put(list_of(entries));
  EXPECT_EQ(chains_of_poll(), 1);
}

TEST_F(LongList, EntryThatWaits_KeepsItsPeer) {
  auto entries = of_others(3 * kMax);
  entries.push_back(renewed_bob());
  put(list_of(entries));
  EXPECT_THAT(poll(21s), IsEmpty());
  EXPECT_THAT(codes(), ElementsAre(Code::peer_renewal_listed));
}

TEST_F(LongList, EntryThatWaitsAndIsOfAnotherCa_KeepsNoPeer) {
  auto entries = of_others(3 * kMax);
  entries.push_back(bob_with(kNext, 1, other_ca()).certificate);
  put(list_of(entries));
  EXPECT_THAT(poll(21s), ElementsAre(bob_at_alice()));
}

TEST_F(LongList, NoEntryCounts_TheFormerListStaysAndOneEventSaysSo) {
  put(list_of({renewed_bob()}));
  poll(1s);
  EXPECT_THAT(codes(), ElementsAre(Code::renewal_list_taken));
  put(list_of(of_others(2 * kMax + 1, other_ca())));
  for (int i = 0; i < 9; ++i) poll(1s);
  EXPECT_THAT(codes(), ElementsAre(Code::renewal_list_refused));
  EXPECT_THAT(poll(15s), IsEmpty());
  EXPECT_THAT(codes(), ElementsAre(Code::peer_renewal_listed));
}

}  // namespace
}  // namespace ddssec::authentication::listed
