// What was judged before is not judged again. A program of its own: it stands before OpenSSL's
// functions and counts the calls.
#include <bit>
#include <dlfcn.h>

#include <openssl/cms.h>
#include <openssl/evp.h>
#include <openssl/x509_vfy.h>

#include "tests/unit/rtps_security/attacker.hpp"

namespace {

struct Work {
  int signatures = 0, chains = 0, documents = 0, certificates = 0;
  bool operator==(const Work&) const = default;
};
Work work;

/// OpenSSL's own of this name.
template <class F>
F original(F, const char* name) {
  return std::bit_cast<F>(dlsym(RTLD_NEXT, name));
}

void PrintTo(const Work& done, std::ostream* out) {
  *out << done.signatures << " signatures, " << done.chains << " chains, " << done.documents
       << " documents verified, " << done.certificates << " certificates parsed";
}

}  // namespace

extern "C" {
int EVP_PKEY_verify(EVP_PKEY_CTX* context, const unsigned char* signature, size_t signature_size,
                    const unsigned char* digest, size_t digest_size) {
  static const auto real = original(&EVP_PKEY_verify, "EVP_PKEY_verify");
  ++work.signatures;
  return real(context, signature, signature_size, digest, digest_size);
}
int X509_verify_cert(X509_STORE_CTX* context) {
  static const auto real = original(&X509_verify_cert, "X509_verify_cert");
  ++work.chains;
  return real(context);
}
int CMS_verify(CMS_ContentInfo* cms, STACK_OF(X509) * certificates, X509_STORE* store, BIO* content,
               BIO* out, unsigned int flags) {
  static const auto real = original(&CMS_verify, "CMS_verify");
  ++work.documents;
  return real(cms, certificates, store, content, out, flags);
}
X509* d2i_X509(X509** out, const unsigned char** octets, long size) {
  static const auto real = original(&d2i_X509, "d2i_X509");
  ++work.certificates;
  return real(out, octets, size);
}
}

namespace ddssec::rtps {
namespace {

using namespace testing;

// Every datagram comes twice, which is no work either.
TEST(RepeatedWork, WhoIsKnownAlreadyIsAuthenticatedByItsSignatureAlone) {
  const auto rules = everything(ProtectionKind::encrypt);
  const auto of_bob = properties_of("CN=bob,O=Example", rules);
  Node alice(1, properties_of("CN=alice,O=Example", rules));
  auto bob = std::make_unique<Node>(2, of_bob);
  World world{{&alice, bob.get()}};
  world.filter = [](const Node&, Bytes datagram) { return std::vector<Bytes>(2, datagram); };
  const auto both_know = [&] { return alice.knows(*bob) && bob->knows(alice); };

  work = {};
  ASSERT_TRUE(world.run_until(both_know, 500));
  EXPECT_EQ(work, (Work{2, 2, 2, 0})) << "each side its peer's; all certificates are in use here";

  bob = std::make_unique<Node>(3, of_bob);
  world.nodes = {&alice, bob.get()};
  work = {};
  ASSERT_TRUE(world.run_until(both_know, 500));
  EXPECT_EQ(work, (Work{2, 1, 1, 0})) << "only the new process has something to learn";
}

}  // namespace
}  // namespace ddssec::rtps
