// CPU time of whole handshakes, both sides, against the raw operations that no handshake can avoid:
// twice sign, verify, certificate check, key generation and derivation. In turns, medians, since
// the machine's clock drifts. `bench_authentication [rounds]`.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <vector>

#include "pki/chain.hpp"
#include "tests/unit/authentication/fixture.hpp"

namespace ddssec::authentication {
namespace {

double cpu_us() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) * 1e6 + static_cast<double>(now.tv_nsec) / 1e3;
}

template <class F>
double time_us(F&& f) {
  const double start = cpu_us();
  f();
  return cpu_us() - start;
}

double median(std::vector<double> values) {
  std::ranges::sort(values);
  return values[values.size() / 2];
}

void expect(bool ok) {
  if (!ok) std::abort();
}

/// The raw operations once, with a new verifier so that nothing is remembered.
double raw_us(const Identity& identity) {
  const Bytes message(300, 1);
  auto verifier = pki::ChainVerifier::make({test_ca().certificate()}).value();
  const auto peer = pki::EphemeralKey::generate(pki::KeyAgreementKind::ecdh_p256).value();
  const Bytes peer_octets = peer.public_octets();
  const auto pem = identity.certificate.pem();
  return time_us([&] {
    const auto signature = pki::sign(identity.key, message).value();
    expect(pki::verify(identity.certificate, message, signature).has_value());
    const auto certificate = pki::Certificate::from_pem(as_bytes(pem)).value();
    expect(verifier.verify(certificate, kNow).has_value());
    const auto key = pki::EphemeralKey::generate(pki::KeyAgreementKind::ecdh_p256).value();
    expect(key.derive(peer_octets).has_value());
  });
}

/// Both sides of a handshake. New engines judge certificates for the first time, old ones again.
double handshake_us(Two& two) {
  return time_us([&] {
    const auto req = two.request();
    const auto rep = two.reply(*req->message);
    const auto fin = two.at_low(req->handle, *rep->message);
    expect(two.at_high(rep->handle, *fin->message).has_value());
  });
}

struct Result {
  std::vector<double> raw, first, again;
};

void run(const char* name, KeySpec spec, int rounds) {
  const auto alice = make_identity(test_ca(), "CN=alice", spec);
  const auto bob = make_identity(test_ca(), "CN=bob", spec, kYear, 1);
  const Token credential{"DDS:Access:PermissionsCredential",
                         {{"dds.perm.cert", std::string(23'000, 'x')}}};
  Result result;
  // Two processes; what they keep of each other's identity is returned after each round.
  Pairing home(alice, bob);
  for (auto* p : {&home.a, &home.b})
    expect(
        (*p->engine)->set_permissions_credential_and_token(p->handle, credential, {}).has_value());
  handshake_us(home.two);
  for (int round = 0; round < rounds; ++round) {
    // A participant never seen before: its certificate is new to ours, ours is new to it.
    const auto name = "CN=peer " + std::to_string(round);
    const auto stranger = make_identity(test_ca(), name, spec, kYear, 1);
    Engine far(3);
    Participant peer(far, stranger, 3);
    expect(far->set_permissions_credential_and_token(peer.handle, credential, {}).has_value());
    Two two(home.a, peer);
    result.raw.push_back(raw_us(alice) + raw_us(stranger));
    result.first.push_back(handshake_us(two));
    result.again.push_back(handshake_us(home.two));
  }
  const double raw = median(result.raw), first = median(result.first), again = median(result.again);
  std::printf(
      "%-10s raw %7.0f us   handshake %7.0f us (%.2fx, %.0f/s)   peer known %7.0f us (%.2fx, "
      "%.0f/s)\n",
      name, raw, first, first / raw, 1e6 / first, again, again / raw, 1e6 / again);
}

}  // namespace
}  // namespace ddssec::authentication

int main(int count, char** arguments) {
  using namespace ddssec::authentication;
  const int rounds = count > 1 ? std::atoi(arguments[1]) : 200;
  std::printf("CPU of both sides per handshake, 23 kB permissions, median of %d rounds\n", rounds);
  run("EC P-256", {KeyKind::ec_p256}, rounds);
  run("RSA-2048", {KeyKind::rsa, 2048}, rounds);
  run("EC P-384", {KeyKind::ec_p384}, rounds);
}
