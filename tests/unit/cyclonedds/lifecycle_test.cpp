// Two participants live a whole life through the C ABI: ours, stock, and every mix of both.
#include <algorithm>
#include <filesystem>
#include <malloc.h>

#include <gtest/gtest.h>

#include "base/code.hpp"
#include "tests/support/cyclone_driver.hpp"

#if defined(__SANITIZE_ADDRESS__)
// The sanitizer's bookkeeping of thread-local storage fails with this many libraries, and the leak
// check then ends in a fault of its own.
extern "C" __attribute__((visibility("default"))) const char* __asan_default_options() {
  return "intercept_tls_get_addr=0";
}
// The stock cryptography leaks the keys of a participant that shared a remote one. Our plugins
// never allocate with the host's functions.
extern "C" __attribute__((visibility("default"))) const char* __lsan_default_suppressions() {
  return "leak:libddsc.so\n";
}
#endif

namespace ddssec::driver {
namespace {

const std::string kPki = DDSSEC_DRIVER_PKI;
const std::string kOurs = DDSSEC_PLUGIN_DIR "/libddssec_";
const std::string kStock = DDSSEC_STOCK_PLUGIN_DIR "/libdds_security_";

// Returns the libraries of a mix. Bit 0: authentication is stock, bit 1: access control, bit 2:
// cryptography.
Paths mix(int stock) {
  return {(stock & 1) ? kStock + "auth.so" : kOurs + "authentication.so",
          (stock & 2) ? kStock + "ac.so" : kOurs + "access_control.so",
          (stock & 4) ? kStock + "crypto.so" : kOurs + "cryptography.so"};
}
constexpr int kAllDdssec = 0;
constexpr int kAllStock = 7;

std::string mix_name(int stock) {
  std::string name;
  for (const int bit : {0, 1, 2}) name += (stock >> bit & 1) ? "S" : "O";
  return name;
}

Octets numbered(std::size_t size) {
  Octets octets(size);
  for (std::size_t i = 0; i < size; ++i) octets[i] = static_cast<std::uint8_t>(i * 7);
  return octets;
}

// Returns a little-endian DATA submessage.
Octets submessage(std::size_t size) {
  auto octets = numbered(size);
  octets[0] = 0x15;
  octets[1] = 0x05;
  octets[2] = static_cast<std::uint8_t>((size - 4) & 0xff);
  octets[3] = static_cast<std::uint8_t>((size - 4) >> 8);
  return octets;
}

// Returns an RTPS message with one DATA.
Octets message(const std::uint8_t* prefix, std::size_t size) {
  constexpr std::uint8_t kBegin[] = {'R', 'T', 'P', 'S', 2, 1, 1, 0x10};
  const auto body = submessage(size);
  Octets octets(20 + size);
  std::copy_n(kBegin, 8, octets.begin());
  std::copy_n(prefix, 12, octets.begin() + 8);
  std::copy_n(body.begin(), size, octets.begin() + 20);
  return octets;
}

bool is_refused(auto&& call) {
  try {
    call();
    return false;
  } catch (const Refused&) {
    return true;
  }
}

void send_payload(const Link& link, std::size_t size) {
  const auto plain = numbered(size);
  const auto encoded = link.sender.encode_payload(plain);
  EXPECT_EQ(link.receiver.decode_payload(encoded).octets(), plain);
  auto forged = encoded.octets();
  forged[forged.size() / 2] ^= 1;
  EXPECT_TRUE(is_refused([&] { link.receiver.decode_payload(view(forged)); }));
}

void send_submessage(const Link& link, std::size_t size) {
  const auto plain = submessage(size);
  const auto encoded = link.sender.encode_submessage(plain);
  EXPECT_EQ(encoded._length % 4, 0u);
  EXPECT_EQ(link.receiver.decode_submessage(encoded).octets(), plain);
  auto forged = encoded.octets();
  forged[forged.size() / 2] ^= 1;
  EXPECT_TRUE(is_refused([&] { link.receiver.decode_submessage(view(forged)); }));
}

void send_message(const Link& link, const Participant& from, std::size_t size) {
  const auto plain = message(from.guid.prefix, size);
  auto encoded = link.sender.encode_message(plain);
  auto forged = encoded.octets();
  to_machine_order(encoded);
  const auto decoded = link.receiver.decode_message(encoded).octets();
  // INFO_SRC follows the header, and then the original submessages.
  ASSERT_EQ(decoded.size(), plain.size() + 24);
  EXPECT_EQ(decoded[20], 0x0c);
  EXPECT_TRUE(std::equal(plain.begin() + 20, plain.end(), decoded.begin() + 44));
  forged[forged.size() / 2] ^= 1;
  auto forged_view = view(forged);
  to_machine_order(forged_view);
  EXPECT_TRUE(is_refused([&] { link.receiver.decode_message(forged_view); }));
}

void live(int mix_a, int mix_b, const std::string& governance) {
  SCOPED_TRACE(mix_name(mix_a) + " with " + mix_name(mix_b) + ", " + governance);
  Domain domain_a(mix(mix_a)), domain_b(mix(mix_b));
  Participant a(domain_a, kPki, "a", governance), b(domain_b, kPki, "b", governance);
  const Link link(a, b, "Square");
  if (link.writer_attributes.is_payload_protected) send_payload(link, 64);
  if (link.writer_attributes.is_submessage_protected) send_submessage(link, 128);
  if (a.attributes.is_rtps_protected) send_message(link, a, 256);
}

class Life : public testing::TestWithParam<int> {};

TEST_P(Life, StockOnTheOtherSide_TalksBothWays) {
  if (!std::filesystem::exists(kStock + "auth.so")) FAIL() << "no stock plugins in " << kStock;
  live(GetParam(), kAllStock, "encrypt");
  live(kAllStock, GetParam(), "encrypt");
}

TEST_P(Life, OursOnTheOtherSide_TalksBothWays) {
  live(GetParam(), kAllDdssec, "origin");
  live(kAllDdssec, GetParam(), "sign");
}

INSTANTIATE_TEST_SUITE_P(Mixes, Life, testing::Range(0, 8),
                         [](const auto& info) { return mix_name(info.param); });

TEST(OurLife, EveryGovernance_TalksBothWays) {
  for (const auto* governance : {"none", "sign", "encrypt", "origin", "origin_sign"})
    live(kAllDdssec, kAllDdssec, governance);
}

// Two local participants of one domain, and a remote one that talks to both. Cyclone's core has one
// identity and one cryptography handle for the remote, whichever local participant met it.
struct TwoLocals {
  explicit TwoLocals(int stock, const std::string& governance)
      : domain(mix(stock)),
        first(std::make_unique<Participant>(domain, kPki, "a", governance, 1)),
        second(std::make_unique<Participant>(domain, kPki, "a", governance, 2)),
        remote(far, kPki, "b", governance),
        of_first(std::make_unique<Link>(*first, remote, "Square")),
        of_second(std::make_unique<Link>(*second, remote, "Square")) {}

