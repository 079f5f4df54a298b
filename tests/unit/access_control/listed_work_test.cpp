// How many permissions of a renewal list one poll verifies. This is a program of its own, because
// it replaces OpenSSL's function and counts the calls.
#include <bit>
#include <dlfcn.h>

#include <openssl/cms.h>

#include "plugins/access_control/own_documents.hpp"
#include "tests/unit/access_control/listed_peers.hpp"

namespace {

int verified = 0;  // documents whose signatures were verified

}  // namespace

extern "C" int CMS_verify(CMS_ContentInfo* cms, STACK_OF(X509) * certificates, X509_STORE* store,
                          BIO* content, BIO* out, unsigned int flags) {
  using Function =
      int (*)(CMS_ContentInfo*, STACK_OF(X509)*, X509_STORE*, BIO*, BIO*, unsigned int);
  static const auto real = std::bit_cast<Function>(dlsym(RTLD_NEXT, "CMS_verify"));
  ++verified;
  return real(cms, certificates, store, content, out, flags);
}

namespace ddssec::access_control {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

constexpr int kMax = OwnDocuments::kMaxVerifiedInAPoll;

class LongList : public ListedPeers {
 protected:
  std::vector<std::string> of_others(int count) const {
    std::vector<std::string> out;
    for (int i = 0; i < count; ++i)
      out.push_back(document({"t"}, 0s, 12h, ("CN=peer " + std::to_string(i)).c_str()));
    return out;
  }
  int documents_of_poll() {
    verified = 0;
    EXPECT_THAT(poll(1s), IsEmpty());
    return verified;
  }
};

TEST_F(LongList, FirstTime_IsVerifiedOverSeveralPolls) {
  put(of_others(4 * kMax));
  for (int i = 0; i < 4; ++i) EXPECT_EQ(documents_of_poll(), kMax);
  EXPECT_EQ(documents_of_poll(), 0);
}

TEST_F(LongList, OneEntryChanges_OnlyThatOneIsVerified) {
  auto entries = of_others(3 * kMax);
  put(entries);
  for (int i = 0; i < 3; ++i) poll(1s);
  entries[5] = document({"t"}, 0s, 13h, "CN=peer 5");
  put(entries);
  EXPECT_EQ(documents_of_poll(), 1);
}

TEST_F(LongList, EntryThatWaits_KeepsItsPeer) {
  auto entries = of_others(3 * kMax);
  entries.push_back(document({"t"}, 0s, 12h));
  put(entries);
  EXPECT_THAT(poll(21s), IsEmpty());
  EXPECT_THAT(codes(), ElementsAre(Code::peer_permissions_listed));
}

TEST_F(LongList, EntryThatWaitsAndIsOfAnotherCa_KeepsNoPeer) {
  auto entries = of_others(3 * kMax);
  auto out = grant(kListener, {publish_rule(true, {"t"})});
  out.validity = {kNow, kNow + 12h};
  entries.push_back(signed_by(authorities().other_ca,
                              governance::to_xml(governance::Permissions{.grants = {out}})));
  put(entries);
  EXPECT_THAT(poll(21s), ElementsAre(peer_));
}

}  // namespace
}  // namespace ddssec::access_control
