// What was judged before is not judged again. This is a program of its own, because it replaces
// OpenSSL's functions and counts the calls.
#include <bit>
#include <dlfcn.h>

#include <openssl/cms.h>
#include <openssl/evp.h>
#include <openssl/x509_vfy.h>

#include "tests/unit/rtps_security/attacker.hpp"
#include "tests/unit/rtps_security/document_files.hpp"

namespace {

struct Work {
  int signatures = 0, chains = 0, documents = 0, certificates = 0;
  bool operator==(const Work&) const = default;
};
Work work;

// Returns OpenSSL's own function of this name.
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

// Every datagram arrives twice, which must not cause work either.
TEST(RepeatedWork, KnownPeer_IsAuthenticatedByItsSignatureAlone) {
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

// Alice's clock runs 10,000 times as fast as bob's. For bob, she is a peer that renews her
// certificate and permissions a thousand times a second.
struct Hasty {
  explicit Hasty(const Rules& rules)
      : rules(rules),
        files(documents({"*"})),
        alice(1, files.in(documents({"*"}))),
        bob(2, properties_of("CN=bob,O=Example", rules)) {
    pair.nodes = {&alice, &bob};
    alice->create_writer(square(default_writer_qos()), alice.listener, pair.now).value();
    auto qos = default_reader_qos();
    qos.reliability.kind = ReliabilityKind::reliable;
    bob->create_reader(square(qos), bob.listener, pair.now).value();
    EXPECT_TRUE(pair.run_until([&] { return bob.listener.matched == 1; }));
    of_alice = of_bob = pair.now;
  }

  spi::PropertyList documents(std::vector<std::string> topics) const {
    return properties_of("CN=alice,O=Example", rules, std::move(topics));
  }
  static void deliver(Node& from, Node& to, MonotonicTime now) {
    for (const auto& [port, octets] : std::exchange(from.post.sent, {}))
      if (port == to.port) to->receive(octets, now, *Locator::parse("127.0.0.1", 0));
  }
  void step(std::chrono::nanoseconds alices, std::chrono::nanoseconds bobs) {
    of_alice += alices;
    alice->tick(of_alice);
    const auto before = work;
    deliver(alice, bob, of_bob);
    of_bob += bobs;
    bob->tick(of_bob);
    by_bob.documents += work.documents - before.documents;
    by_bob.signatures += work.signatures - before.signatures;
    deliver(bob, alice, of_alice);
  }
  // Alice adopts the documents, and offers them to bob.
  void renew(std::vector<std::string> topics) {
    files.put(documents(std::move(topics)));
    alice.clock.advance(2s);
    for (int i = 0; i < 4; ++i) step(2500ms, 250us);
  }

  const Rules rules;
  DocumentFiles files;
  Node alice, bob;
  World pair;
  MonotonicTime of_alice, of_bob;
  Work by_bob;
};

TEST(RepeatedWork, AThousandRenewalsInASecond_FewAreJudgedAndTheLastCounts) {
  constexpr int kRenewals = 1000;
  Hasty two(everything(ProtectionKind::encrypt));
  two.bob.events.all.clear();
  const auto begin = two.of_bob;
  for (int i = 1; i < kRenewals; ++i) two.renew({"*", "Topic" + std::to_string(i)});
  two.renew({"Circle"});
  EXPECT_EQ(two.of_bob - begin, 1s);
  EXPECT_EQ(two.alice.events.count(Code::permissions_renewed), kRenewals);
  // Six renewals are judged at once. Each has one document, two signatures of the session's offer,
  // and a chain.
  EXPECT_EQ(two.by_bob.documents, 6);
  EXPECT_LE(two.by_bob.signatures, 12);
  EXPECT_EQ(two.bob.events.count(Code::peer_permissions_renewed), 6);
  EXPECT_TRUE(two.bob->is_authenticated(two.alice->prefix()));
  EXPECT_EQ(two.bob.listener.matched, 1) << two.bob.events.text();

  for (int i = 0; i < 2000 && two.bob.listener.matched == 1; ++i) {
    two.alice.clock.advance(10ms);
    two.step(10ms, 10ms);
  }
  EXPECT_EQ(two.bob.listener.matched, 0) << "the last permissions do not allow the topic";
  EXPECT_TRUE(two.bob->is_authenticated(two.alice->prefix()));
}

}  // namespace
}  // namespace ddssec::rtps