  ~TwoLocals() {
    if (of_first && of_second) keep_remote(*of_first);
  }

  static void talk(const Link& link, const Participant& from) {
    send_payload(link, 64);
    send_submessage(link, 128);
    send_message(link, from, 256);
  }
  // The core returns the handles of the remote only once, so this link does not return them.
  static void keep_remote(Link& link) {
    link.a_of_b.identity = link.a_of_b.crypto = DDS_SECURITY_HANDLE_NIL;
  }
  // Ends a local participant as the core does.
  static void leave(std::unique_ptr<Link>& link, std::unique_ptr<Participant>& local) {
    keep_remote(*link);
    link.reset();
    local.reset();
  }

  Domain domain, far{mix(kAllDdssec)};
  std::unique_ptr<Participant> first, second;
  Participant remote;
  std::unique_ptr<Link> of_first, of_second;
};

class TwoLocalsLife : public testing::TestWithParam<int> {};
// Stock access control frees shared data of its local participants with the first one that goes, so
// only mixes without it are tested.
class OneOfTwoLeaves : public TwoLocalsLife {};

TEST_P(TwoLocalsLife, OneRemoteForTheHost_IsTwoForThePlugin) {
  TwoLocals two(GetParam(), "encrypt");
  const auto& first = two.of_first->a_of_b;
  const auto& second = two.of_second->a_of_b;
  EXPECT_EQ(first.identity, second.identity);
  EXPECT_EQ(first.crypto, second.crypto);
  EXPECT_NE(first.secret, second.secret);
  EXPECT_NE(first.handshake, second.handshake);
  for (int i = 0; i < 2; ++i) {
    TwoLocals::talk(*two.of_first, *two.first);
    TwoLocals::talk(*two.of_second, *two.second);
  }
  // The second participant cannot read what the remote encrypted for the first one.
  const auto encoded = two.of_first->sender.encode_payload(numbered(64));
  EXPECT_TRUE(is_refused([&] { two.of_second->receiver.decode_payload(encoded); }));
}

TEST_P(OneOfTwoLeaves, OtherLocal_GoesOn) {
  for (const bool second_leaves : {false, true}) {
    TwoLocals two(GetParam(), "encrypt");
    auto& leaving = second_leaves ? two.of_second : two.of_first;
    auto& staying = second_leaves ? two.of_first : two.of_second;
    auto& local = second_leaves ? two.first : two.second;
    TwoLocals::leave(leaving, second_leaves ? two.second : two.first);
    TwoLocals::talk(*staying, *local);
    // The remote may authenticate again under the handle that the host has. (Stock authentication
    // sends its old request again.)
    if ((GetParam() & 1) == 0) {
      Peer again, at_remote;
      authenticate(*local, two.remote, again, at_remote);
      EXPECT_EQ(again.identity, staying->a_of_b.identity);
      TwoLocals::talk(*staying, *local);
    }
    // A third local participant may meet the remote, too.
    Participant third(two.domain, kPki, "a", "encrypt", 3);
    Link of_third(third, two.remote, "Square");
    EXPECT_EQ(of_third.a_of_b.identity, staying->a_of_b.identity);
    TwoLocals::talk(of_third, third);
    TwoLocals::keep_remote(of_third);
  }
}

INSTANTIATE_TEST_SUITE_P(Mixes, TwoLocalsLife, testing::Values(kAllDdssec, 1, 4, kAllStock),
                         [](const auto& info) { return mix_name(info.param); });
INSTANTIATE_TEST_SUITE_P(Mixes, OneOfTwoLeaves, testing::Values(kAllDdssec, 1, 4),
                         [](const auto& info) { return mix_name(info.param); });

TEST(OurLife, TheRemote_IsReturnedOnceForAllAndIsThenUnknownToAll) {
  TwoLocals two(kAllDdssec, "encrypt");
  auto& auth = two.domain.authentication();
  const auto identity = two.of_first->a_of_b.identity;
  TwoLocals::leave(two.of_first, two.first);
  EXPECT_EQ(auth.return_identity_handle(&auth, identity, nullptr), 1);
  EXPECT_EQ(auth.return_identity_handle(&auth, identity, nullptr), 0);
  Token message;
  DDS_Security_HandshakeHandle handshake = 0;
  const auto data = view(two.second->data);
  EXPECT_EQ(auth.begin_handshake_request(&auth, &handshake, &message, two.second->identity,
                                         identity, &data, nullptr),
            DDS_SECURITY_VALIDATION_FAILED);
  Peer again, at_remote;
  authenticate(*two.second, two.remote, again, at_remote);
  EXPECT_NE(again.identity, identity);
  two.of_second->a_of_b.identity = again.identity;
}

TEST(OurLife, EndOfOneDomain_LeavesTheOtherWorking) {
  Domain first(mix(kAllDdssec));
  Participant a(first, kPki, "a", "encrypt");
  {
    Domain second(mix(kAllDdssec));
    const Participant b(second, kPki, "b", "encrypt");
  }
  Domain third(mix(kAllDdssec));
  Participant b(third, kPki, "b", "encrypt");
  const Link link(a, b, "Square");
  send_payload(link, 8);
}

// Cyclone unloads the plugins with the last secured participant. (Under the address sanitizer
// mallinfo2 counts nothing, and the leak check takes its place.)
TEST(OurLife, OneAfterAnother_TakesNoMoreMemory) {
  live(kAllDdssec, kAllDdssec, "encrypt");
  const auto before = mallinfo2().uordblks;
  for (int i = 0; i < 5; ++i) live(kAllDdssec, kAllDdssec, "encrypt");
  EXPECT_LT(mallinfo2().uordblks, before + 100'000) << "it was 240,000 a life";
}

TEST(OurLife, AListener_MayStayUntilTheEnd) {
  static const dds_security_authentication_listener identities{
      [](auto*, auto) -> DDS_Security_boolean { return 1; }, nullptr};
  static const dds_security_access_control_listener permissions{
      [](auto*, auto) -> DDS_Security_boolean { return 1; }};
  Domain domain(mix(kAllDdssec));
  auto& auth = domain.authentication();
  auto& access = domain.access_control();
  EXPECT_EQ(auth.set_listener(&auth, &identities, nullptr), 1);
  EXPECT_EQ(access.set_listener(&access, &permissions, nullptr), 1);
  EXPECT_EQ(access.set_listener(&access, nullptr, nullptr), 1);
  const Participant a(domain, kPki, "a", "encrypt");
  // The threads of the plugins end in finalize.
}

TEST(OurLife, ForeignReceiver_IsToldToTryTheNextParticipant) {
  Domain sending(mix(kAllDdssec)), receiving(mix(kAllDdssec));
  const CryptoLink link(sending.cryptography(), receiving.cryptography(), keys_of(4, 0, 0), 2);
  constexpr std::uint8_t kPrefix[] = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12};
  const auto plain = message(kPrefix, 64);
  auto only_first = link.sender;
  only_first.remote_participants.resize(1);
  auto encoded = only_first.encode_message(plain);
  to_machine_order(encoded);
  EXPECT_EQ(link.receivers[0].decode_message(encoded)._length, plain.size() + 24);
  try {
    link.receivers[1].decode_message(encoded);
    FAIL() << "decoded without a MAC";
  } catch (const Refused& refused) {
    EXPECT_EQ(refused.code, 124);
  }
}

// The core drops the permissions of a peer that cryptography refuses. It returns the peer's
// identity.
TEST(OurLife, PeerThatCryptographyRefuses_LeavesNoPermissions) {
  Domain domain_a(mix(kAllDdssec)), domain_b(mix(kAllDdssec));
  Participant a(domain_a, kPki, "a", "encrypt"), b(domain_b, kPki, "b", "encrypt");
  Peer of_b, of_a;
  authenticate(a, b, of_b, of_a);
  auto &auth = domain_a.authentication(), &auth_b = domain_b.authentication();
  auto& access = domain_a.access_control();
  DDS_Security_DataHolder credential{};
  ASSERT_EQ(
      auth.get_authenticated_peer_credential_token(&auth, &credential, of_b.handshake, nullptr), 1);
  const auto permissions = access.validate_remote_permissions(
      &access, &auth, a.identity, of_b.identity, &b.permissions_token, &credential, nullptr);
  auth.return_authenticated_peer_credential_token(&auth, &credential, nullptr);
  auto* factory = domain_a.cryptography().crypto_key_factory;
  EXPECT_EQ(factory->register_matched_remote_participant(factory, a.crypto, of_b.identity,
                                                         permissions, 0, nullptr),
            0);
  DDS_Security_ParticipantBuiltinTopicDataSecure announced{};
  EXPECT_EQ(access.check_remote_participant(&access, permissions, 0, &announced, nullptr), 1);
  EXPECT_EQ(auth.return_identity_handle(&auth, of_b.identity, nullptr), 1);
  Call check("check_remote_participant");
  EXPECT_EQ(access.check_remote_participant(&access, permissions, 0, &announced, check), 0);
  EXPECT_EQ(static_cast<Exception*>(check)->code,
            static_cast<int>(Code::unknown_permissions_handle));
  EXPECT_EQ(auth_b.return_identity_handle(&auth_b, of_a.identity, nullptr), 1);
}

TEST(OurLife, AnIdentityThatIsNotThere_IsExplained) {
  Domain domain(mix(kAllDdssec));
  int code = 0;
  testing::internal::CaptureStderr();
  try {
    const Participant nobody(domain, kPki, "nobody", "encrypt");
  } catch (const Refused& refused) {
    code = refused.code;
  }
  const auto log = testing::internal::GetCapturedStderr();
  EXPECT_EQ(code, static_cast<int>(Code::file_not_found)) << "an identity from nowhere";
  EXPECT_NE(log.find("nobody"), std::string::npos) << log;
}

}  // namespace
}  // namespace ddssec::driver
