#include "plugins/cyclonedds/authentication_adapter.hpp"

#include <atomic>
#include <chrono>
#include <stdexcept>
#include <thread>

#include "plugins/spi/process_properties.hpp"
#include "plugins/spi/property_names.hpp"
#include "plugins/spi/session_facts.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/unit/cyclonedds/support.hpp"

// The last peer that authentication reported to access control.
static std::atomic<DDS_Security_IdentityHandle> forgotten_peer{0};

namespace ddssec::cyclonedds {
namespace {

using testing::_;
using testing::Return;

Guid guid_of(std::uint8_t octet) {
  Guid guid;
  guid.prefix.octets.fill(octet);
  guid.entity = kEntityIdParticipant;
  return guid;
}

// A token of the host. It is freed at the end.
struct HostToken : DDS_Security_DataHolder {
  HostToken() : DDS_Security_DataHolder{} {}
  explicit HostToken(const spi::Token& token) { EXPECT_TRUE(copy_token(token, *this)); }
  ~HostToken() { free_token(*this); }
  HostToken(const HostToken&) = delete;
  HostToken& operator=(const HostToken&) = delete;
};

struct AuthenticationAdapterTest : testing::Test {
  Harness<AuthenticationAdapter, MockAuthentication, spi::Authentication> harness;
  dds_security_authentication* c = &harness.adapter;
  MockAuthentication& plugin = *harness.plugin;
  Refusal refusal;
  HostOctets data{{1, 2, 3, 4}};

  std::shared_ptr<spi::SharedSecret> secret() {
    auto made = std::make_shared<spi::SharedSecret>();
    made->secret = *spi::SharedSecretOctets::copy_of(Bytes(32, 9));
    made->challenge1.fill(1);
    made->challenge2.fill(2);
    return made;
  }
};

TEST_F(AuthenticationAdapterTest, Table_IsCompleteAndTheDomainIsInIt) {
  EXPECT_EQ(c->gv, harness.domain());
  const auto* begin = reinterpret_cast<void* const*>(c);
  for (int i = 0; i < 18; ++i) EXPECT_NE(begin[i], nullptr) << i;
}

TEST_F(AuthenticationAdapterTest, LocalIdentity_ReachesThePlugin) {
  std::string name = "n", value = "v";
  DDS_Security_Property_t property{name.data(), value.data(), 1};
  DDS_Security_Qos qos{};
  qos.property.value = {1, 1, &property};
  EXPECT_CALL(plugin, validate_local_identity(7, spi::PropertyList{{"n", "v"}}, guid_of(1)))
      .WillOnce(Return(spi::Authentication::LocalIdentity{{55}, guid_of(2)}));
  DDS_Security_IdentityHandle handle = -1;
  const auto candidate = to_c(guid_of(1));
  DDS_Security_GUID_t adjusted{};
  EXPECT_EQ(c->validate_local_identity(c, &handle, &adjusted, 7, &qos, &candidate, &refusal),
            DDS_SECURITY_VALIDATION_OK);
  EXPECT_EQ(handle, 55);
  EXPECT_EQ(guid_from(adjusted), guid_of(2));
}

// Properties of a participant, from the host and from the file that the process names.
struct PropertiesOfTheHost : AuthenticationAdapterTest {
  ~PropertiesOfTheHost() override { unsetenv(spi::kPropertiesVariable); }

  DDS_Security_ValidationResult_t validate(std::string host_name, std::string host_value,
                                           std::string_view file) {
    setenv(spi::kPropertiesVariable, folder.write("file", file).c_str(), 1);
    return validate(std::move(host_name), std::move(host_value));
  }
  DDS_Security_ValidationResult_t validate(std::string name, std::string value) {
    DDS_Security_Property_t property{name.data(), value.data(), 0};
    DDS_Security_Qos qos{};
    qos.property.value = {1, 1, &property};
    DDS_Security_IdentityHandle handle = -1;
    DDS_Security_GUID_t guid{};
    refusal.clear();
    return c->validate_local_identity(c, &handle, &guid, 7, &qos, &guid, &refusal);
  }
  void expect_plugin_gets(const spi::PropertyList& properties) {
    EXPECT_CALL(plugin, validate_local_identity(7, properties, _))
        .WillOnce(Return(spi::Authentication::LocalIdentity{{55}, guid_of(2)}));
  }

