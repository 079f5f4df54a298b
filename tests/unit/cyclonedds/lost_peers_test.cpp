// A session that one side has lost, from the adapter of one side to the adapter of the other.
#include <atomic>
#include <chrono>
#include <netinet/in.h>
#include <sys/socket.h>
#include <thread>
#include <unistd.h>

#include <gtest/gtest.h>

#include "plugins/cyclonedds/authentication_adapter.hpp"
#include "plugins/cyclonedds/own_announcements.hpp"
#include "plugins/cyclonedds/session_resets.hpp"
#include "plugins/spi/session_facts.hpp"
#include "tests/unit/cyclonedds/revocation_listeners.hpp"
#include "tests/unit/cyclonedds/support.hpp"

// The peer whose keys never came.
static std::atomic<DDS_Security_IdentityHandle> stranded_peer{0};
// How often authentication asked whether a peer reset its session.
static std::atomic<int> questions{0};
// How often renewed permissions took a right from an endpoint of the local participant.
static std::atomic<std::uint64_t> losses{0};
// Its renewed permissions; nullptr: they were not renewed.
static std::atomic<const char*> renewed{nullptr};

namespace ddssec::cyclonedds {
namespace {

using namespace std::chrono_literals;
using testing::Return;

constexpr GuidPrefix kLocal{{1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1}};
constexpr GuidPrefix kRemote{{2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2}};
std::atomic<DDS_Security_IdentityHandle> revoked{0};
// How long the adapter waits for a new session with a peer that is back.
constexpr auto kPatience = 200ms;
// How long a handshake goes on although the host dropped the peer in between.
constexpr auto kKeptHandshake = 500ms;

// Waits until the adapter has looked that often for resets of a peer.
void wait_for_looks(int count) {
  const auto until = questions.load() + count;
  for (int i = 0; i < 1000 && questions < until; ++i) std::this_thread::sleep_for(10ms);
  EXPECT_GE(questions, until);
}
// A turn of its thread lies between two looks, unless a peer is reset.
void wait_for_two_looks() { wait_for_looks(2); }
// It looks 21 times, for a second, in the turn in which a peer is reset.
constexpr int kMoreThanATurn = 25;

// The socket on which a peer receives discovery.
struct Socket {
  Socket() {
    own.sin_family = AF_INET;
    own.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t length = sizeof own;
    EXPECT_EQ(::bind(fd, reinterpret_cast<sockaddr*>(&own), length), 0);
    EXPECT_EQ(::getsockname(fd, reinterpret_cast<sockaddr*>(&own), &length), 0);
    const timeval patience{10, 0};
    ::setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  }
  ~Socket() { ::close(fd); }
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;

  spi::UdpAddress address() const {
    return {.port = ntohs(own.sin_port),
            .address = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 127, 0, 0, 1}};
  }
  Bytes receive() const {
    Bytes out(2048);
    const auto size = ::recv(fd, out.data(), out.size(), 0);
    out.resize(size < 0 ? 0 : static_cast<std::size_t>(size));
    return out;
  }