  const test::TemporaryFolder folder;
  const std::string crl{spi::property::kCrl}, password{spi::property::kPassword};
};

// Cyclone's configuration file has no place for properties that Cyclone does not define.
TEST_F(PropertiesOfTheHost, PropertiesThatTheHostDoesNotName_AreAdded) {
  expect_plugin_gets({{crl, "v", false}, {password, "w", false}});
  EXPECT_EQ(validate(crl, "v", crl + " = other\n" + password + " = w\n"),
            DDS_SECURITY_VALIDATION_OK);
  setenv(spi::kPropertiesVariable, (folder.path() + "/none").c_str(), 1);
  EXPECT_EQ(validate(crl, "v"), DDS_SECURITY_VALIDATION_FAILED);
  EXPECT_EQ(refusal.reason(), Code::file_not_found);
}

// Cyclone 0.10.2 passes an empty value for each element that its configuration leaves out. If these
// counted, a revocation list that the file names would be ignored.
TEST_F(PropertiesOfTheHost, EmptyPropertiesOfTheHost_AreReplaced) {
  expect_plugin_gets({{crl, "file:/the/list", false}});
  EXPECT_EQ(validate(crl, "", crl + " = file:/the/list\n"), DDS_SECURITY_VALIDATION_OK);
}

TEST_F(PropertiesOfTheHost, PreSharedKeys_AreRefusedUnderCycloneDds) {
  for (const auto name : {spi::property::kPskPassphrase, spi::property::kPskExtraPassphrases,
                          spi::property::kPskCipher}) {
    EXPECT_EQ(validate(crl, "", std::string(name) + " = data:,1:abcdefgh\n"),
              DDS_SECURITY_VALIDATION_FAILED);
    EXPECT_EQ(refusal.reason(), Code::property_without_effect);
    EXPECT_THAT(harness.events.back().error.to_sentence(), testing::HasSubstr(name));
  }
}

TEST_F(AuthenticationAdapterTest, AFailure_IsFailedNilAndExplained) {
  EXPECT_CALL(plugin, validate_local_identity)
      .WillOnce(Return(fail(Code::file_not_found, {.document = "ca.pem"})));
  DDS_Security_IdentityHandle handle = -1;
  DDS_Security_GUID_t guid{};
  DDS_Security_Qos qos{};
  EXPECT_EQ(c->validate_local_identity(c, &handle, &guid, 0, &qos, &guid, &refusal),
            DDS_SECURITY_VALIDATION_FAILED);
  EXPECT_EQ(handle, DDS_SECURITY_HANDLE_NIL);
  EXPECT_EQ(refusal.reason(), Code::file_not_found);
  EXPECT_THAT(harness.events.back().error.to_sentence(), testing::HasSubstr("ca.pem"));
}

TEST_F(AuthenticationAdapterTest, PluginThatThrows_Denies) {
  ON_CALL(plugin, process_handshake)
      .WillByDefault(testing::Throw(std::runtime_error("out of luck")));
  const HostToken in(sample_token());
  HostToken out;
  EXPECT_EQ(c->process_handshake(c, &out, &in, 3, &refusal), DDS_SECURITY_VALIDATION_FAILED);
  EXPECT_EQ(refusal.reason(), Code::internal);
  EXPECT_TRUE(is_nil(&out));
  EXPECT_EQ(harness.events.size(), 1u);
}

TEST_F(AuthenticationAdapterTest, NullArguments_AreRefusedNotFollowed) {
  DDS_Security_IdentityHandle handle = 1;
  DDS_Security_GUID_t guid{};
  DDS_Security_Qos qos{};
  const HostToken token(sample_token());
  HostToken out, request;
  EXPECT_EQ(c->validate_local_identity(c, nullptr, &guid, 0, &qos, &guid, &refusal),
            DDS_SECURITY_VALIDATION_FAILED);
  EXPECT_EQ(c->validate_local_identity(c, &handle, &guid, 0, nullptr, &guid, nullptr),
            DDS_SECURITY_VALIDATION_FAILED);
  EXPECT_EQ(c->validate_remote_identity(c, &handle, nullptr, nullptr, 1, &token, &guid, nullptr),
            DDS_SECURITY_VALIDATION_FAILED);
  EXPECT_EQ(c->validate_remote_identity(c, &handle, &request, nullptr, 1, nullptr, &guid, nullptr),
            DDS_SECURITY_VALIDATION_FAILED);
  EXPECT_EQ(c->begin_handshake_request(c, &handle, &out, 1, 2, nullptr, nullptr),
            DDS_SECURITY_VALIDATION_FAILED);
  EXPECT_EQ(c->begin_handshake_reply(c, &handle, &out, nullptr, 1, 2, &data.sequence, nullptr),
            DDS_SECURITY_VALIDATION_FAILED);
  EXPECT_EQ(c->process_handshake(c, nullptr, &token, 1, nullptr), DDS_SECURITY_VALIDATION_FAILED);
  EXPECT_EQ(c->get_identity_token(c, nullptr, 1, nullptr), 0);
  EXPECT_EQ(c->get_identity_status_token(c, nullptr, 1, nullptr), 0);
  EXPECT_EQ(c->set_permissions_credential_and_token(c, 1, nullptr, &token, nullptr), 0);
  EXPECT_EQ(c->get_authenticated_peer_credential_token(c, nullptr, 1, nullptr), 0);
  EXPECT_EQ(c->get_identity_token(nullptr, &out, 1, nullptr), 0);
  EXPECT_EQ(c->get_shared_secret(nullptr, 1, nullptr), DDS_SECURITY_HANDLE_NIL);
  EXPECT_EQ(refusal.reason(), Code::null_argument);
}

TEST_F(AuthenticationAdapterTest, Tokens_ComeOutAndGoIn) {
  EXPECT_CALL(plugin, identity_token(spi::IdentityHandle{4}, spi::kStandardCiphers))
      .WillOnce(Return(sample_token()));
  EXPECT_CALL(plugin, identity_status_token(spi::IdentityHandle{4}))
      .WillOnce(Return(sample_token()));
  HostToken identity, status;
  EXPECT_EQ(c->get_identity_token(c, &identity, 4, &refusal), 1);
  EXPECT_EQ(*token_from(&identity), sample_token());
  EXPECT_EQ(c->get_identity_status_token(c, &status, 4, &refusal), 1);
  EXPECT_EQ(c->return_identity_status_token(c, &status, &refusal), 1);
  EXPECT_EQ(c->return_identity_status_token(c, &status, &refusal), 1);
  EXPECT_EQ(c->return_identity_token(c, nullptr, nullptr), 1);

  EXPECT_CALL(plugin, set_permissions_credential_and_token(spi::IdentityHandle{4}, sample_token(),
                                                           sample_token()))
      .WillOnce(Return(Status{}));
  EXPECT_EQ(c->set_permissions_credential_and_token(c, 4, &identity, &identity, &refusal), 1);
}

TEST_F(AuthenticationAdapterTest, PeersAuthRequest_NeverReachesThePlugin) {
  const auto guid = to_c(guid_of(3));
  const HostToken token(sample_token());
  HostToken request;
  DDS_Security_IdentityHandle handle = -1;
  EXPECT_CALL(plugin, validate_remote_identity(spi::IdentityHandle{1}, testing::Eq(std::nullopt),
                                               sample_token(), guid_of(3)))
      .WillOnce(Return(spi::Authentication::RemoteIdentity{
          {2}, spi::ValidationResult::pending_handshake_request, sample_token()}));
  EXPECT_EQ(c->validate_remote_identity(c, &handle, &request, nullptr, 1, &token, &guid, &refusal),
            DDS_SECURITY_VALIDATION_PENDING_HANDSHAKE_REQUEST);
  EXPECT_EQ(handle, 2);
  EXPECT_FALSE(is_nil(&request));

  // Even a token that cannot be read refuses nothing, because it proves nothing.
  DDS_Security_DataHolder unreadable{};
  unreadable.binary_properties._length = 7;
  EXPECT_CALL(plugin, validate_remote_identity(_, testing::Eq(std::nullopt), _, _))
      .Times(2)
      .WillRepeatedly(Return(spi::Authentication::RemoteIdentity{
          {2}, spi::ValidationResult::pending_handshake_message, std::nullopt}));
  HostToken answer;
  EXPECT_EQ(
      c->validate_remote_identity(c, &handle, &answer, &unreadable, 1, &token, &guid, &refusal),
      DDS_SECURITY_VALIDATION_PENDING_HANDSHAKE_MESSAGE);
  HostToken none;
  EXPECT_EQ(c->validate_remote_identity(c, &handle, &none, &request, 1, &token, &guid, &refusal),
            DDS_SECURITY_VALIDATION_PENDING_HANDSHAKE_MESSAGE);
  ASSERT_NE(none.class_id, nullptr);
  EXPECT_STREQ(none.class_id, "");
}

// Cyclone 0.10.2's handshake calls strlen on the class id when it sends the request again, whatever
// the answer was.
TEST_F(AuthenticationAdapterTest, ARefusedPeer_LeavesAnEmptyClassIdAndNotNull) {
  const HostToken token(sample_token());
  HostToken request;
  const DDS_Security_GUID_t remote{};
  DDS_Security_IdentityHandle handle = -1;
  EXPECT_CALL(plugin, validate_remote_identity(_, _, _, _)).WillOnce([](auto&&...) {
    return fail(Code::guid_not_adjusted);
  });
  EXPECT_EQ(
      c->validate_remote_identity(c, &handle, &request, nullptr, 1, &token, &remote, &refusal),
      DDS_SECURITY_VALIDATION_FAILED);
  ASSERT_NE(request.class_id, nullptr);
  EXPECT_STREQ(request.class_id, "");
}

// Anyone can announce anything in a peer's name, and the core would not begin with that peer again.
TEST_F(AuthenticationAdapterTest, RefusedAnnouncement_IsLookedAtAgainAndThenDiscoveredAnew) {
  const HostToken good(sample_token());
  DDS_Security_DataHolder unreadable{};
  unreadable.binary_properties._length = 7;
  HostToken request;
  const auto remote = to_c(guid_of(3));
  const auto ask = [&](const DDS_Security_DataHolder& token, DDS_Security_IdentityHandle& handle) {
    return c->validate_remote_identity(c, &handle, &request, nullptr, 1, &token, &remote, nullptr);
  };
  DDS_Security_IdentityHandle first = 0, second = 0, third = 0;
  EXPECT_EQ(ask(unreadable, first), DDS_SECURITY_VALIDATION_PENDING_RETRY);
  EXPECT_NE(first, DDS_SECURITY_HANDLE_NIL);
  EXPECT_CALL(plugin, validate_remote_identity(_, _, _, _))
      .WillOnce(Return(fail(Code::too_many_remote_identities)))
      .WillOnce(Return(spi::Authentication::RemoteIdentity{
          {2}, spi::ValidationResult::pending_handshake_request, sample_token()}));
  EXPECT_EQ(ask(good, second), DDS_SECURITY_VALIDATION_PENDING_RETRY);
  EXPECT_EQ(ask(good, third), DDS_SECURITY_VALIDATION_PENDING_HANDSHAKE_REQUEST);
  EXPECT_EQ(first, second);
  EXPECT_EQ(first, third) << "the core keeps one handle of a remote participant";
  EXPECT_CALL(plugin, return_identity_handle(spi::IdentityHandle{2}));
  EXPECT_EQ(c->return_identity_handle(c, third, nullptr), 1);
}

TEST_F(AuthenticationAdapterTest, PeerThatTheHostForgets_IsToldToAccessControl) {
  ON_CALL(plugin, return_identity_handle).WillByDefault(Return(Status{}));
  harness.adapter.remotes().note({1}, {{{0x81}}, kEntityIdParticipant}, {31});
  harness.adapter.remotes().note({2}, {{{0x81}}, kEntityIdParticipant}, {32});
  forgotten_peer = 0;
  EXPECT_EQ(c->return_identity_handle(c, 2, nullptr), 1);
  EXPECT_EQ(forgotten_peer, 0) << "a local participant is no peer";
  EXPECT_EQ(c->return_identity_handle(c, 31, nullptr), 1);
  EXPECT_EQ(forgotten_peer, 31);
}

TEST_F(AuthenticationAdapterTest, HandshakeSteps_GiveTheHostsResults) {
  using spi::ValidationResult;
  EXPECT_CALL(plugin, begin_handshake_request(spi::IdentityHandle{1}, spi::IdentityHandle{2}, _))
      .WillOnce(Return(spi::Authentication::HandshakeStep{
          {10}, ValidationResult::pending_handshake_message, sample_token()}));
  EXPECT_CALL(plugin, begin_handshake_reply(sample_token(), spi::IdentityHandle{2},
                                            spi::IdentityHandle{1}, _))
      .WillOnce(Return(spi::Authentication::HandshakeStep{
          {11}, ValidationResult::pending_handshake_message, sample_token()}));
  EXPECT_CALL(plugin, process_handshake(spi::HandshakeHandle{10}, _))
      .WillOnce(Return(spi::Authentication::HandshakeStep{
          {10}, ValidationResult::ok_final_message, sample_token()}))
      .WillOnce(
          Return(spi::Authentication::HandshakeStep{{10}, ValidationResult::ok, std::nullopt}));

  HostToken request, reply, final_message, none;
  DDS_Security_HandshakeHandle handle = 0;
  EXPECT_EQ(c->begin_handshake_request(c, &handle, &request, 1, 2, &data.sequence, &refusal),
            DDS_SECURITY_VALIDATION_PENDING_HANDSHAKE_MESSAGE);
  EXPECT_EQ(handle, 10);
  EXPECT_EQ(c->begin_handshake_reply(c, &handle, &reply, &request, 2, 1, &data.sequence, &refusal),
            DDS_SECURITY_VALIDATION_PENDING_HANDSHAKE_MESSAGE);
  EXPECT_EQ(handle, 11);
  EXPECT_EQ(c->process_handshake(c, &final_message, &reply, 10, &refusal),
            DDS_SECURITY_VALIDATION_OK_FINAL_MESSAGE);
  EXPECT_EQ(c->process_handshake(c, &none, &reply, 10, &refusal), DDS_SECURITY_VALIDATION_OK);
  EXPECT_TRUE(is_nil(&none));
}

TEST_F(AuthenticationAdapterTest, SharedSecret_IsCyclonesLayoutUntilTheRemoteGoes) {
  ON_CALL(plugin, begin_handshake_request)
      .WillByDefault(Return(spi::Authentication::HandshakeStep{
          {10}, spi::ValidationResult::pending_handshake_message, sample_token()}));
  ON_CALL(plugin, shared_secret).WillByDefault(Return(secret()));
  ON_CALL(plugin, return_identity_handle).WillByDefault(Return(Status{}));
  EXPECT_EQ(c->get_shared_secret(c, 10, &refusal), DDS_SECURITY_HANDLE_NIL);
  EXPECT_EQ(refusal.reason(), Code::foreign_shared_secret);  // no handshake has this handle

  HostToken request;
  DDS_Security_HandshakeHandle handle = 0;
  c->begin_handshake_request(c, &handle, &request, 1, 2, &data.sequence, nullptr);
  const auto secret_handle = c->get_shared_secret(c, handle, nullptr);
  ASSERT_NE(secret_handle, DDS_SECURITY_HANDLE_NIL);
  EXPECT_EQ(c->get_shared_secret(c, handle, nullptr), secret_handle);
  EXPECT_EQ(c->return_sharedsecret_handle(c, secret_handle, nullptr), 1);

  const auto* layout = reinterpret_cast<const SharedSecretLayout*>(secret_handle);
  EXPECT_EQ(layout->shared_secret_size, 32);
  EXPECT_EQ(layout->shared_secret[31], 9);
  EXPECT_EQ(layout->challenge1[0], 1);
  EXPECT_EQ(layout->challenge2[31], 2);

  EXPECT_EQ(c->return_identity_handle(c, 3, nullptr), 1);  // the handle is not known
  EXPECT_EQ(layout->shared_secret[0], 9);
  EXPECT_EQ(c->return_identity_handle(c, 2, nullptr), 1);
  Refusal gone;
  EXPECT_EQ(c->get_shared_secret(c, handle, &gone), DDS_SECURITY_HANDLE_NIL);
  EXPECT_EQ(gone.reason(), Code::foreign_shared_secret);
}

TEST_F(AuthenticationAdapterTest, PeerCredential_IsText) {
  ON_CALL(plugin, authenticated_peer_credential_token)
      .WillByDefault(Return(spi::Token{.class_id = "DDS:Auth:PKI-DH:1.0",
                                       .binary_properties = {{"c.id", {'i'}}, {"c.perm", {'p'}}}}));
  HostToken credential;
  ASSERT_EQ(c->get_authenticated_peer_credential_token(c, &credential, 1, nullptr), 1);
  ASSERT_EQ(credential.properties._length, 2u);
  EXPECT_STREQ(credential.properties._buffer[0].name, "c.id");
  EXPECT_STREQ(credential.properties._buffer[1].value, "p");
  EXPECT_EQ(c->return_authenticated_peer_credential_token(c, &credential, nullptr), 1);
}

TEST_F(AuthenticationAdapterTest, SessionFacts_GoThroughTheHost) {
  spi::Token token{.class_id = "DDS:Auth:PKI-DH:1.0", .binary_properties = {{"c.perm", {'p'}}}};
  // The octets of the digest alone would be no text that the host can pass on.
  const spi::SessionFacts facts{.presented_permissions = Sha256Digest{},
                                .peer_keeps_session = true};
  spi::add_session_facts(token, facts);
  ON_CALL(plugin, authenticated_peer_credential_token).WillByDefault(Return(token));
  HostToken credential;
  ASSERT_EQ(c->get_authenticated_peer_credential_token(c, &credential, 1, nullptr), 1);
  const auto as_access_control_gets_it = token_from(&credential);
  ASSERT_TRUE(as_access_control_gets_it);
  const auto found = spi::session_facts_in(*as_access_control_gets_it);
  EXPECT_EQ(found.presented_permissions, facts.presented_permissions);
  EXPECT_TRUE(found.peer_keeps_session);
  EXPECT_EQ(c->return_authenticated_peer_credential_token(c, &credential, nullptr), 1);
}

TEST_F(AuthenticationAdapterTest, NilHandles_AreReturnedWithoutThePlugin) {
  EXPECT_CALL(plugin, return_identity_handle).Times(0);
  EXPECT_CALL(plugin, return_handshake_handle).Times(0);
  EXPECT_EQ(c->return_identity_handle(c, 0, nullptr), 1);
  EXPECT_EQ(c->return_handshake_handle(c, 0, nullptr), 1);
}

std::atomic<DDS_Security_IdentityHandle> revoked_identity{0};
std::atomic<const dds_security_authentication*> revoking_plugin{nullptr};

TEST_F(AuthenticationAdapterTest, ExpiredIdentity_IsRevokedThroughTheListener) {
  harness.adapter.remotes().note({1}, {{{0x81}}, kEntityIdParticipant}, {31});
  ON_CALL(plugin, poll).WillByDefault(Return(std::vector<spi::IdentityHandle>{{31}}));
  ON_CALL(plugin, next_expiry).WillByDefault(Return(std::nullopt));
  const dds_security_authentication_listener listener{
      [](const dds_security_authentication* plugin,
         const DDS_Security_IdentityHandle handle) -> DDS_Security_boolean {
        revoking_plugin = plugin;
        revoked_identity = handle;
        return 1;
      },
      nullptr};
  EXPECT_EQ(c->set_listener(c, &listener, nullptr), 1);
  for (int i = 0; i < 1000 && revoked_identity == 0; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  EXPECT_EQ(revoked_identity, 31);
  EXPECT_EQ(revoking_plugin, c);
  EXPECT_EQ(c->set_listener(c, nullptr, nullptr), 1);
  EXPECT_EQ(c->set_listener(c, nullptr, nullptr), 1);
}

// A stranger's message that had to be refused would leave the core waiting for ever.
TEST_F(AuthenticationAdapterTest, HandshakeThatAStrangerDisturbed_IsBegunAgain) {
  ON_CALL(plugin, validate_remote_identity).WillByDefault([](spi::IdentityHandle local, auto&&...) {
    return spi::Authentication::RemoteIdentity{
        {40 + local.value}, spi::ValidationResult::pending_handshake_request, {}};
  });
  ON_CALL(plugin, begin_handshake_reply).WillByDefault(Return(fail(Code::handshake_role_wrong)));
  ON_CALL(plugin, begin_handshake_request)
      .WillByDefault(Return(spi::Authentication::HandshakeStep{
          {60}, spi::ValidationResult::pending_handshake_message, {}}));
  ON_CALL(plugin, process_handshake)
      .WillByDefault(Return(
          spi::Authentication::HandshakeStep{{60}, spi::ValidationResult::ok_final_message, {}}));
  ON_CALL(plugin, next_expiry).WillByDefault(Return(std::nullopt));
  const HostToken token(sample_token());
  const auto meet = [&](std::uint8_t octet, DDS_Security_IdentityHandle local) {
    HostToken request;
    DDS_Security_IdentityHandle remote = 0;
    const auto guid = to_c(guid_of(octet));
    c->validate_remote_identity(c, &remote, &request, nullptr, local, &token, &guid, nullptr);
    return remote;
  };
  const auto forged = [&](DDS_Security_IdentityHandle remote, DDS_Security_IdentityHandle local) {
    DDS_Security_HandshakeHandle handshake = 0;
    HostToken reply;
    EXPECT_EQ(c->begin_handshake_reply(c, &handshake, &reply, &token, remote, local, &data.sequence,
                                       nullptr),
              DDS_SECURITY_VALIDATION_FAILED);
  };
  // This peer authenticates in spite of the forged message.
  const auto finished = meet(2, 2);
  forged(finished, 2);
  DDS_Security_HandshakeHandle handshake = 0;
  HostToken message, final_message;
  c->begin_handshake_request(c, &handshake, &message, 2, finished, &data.sequence, nullptr);
  EXPECT_EQ(c->process_handshake(c, &final_message, &token, handshake, nullptr),
            DDS_SECURITY_VALIDATION_OK_FINAL_MESSAGE);
  const auto stuck = meet(1, 1);
  forged(stuck, 1);

  revoked_identity = 0;
  const dds_security_authentication_listener listener{
      [](const dds_security_authentication*,
         const DDS_Security_IdentityHandle handle) -> DDS_Security_boolean {
        revoked_identity = handle;
        return 1;
      },
      nullptr};
  const auto start = std::chrono::steady_clock::now();
  EXPECT_EQ(c->set_listener(c, &listener, nullptr), 1);
  while (revoked_identity == 0 &&
         std::chrono::steady_clock::now() - start < std::chrono::seconds(20))
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  EXPECT_EQ(c->set_listener(c, nullptr, nullptr), 1);
  EXPECT_EQ(revoked_identity, stuck);
  EXPECT_GE(std::chrono::steady_clock::now() - start, HandshakeWatch::kTimeoutAfterRefusal / 2);
  std::vector<std::string> told;
  for (const auto& event : harness.events)
    if (event.error.code() == Code::handshake_begun_again) told.push_back(event.guid);
  EXPECT_EQ(told, std::vector{guid_of(1).to_string()});
}

}  // namespace
}  // namespace ddssec::cyclonedds

// libddssec_access_control exports this function.
DDSSEC_EXPORT void ddssec_return_permissions_of(DDS_Security_IdentityHandle peer) {
  forgotten_peer = peer;
}