  const int fd = ::socket(AF_INET, SOCK_DGRAM, 0);
  sockaddr_in own{};
};

struct SessionResetTest : testing::Test {
  std::shared_ptr<spi::SharedSecret> secret() const {
    auto made = std::make_shared<spi::SharedSecret>();
    made->secret = *spi::SharedSecretOctets::copy_of(Bytes(32, 9));
    made->peer_prefix = kRemote;
    made->peer_ciphers = peer_ciphers;
    made->peer_addresses = {peer.address()};
    return made;
  }
  void SetUp() override {
    ON_CALL(plugin, validate_local_identity)
        .WillByDefault(
            Return(spi::Authentication::LocalIdentity{{5}, Guid{kLocal, kEntityIdParticipant}}));
    ON_CALL(plugin, validate_remote_identity)
        .WillByDefault(Return(spi::Authentication::RemoteIdentity{
            {40}, spi::ValidationResult::pending_handshake_request, {}}));
    ON_CALL(plugin, begin_handshake_request)
        .WillByDefault(Return(spi::Authentication::HandshakeStep{
            {60}, spi::ValidationResult::pending_handshake_message, {}}));
    ON_CALL(plugin, process_handshake)
        .WillByDefault(Return(
            spi::Authentication::HandshakeStep{{60}, spi::ValidationResult::ok_final_message, {}}));
    ON_CALL(plugin, shared_secret).WillByDefault(Return(secret()));
    ON_CALL(plugin, next_expiry).WillByDefault(Return(std::nullopt));
    ON_CALL(plugin, return_identity_handle).WillByDefault(Return(Status{}));
    DDS_Security_Qos qos{};
    DDS_Security_GUID_t guid{};
    DDS_Security_IdentityHandle handle = 0;
    EXPECT_EQ(c->validate_local_identity(c, &handle, &guid, 0, &qos, &guid, nullptr),
              DDS_SECURITY_VALIDATION_OK);
    revoked = 0;
    losses = 0;
    EXPECT_EQ(c->set_listener(c, &kNotesRevokedIdentity<revoked>, nullptr), 1);
  }
  void TearDown() override { EXPECT_EQ(c->set_listener(c, nullptr, nullptr), 1); }

  DDS_Security_IdentityHandle meet() {
    const auto guid = to_c(Guid{kRemote, kEntityIdParticipant});
    DDS_Security_DataHolder token{}, request{};
    EXPECT_TRUE(copy_token(sample_token(), token));
    DDS_Security_IdentityHandle remote = 0;
    c->validate_remote_identity(c, &remote, &request, nullptr, 5, &token, &guid, nullptr);
    free_token(token);
    free_token(request);
    return remote;
  }
  DDS_Security_IdentityHandle authenticate() {
    const auto remote = meet();
    HostOctets data{own_data};
    DDS_Security_HandshakeHandle handshake = 0;
    DDS_Security_DataHolder message{}, reply{}, last{};
    EXPECT_TRUE(copy_token(sample_token(), reply));
    c->begin_handshake_request(c, &handshake, &message, 5, remote, &data.sequence, nullptr);
    EXPECT_EQ(c->process_handshake(c, &last, &reply, handshake, nullptr),
              DDS_SECURITY_VALIDATION_OK_FINAL_MESSAGE);
    EXPECT_NE(c->get_shared_secret(c, handshake, nullptr), DDS_SECURITY_HANDLE_NIL);
    for (auto* token : {&message, &reply, &last}) free_token(*token);
    return remote;
  }

  spi::CipherMask peer_ciphers = spi::kAllCiphers;
  Bytes own_data{1, 2, 3, 4};  ///< what the host shows to handshakes
  Socket peer;
  Harness<AuthenticationAdapter, MockAuthentication, spi::Authentication> harness{
      AuthenticationAdapter::Pace{
          .step = 20ms, .patience = kPatience, .kept_handshake = kKeptHandshake}};
  dds_security_authentication* c = &harness.adapter;
  MockAuthentication& plugin = *harness.plugin;
};

TEST_F(SessionResetTest, DroppedPeerMetAgain_GetsIt) {
  const auto remote = authenticate();
  EXPECT_EQ(c->return_identity_handle(c, remote, nullptr), 1);
  meet();
  EXPECT_EQ(to_hex(peer.receive()),
            to_hex(spi::write_reset(kLocal, spi::derive_reset_token(*secret(), kLocal))));
}

TEST_F(SessionResetTest, PeerWithOtherPlugins_DoesNotGetIt) {
  peer_ciphers = spi::kStandardCiphers;
  ON_CALL(plugin, shared_secret).WillByDefault(Return(secret()));
  const timeval patience{0, 500000};
  ::setsockopt(peer.fd, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  const auto remote = authenticate();
  EXPECT_EQ(c->return_identity_handle(c, remote, nullptr), 1);
  meet();
  EXPECT_TRUE(peer.receive().empty());
}

TEST_F(SessionResetTest, ReceivedReset_MakesTheHostBeginAnew) {
  const auto remote = authenticate();
  auto& resets = SessionResets::of_process();
  resets.expect({{70}, {1}}, {remote}, spi::derive_reset_token(*secret(), kRemote));
  // When the second question is asked, the first one has had no effect.
  wait_for_two_looks();
  EXPECT_EQ(revoked, 0);
  const auto message = spi::write_reset(kRemote, spi::derive_reset_token(*secret(), kRemote));
  EXPECT_TRUE(resets.note_reset(*spi::read_reset(message)));
  for (int i = 0; i < 1000 && revoked == 0; ++i) std::this_thread::sleep_for(10ms);
  EXPECT_EQ(revoked, remote);
  EXPECT_EQ(std::ranges::count(harness.events, Code::session_reset_by_peer,
                               [](const auto& event) { return event.error.code(); }),
            1);
  resets.forget({70});
}

// The peer resets its session, and the host drops the peer.
struct EndedByPeer : SessionResetTest {
  void SetUp() override {
    SessionResetTest::SetUp();
    const auto remote = authenticate();
    auto& resets = SessionResets::of_process();
    resets.expect({{70}, {1}}, {remote}, spi::derive_reset_token(*secret(), kRemote));
    const auto message = spi::write_reset(kRemote, spi::derive_reset_token(*secret(), kRemote));
    EXPECT_TRUE(resets.note_reset(*spi::read_reset(message)));
    for (int i = 0; i < 1000 && revoked == 0; ++i) std::this_thread::sleep_for(10ms);
    EXPECT_EQ(revoked, remote);
    resets.forget({70});
    EXPECT_EQ(c->return_identity_handle(c, remote, nullptr), 1);
  }
  auto reports() {
    // No event is raised while they are counted.
    EXPECT_EQ(c->set_listener(c, nullptr, nullptr), 1);
    return std::ranges::count(harness.events, Code::session_not_resumed,
                              [](const auto& event) { return event.error.code(); });
  }
};

TEST_F(EndedByPeer, AndMetAgainWithoutANewSession_IsReportedOnce) {
  meet();
  std::this_thread::sleep_for(3 * kPatience);
  wait_for_looks(kMoreThanATurn);
  EXPECT_EQ(reports(), 1);
}

TEST_F(EndedByPeer, AndResumed_IsNoReport) {
  authenticate();
  std::this_thread::sleep_for(3 * kPatience);
  wait_for_looks(kMoreThanATurn);
  EXPECT_EQ(reports(), 0);
}

TEST_F(EndedByPeer, AndGone_IsNoReport) {
  std::this_thread::sleep_for(1s + 3 * kPatience);
  EXPECT_EQ(reports(), 0);
}

TEST_F(SessionResetTest, KeysThatNeverCame_CauseOneToo) {
  const auto remote = authenticate();
  stranded_peer = remote;
  for (int i = 0; i < 1000 && revoked == 0; ++i) std::this_thread::sleep_for(10ms);
  EXPECT_EQ(revoked, remote);
  EXPECT_EQ(std::ranges::count(harness.events, Code::session_begun_again,
                               [](const auto& event) { return event.error.code(); }),
            1);
}

// ---- rights that renewed permissions no longer give

struct LostRights : SessionResetTest {
  void SetUp() override {
    renewed = nullptr;
    SessionResetTest::SetUp();
  }
  void TearDown() override {
    SessionResetTest::TearDown();
    renewed = nullptr;
  }
  // Handshakes present this from now on.
  void present(std::string_view permissions) {
    spi::Token credential;
    spi::add_session_facts(credential, {.presented_permissions = sha256(as_bytes(permissions))});
    ON_CALL(plugin, authenticated_peer_credential_token).WillByDefault(Return(credential));
  }
  static void wait_until_revoked() {
    for (int i = 0; i < 500 && revoked == 0; ++i) std::this_thread::sleep_for(10ms);
  }
};

TEST_F(LostRights, EndTheSessionOnce_AndResetThePeerAtOnce) {
  const auto remote = authenticate();
  wait_for_two_looks();
  EXPECT_EQ(revoked, 0);
  losses = 1;
  wait_until_revoked();
  EXPECT_EQ(revoked, remote);
  EXPECT_EQ(c->return_identity_handle(c, remote, nullptr), 1);
  EXPECT_EQ(to_hex(peer.receive()),
            to_hex(spi::write_reset(kLocal, spi::derive_reset_token(*secret(), kLocal))));
  revoked = 0;
  authenticate();
  wait_for_two_looks();
  EXPECT_EQ(revoked, 0);
}

// A session that has ended with a peer that the host does not discover yet. Both wait for the
// other's announcement.
struct NotDiscovered : LostRights {
  void SetUp() override {
    LostRights::SetUp();
    own_data = {0, 0x50, 0, 16};  // PID_PARTICIPANT_GUID
    const auto guid = Guid{kLocal, kEntityIdParticipant}.octets();
    own_data.insert(own_data.end(), guid.begin(), guid.end());
    const Bytes token_and_sentinel{0x10, 1, 0, 4, 0, 0, 0, 0, 0, 1, 0, 0};
    own_data.insert(own_data.end(), token_and_sentinel.begin(), token_and_sentinel.end());
    const auto remote = authenticate();
    wait_for_two_looks();
    losses = 1;
    wait_until_revoked();
    EXPECT_EQ(c->return_identity_handle(c, remote, nullptr), 1);
  }
  // True if it comes within that time.
  bool announcement_comes_within(std::chrono::milliseconds time) const {
    const auto announcement = write_announcement(kLocal, own_data);
    EXPECT_TRUE(announcement);
    const timeval patience{0, 100'000};
    ::setsockopt(peer.fd, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    const auto end = std::chrono::steady_clock::now() + time;
    while (std::chrono::steady_clock::now() < end)
      if (peer.receive() == announcement) return true;
    return false;
  }
};

TEST_F(NotDiscovered, AndNotMetAgain_GetsOurAnnouncement) {
  EXPECT_TRUE(announcement_comes_within(10s));
}

TEST_F(NotDiscovered, AndMetAgain_GetsNone) {
  meet();
  EXPECT_FALSE(announcement_comes_within(1800ms)) << "twice OwnAnnouncements::kAfterReset";
}

// The peer may end the session at the same time, because its own permissions were renewed.
TEST_F(LostRights, SessionThatBeganSinceAndPresentedTheRenewedPermissions_GoesOn) {
  const auto remote = authenticate();
  renewed = "renewed";
  losses = 1;
  EXPECT_EQ(c->return_identity_handle(c, remote, nullptr), 1);  // the peer has ended it
  meet();
  wait_for_two_looks();
  revoked = 0;
  present("renewed");
  authenticate();
  wait_until_revoked();
  EXPECT_EQ(revoked, 0);
}

TEST_F(LostRights, SessionThatPresentedTheRenewedPermissionsBefore_GoesOn) {
  renewed = "renewed";
  meet();
  wait_for_two_looks();
  present("renewed");
  authenticate();
  losses = 1;
  wait_until_revoked();
  EXPECT_EQ(revoked, 0);
}

TEST_F(LostRights, SessionThatPresentedOtherPermissions_Ends) {
  renewed = "renewed";
  present("former");
  const auto remote = authenticate();
  losses = 1;
  wait_until_revoked();
  EXPECT_EQ(revoked, remote);
}

TEST_F(LostRights, RenewedPermissionsThatCannotBePresented_EndTheSession) {
  ON_CALL(plugin, set_permissions_credential_and_token).WillByDefault([](auto&&...) {
    return Status(fail(Code::token_field_length));
  });
  present("renewed");
  const auto remote = authenticate();
  renewed = "renewed";
  losses = 1;
  wait_until_revoked();
  EXPECT_EQ(revoked, remote);
}

// While the peer still finishes its half of the handshake, the end of ours would leave it waiting.
TEST_F(LostRights, SessionWhoseHandshakeWasUnderWay_EndsToo) {
  const auto remote = meet();
  losses = 1;
  wait_for_two_looks();
  EXPECT_EQ(revoked, 0);
  authenticate();
  const auto began = std::chrono::steady_clock::now();
  wait_until_revoked();
  EXPECT_EQ(revoked, remote);
  EXPECT_GE(std::chrono::steady_clock::now() - began, 1900ms);
}

// An attacker can hold back the peer's answer, and the host repeats what it sent.
TEST_F(LostRights, SessionWhoseHandshakeTookLong_EndsToo) {
  const auto remote = meet();
  losses = 1;
  std::this_thread::sleep_for(2 * kKeptHandshake);
  wait_for_two_looks();
  authenticate();
  wait_until_revoked();
  EXPECT_EQ(revoked, remote);
}

// Its handshake goes on where it was.
TEST_F(LostRights, SessionWithAPeerThatIsDiscoveredAgainSoon_EndsToo) {
  renewed = "renewed";
  present("former");
  const auto first = meet();
  wait_for_two_looks();
  EXPECT_EQ(c->return_identity_handle(c, first, nullptr), 1);
  losses = 1;
  std::this_thread::sleep_for(100ms);
  const auto remote = authenticate();
  wait_until_revoked();
  EXPECT_EQ(revoked, remote);
}

// A further document of the same rights, a moment later.
TEST_F(LostRights, SessionThatPresentedPermissionsSinceTheChange_GoesOn) {
  renewed = "renewed";
  meet();
  wait_for_two_looks();
  losses = 1;
  wait_for_two_looks();
  present("renewed");
  authenticate();
  renewed = "renewed again";
  wait_until_revoked();
  EXPECT_EQ(revoked, 0);
}

TEST_F(LostRights, PeerThatWasGoneSince_IsNotEnded) {
  const auto remote = meet();
  losses = 1;
  wait_for_two_looks();
  EXPECT_EQ(c->return_identity_handle(c, remote, nullptr), 1);
  std::this_thread::sleep_for(2 * kKeptHandshake);
  authenticate();
  wait_until_revoked();
  EXPECT_EQ(revoked, 0);
}

// Such a peer would keep its side of the session, and ignore each new handshake.
TEST_F(LostRights, SessionWithAPeerOnOtherPlugins_GoesOn) {
  peer_ciphers = spi::kStandardCiphers;
  ON_CALL(plugin, shared_secret).WillByDefault(Return(secret()));
  authenticate();
  losses = 1;
  wait_for_two_looks();
  EXPECT_EQ(revoked, 0);
}

}  // namespace
}  // namespace ddssec::cyclonedds

DDSSEC_EXPORT std::uint64_t ddssec_rights_changed(DDS_Security_IdentityHandle local) {
  return local == 5 ? losses.load() : 0;
}
DDSSEC_EXPORT std::uint64_t ddssec_renewed_permissions(DDS_Security_IdentityHandle local,
                                                       std::uint64_t known,
                                                       ddssec::cyclonedds::TakePermissions* take,
                                                       void* context) {
  const char* const text = renewed;
  if (local != 5 || text == nullptr) return known;
  const std::string_view octets(text);
  const std::uint64_t times = octets.ends_with("again") ? 2 : 1;
  if (known < times)
    take(context, reinterpret_cast<const DDS_Security_octet*>(octets.data()), octets.size());
  return times;
}
DDSSEC_EXPORT bool ddssec_take_stranded_keys(DDS_Security_IdentityHandle remote) {
  return stranded_peer.compare_exchange_strong(remote, 0);
}
// In a process with our cryptography, that library exports this function, and authentication looks
// it up.
DDSSEC_EXPORT ddssec::cyclonedds::SessionReset ddssec_take_session_reset(
    DDS_Security_IdentityHandle remote) {
  using namespace ddssec::cyclonedds;
  ++questions;
  return SessionResets::of_process().take({remote}, PeersWithKeys::of_process());
}
