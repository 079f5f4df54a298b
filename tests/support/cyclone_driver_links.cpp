// Participants and endpoints of the driver that get to know each other and exchange keys.
#include <algorithm>
#include <array>
#include <atomic>

#include "tests/support/cyclone_driver.hpp"

namespace ddssec::driver {
namespace {

DDS_Security_Property_t property(const std::string& name, const std::string& value) {
  return {const_cast<char*>(name.c_str()), const_cast<char*>(value.c_str()), 0};
}

using CreateTokens = DDS_Security_boolean (*)(dds_security_crypto_key_exchange*,
                                              DDS_Security_CryptoTokenSeq*, DDS_Security_long_long,
                                              DDS_Security_long_long, Exception*);
using SetTokens = DDS_Security_boolean (*)(dds_security_crypto_key_exchange*,
                                           DDS_Security_long_long, DDS_Security_long_long,
                                           const DDS_Security_CryptoTokenSeq*, Exception*);

// Makes tokens for `remote` at one side and sets them at the other. If none are made, none are
// sent.
void carry_tokens(dds_security_cryptography* from, CreateTokens create, std::int64_t local,
                  std::int64_t remote, dds_security_cryptography* at, SetTokens set,
                  std::int64_t local_there, std::int64_t remote_there) {
  auto* maker = from->crypto_key_exchange;
  DDS_Security_CryptoTokenSeq tokens{};
  Call creating("create crypto tokens");
  creating.check(create(maker, &tokens, local, remote, creating));
  if (tokens._length == 0) return;
  Call setting("set crypto tokens");
  const auto ok = set(at->crypto_key_exchange, local_there, remote_there, &tokens, setting);
  maker->return_crypto_tokens(maker, &tokens, nullptr);
  setting.check(ok);
}

// Carries the writer's tokens to the reader, and the reader's tokens to the writer.
void carry_endpoint_tokens(const Sender& sender, const Receiver& receiver,
                           DDS_Security_DatareaderCryptoHandle remote_reader) {
  auto* make = sender.plugin->crypto_key_exchange;
  auto* set = receiver.plugin->crypto_key_exchange;
  carry_tokens(sender.plugin, make->create_local_datawriter_crypto_tokens, sender.writer,
               remote_reader, receiver.plugin, set->set_remote_datawriter_crypto_tokens,
               receiver.reader, receiver.remote_writer);
  carry_tokens(receiver.plugin, set->create_local_datareader_crypto_tokens, receiver.reader,
               receiver.remote_writer, sender.plugin, make->set_remote_datareader_crypto_tokens,
               sender.writer, remote_reader);
}

std::int64_t made(const Call& call, std::int64_t handle) {
  call.check(handle != DDS_SECURITY_HANDLE_NIL);
  return handle;
}

// Returns an identity for a new link. Plugins know a remote participant by its identity, so every
// link has identities of its own.
std::int64_t next_identity() {
  static std::atomic<std::int64_t> last = 1'000'000;
  return ++last;
}

}  // namespace

CryptoLink::CryptoLink(dds_security_cryptography& sending, dds_security_cryptography& receiving,
                       const Keys& keys, std::size_t receiver_count)
    : identity_(next_identity()),
      sender{&sending, 0, 0, {}, {}},
      receivers(receiver_count, Receiver{&receiving, 0, 0, 0, 0}) {
  auto* factory = sending.crypto_key_factory;
  Call call("register_local_participant");
  sender.participant = made(call, factory->register_local_participant(
                                      factory, identity_, 1, nullptr, &keys.participant, call));
  const DDS_Security_PropertySeq none{};
  if (keys.endpoint.is_payload_protected || keys.endpoint.is_submessage_protected)
    sender.writer = made(call, factory->register_local_datawriter(factory, sender.participant,
                                                                  &none, &keys.endpoint, call));
  for (std::size_t i = 0; i < receiver_count; ++i) match(i, keys);
}

void CryptoLink::match(std::size_t number, const Keys& keys) {
  secrets_.push_back(std::make_unique<MadeUpSecret>(static_cast<std::uint8_t>(number + 1)));
  const auto secret = secrets_.back()->handle();
  auto& receiver = receivers[number];
  auto* ours = sender.plugin->crypto_key_factory;
  auto* theirs = receiver.plugin->crypto_key_factory;
  const DDS_Security_PropertySeq none{};
  const auto identity = next_identity();
  Call call("register");
  receiver.participant = made(call, theirs->register_local_participant(theirs, identity, 1, nullptr,
                                                                       &keys.participant, call));
  const auto remote = made(call, ours->register_matched_remote_participant(
                                     ours, sender.participant, identity, 2, secret, call));
  sender.remote_participants.push_back(remote);
  receiver.remote_participant =
      made(call, theirs->register_matched_remote_participant(theirs, receiver.participant,
                                                             identity_, 2, secret, call));
  auto* make = sender.plugin->crypto_key_exchange;
  auto* set = receiver.plugin->crypto_key_exchange;
  carry_tokens(sender.plugin, make->create_local_participant_crypto_tokens, sender.participant,
               remote, receiver.plugin, set->set_remote_participant_crypto_tokens,
               receiver.participant, receiver.remote_participant);
  carry_tokens(receiver.plugin, set->create_local_participant_crypto_tokens, receiver.participant,
               receiver.remote_participant, sender.plugin,
               make->set_remote_participant_crypto_tokens, sender.participant, remote);
  if (sender.writer == 0) return;
  receiver.reader = made(call, theirs->register_local_datareader(theirs, receiver.participant,
                                                                 &none, &keys.endpoint, call));
  const auto remote_reader = made(
      call, ours->register_matched_remote_datareader(ours, sender.writer, remote, secret, 0, call));
  sender.remote_readers.push_back(remote_reader);
  receiver.remote_writer =
      made(call, theirs->register_matched_remote_datawriter(
                     theirs, receiver.reader, receiver.remote_participant, secret, call));
  carry_endpoint_tokens(sender, receiver, remote_reader);
}

CryptoLink::~CryptoLink() {
  auto* ours = sender.plugin->crypto_key_factory;
  for (const auto reader : sender.remote_readers)
    ours->unregister_datareader(ours, reader, nullptr);
  for (const auto remote : sender.remote_participants)
    ours->unregister_participant(ours, remote, nullptr);
  if (sender.writer != 0) ours->unregister_datawriter(ours, sender.writer, nullptr);
  ours->unregister_participant(ours, sender.participant, nullptr);
  if (receivers.empty()) return;
  auto* theirs = receivers[0].plugin->crypto_key_factory;
  for (const auto& receiver : receivers) {
    if (receiver.remote_writer != 0)
      theirs->unregister_datawriter(theirs, receiver.remote_writer, nullptr);
    if (receiver.reader != 0) theirs->unregister_datareader(theirs, receiver.reader, nullptr);
  }
  theirs->unregister_participant(theirs, receivers[0].remote_participant, nullptr);
  for (const auto& receiver : receivers)
    theirs->unregister_participant(theirs, receiver.participant, nullptr);
}

Participant::Participant(Domain& in, const std::string& pki, const std::string& name,
                         const std::string& governance, std::uint8_t number)
    : domain(in) {
  const std::array<std::pair<std::string, std::string>, 6> values = {
      {{"dds.sec.auth.identity_ca", "file:" + pki + "/idca.pem"},
       {"dds.sec.auth.identity_certificate", "file:" + pki + "/" + name + ".pem"},
       {"dds.sec.auth.private_key", "file:" + pki + "/" + name + ".key"},
       {"dds.sec.access.permissions_ca", "file:" + pki + "/permca.pem"},
       {"dds.sec.access.governance", "file:" + pki + "/governance_" + governance + ".p7s"},
       {"dds.sec.access.permissions", "file:" + pki + "/permissions_" + name + ".p7s"}}};
  std::vector<DDS_Security_Property_t> properties;
  for (const auto& [key, value] : values) properties.push_back(property(key, value));
  DDS_Security_Qos qos{};
  qos.property.value = {6, 6, properties.data()};

  auto& auth = domain.authentication();
  auto& access = domain.access_control();
  DDS_Security_GUID_t candidate{};
  std::copy_n(name.begin(), std::min<std::size_t>(name.size(), 6), candidate.prefix + 6);
  candidate.prefix[0] = number;
  candidate.entityId = {{0, 0, 1}, 0xc1};
  Call identity_call("validate_local_identity");
  identity_call.check(auth.validate_local_identity(&auth, &identity, &guid, 0, &qos, &candidate,
                                                   identity_call) == DDS_SECURITY_VALIDATION_OK);
  Call token_call("get_identity_token");
  token_call.check(auth.get_identity_token(&auth, &identity_token, identity, token_call));

  Call permissions_call("validate_local_permissions");
  permissions =
      access.validate_local_permissions(&access, &auth, identity, 0, &qos, permissions_call);
  permissions_call.check(permissions != 0);
  Call create_call("check_create_participant");
  create_call.check(access.check_create_participant(&access, permissions, 0, &qos, create_call));
  DDS_Security_DataHolder credential{};
  Call credential_call("get_permissions_credential_token");
  credential_call.check(
      access.get_permissions_credential_token(&access, &credential, permissions, credential_call));
  credential_call.check(
      access.get_permissions_token(&access, &permissions_token, permissions, credential_call));
  Call set_call("set_permissions_credential_and_token");
  const auto set = auth.set_permissions_credential_and_token(&auth, identity, &credential,
                                                             &permissions_token, set_call);
  access.return_permissions_credential_token(&access, &credential, nullptr);
  set_call.check(set);
  Call attributes_call("get_participant_sec_attributes");
  attributes_call.check(
      access.get_participant_sec_attributes(&access, permissions, &attributes, attributes_call));
  auto* factory = domain.cryptography().crypto_key_factory;
  Call crypto_call("register_local_participant");
  crypto = factory->register_local_participant(factory, identity, permissions, nullptr, &attributes,
                                               crypto_call);
  crypto_call.check(crypto != 0);

  // The data is PID_PARTICIPANT_GUID and PID_SENTINEL, big-endian.
  data = {0x00, 0x50, 0x00, 0x10};
  data.insert(data.end(), guid.prefix, guid.prefix + 12);
  for (const std::uint8_t octet : {0x00, 0x00, 0x01, 0xc1, 0x00, 0x01, 0x00, 0x00})
    data.push_back(octet);
}

Participant::~Participant() {
  auto* factory = domain.cryptography().crypto_key_factory;
  factory->unregister_participant(factory, crypto, nullptr);
  auto& access = domain.access_control();
  access.return_participant_sec_attributes(&access, &attributes, nullptr);
  access.return_permissions_handle(&access, permissions, nullptr);
  auto& auth = domain.authentication();
  auth.return_identity_handle(&auth, identity, nullptr);
}

void authenticate(Participant& a, Participant& b, Peer& a_of_b, Peer& b_of_a) {
  auto& auth_a = a.domain.authentication();
  auto& auth_b = b.domain.authentication();
  Token request_a, request_b;
  Call call("validate_remote_identity");
  const auto at_a = auth_a.validate_remote_identity(&auth_a, &a_of_b.identity, &request_a, nullptr,
                                                    a.identity, &b.identity_token, &b.guid, call);
  call.check(at_a != DDS_SECURITY_VALIDATION_FAILED);
  const auto at_b = auth_b.validate_remote_identity(
      &auth_b, &b_of_a.identity, &request_b, request_a.class_id != nullptr ? &request_a : nullptr,
      b.identity, &a.identity_token, &a.guid, call);
  call.check(at_b != DDS_SECURITY_VALIDATION_FAILED && at_a != at_b);

  const bool a_starts = at_a == DDS_SECURITY_VALIDATION_PENDING_HANDSHAKE_REQUEST;
  auto& first = a_starts ? a : b;
  auto& second = a_starts ? b : a;
  auto& second_of_first = a_starts ? a_of_b : b_of_a;
  auto& first_of_second = a_starts ? b_of_a : a_of_b;
  auto& auth_first = first.domain.authentication();
  auto& auth_second = second.domain.authentication();
  Token request, reply, final_message, nothing;
  const auto first_data = view(first.data), second_data = view(second.data);
  Call handshake("handshake");
  handshake.check(auth_first.begin_handshake_request(
                      &auth_first, &second_of_first.handshake, &request, first.identity,
                      second_of_first.identity, &first_data,
                      handshake) == DDS_SECURITY_VALIDATION_PENDING_HANDSHAKE_MESSAGE);
  handshake.check(auth_second.begin_handshake_reply(&auth_second, &first_of_second.handshake,
                                                    &reply, &request, first_of_second.identity,
                                                    second.identity, &second_data, handshake) ==
                  DDS_SECURITY_VALIDATION_PENDING_HANDSHAKE_MESSAGE);
  handshake.check(auth_first.process_handshake(&auth_first, &final_message, &reply,
                                               second_of_first.handshake, handshake) ==
                  DDS_SECURITY_VALIDATION_OK_FINAL_MESSAGE);
  handshake.check(auth_second.process_handshake(&auth_second, &nothing, &final_message,
                                                first_of_second.handshake,
                                                handshake) == DDS_SECURITY_VALIDATION_OK);
}

Link::Link(Participant& a, Participant& b, const std::string& topic) : Link(a, b) {
  authenticate(a_, b_, a_of_b, b_of_a);
  judge(a_, b_, a_of_b);
  judge(b_, a_, b_of_a);
  exchange_participant_keys(a_, a_of_b, b_, b_of_a);
  exchange_participant_keys(b_, b_of_a, a_, a_of_b);
  add_endpoints(topic);
}

void Link::judge(Participant& self, Participant& remote, Peer& peer) {
  auto& auth = self.domain.authentication();
  auto& access = self.domain.access_control();
  Call secret("get_shared_secret");
  peer.secret = auth.get_shared_secret(&auth, peer.handshake, secret);
  secret.check(peer.secret != 0);
  DDS_Security_DataHolder credential{};
  Call credential_call("get_authenticated_peer_credential_token");
  credential_call.check(auth.get_authenticated_peer_credential_token(
      &auth, &credential, peer.handshake, credential_call));
  Call permissions("validate_remote_permissions");
  peer.permissions =
      access.validate_remote_permissions(&access, &auth, self.identity, peer.identity,
                                         &remote.permissions_token, &credential, permissions);
  auth.return_authenticated_peer_credential_token(&auth, &credential, nullptr);
  permissions.check(peer.permissions != 0);
  DDS_Security_ParticipantBuiltinTopicDataSecure announced{};
  Call participant("check_remote_participant");
  participant.check(
      access.check_remote_participant(&access, peer.permissions, 0, &announced, participant));
  auto* factory = self.domain.cryptography().crypto_key_factory;
  Call crypto("register_matched_remote_participant");
  peer.crypto = factory->register_matched_remote_participant(factory, self.crypto, peer.identity,
                                                             peer.permissions, peer.secret, crypto);
  crypto.check(peer.crypto != 0);
}

void Link::exchange_participant_keys(Participant& from, Peer& to, Participant& at, Peer& remote) {
  auto& maker = from.domain.cryptography();
  auto& taker = at.domain.cryptography();
  carry_tokens(&maker, maker.crypto_key_exchange->create_local_participant_crypto_tokens,
               from.crypto, to.crypto, &taker,
               taker.crypto_key_exchange->set_remote_participant_crypto_tokens, at.crypto,
               remote.crypto);
}

void Link::add_endpoints(const std::string& topic) {
  auto& access_a = a_.domain.access_control();
  auto& access_b = b_.domain.access_control();
  DDS_Security_Qos qos{};
  const DDS_Security_PartitionQosPolicy partition{};
  DDS_Security_DataTags tags{};
  Call checks("check_create");
  checks.check(access_a.check_create_datawriter(&access_a, a_.permissions, 0, topic.c_str(), &qos,
                                                &partition, &tags, checks));
  checks.check(access_b.check_create_datareader(&access_b, b_.permissions, 0, topic.c_str(), &qos,
                                                &partition, &tags, checks));
  Call get("get_sec_attributes");
  get.check(access_a.get_datawriter_sec_attributes(&access_a, a_.permissions, topic.c_str(),
                                                   &partition, nullptr, &writer_attributes, get));
  get.check(access_b.get_datareader_sec_attributes(&access_b, b_.permissions, topic.c_str(),
                                                   &partition, nullptr, &reader_attributes, get));
  sender = {&a_.domain.cryptography(), a_.crypto, 0, {a_of_b.crypto}, {}};
  receiver = {&b_.domain.cryptography(), b_.crypto, 0, b_of_a.crypto, 0};

  std::string name = topic;
  DDS_Security_PublicationBuiltinTopicDataSecure publication{};
  DDS_Security_SubscriptionBuiltinTopicDataSecure subscription{};
  publication.topic_name = subscription.topic_name = name.data();
  DDS_Security_boolean is_relay_only = 1;
  Call remote("check_remote");
  remote.check(
      access_b.check_remote_datawriter(&access_b, b_of_a.permissions, 0, &publication, remote));
  remote.check(access_a.check_remote_datareader(&access_a, a_of_b.permissions, 0, &subscription,
                                                &is_relay_only, remote));
  // Cyclone registers only protected endpoints.
  if (!writer_attributes.is_payload_protected && !writer_attributes.is_submessage_protected) return;

  auto* ours = sender.plugin->crypto_key_factory;
  auto* theirs = receiver.plugin->crypto_key_factory;
  const DDS_Security_PropertySeq none{};
  Call call("register endpoint");
  sender.writer =
      made(call, ours->register_local_datawriter(ours, a_.crypto, &none, &writer_attributes, call));
  receiver.reader = made(
      call, theirs->register_local_datareader(theirs, b_.crypto, &none, &reader_attributes, call));
  const auto remote_reader =
      made(call, ours->register_matched_remote_datareader(ours, sender.writer, a_of_b.crypto,
                                                          a_of_b.secret, is_relay_only, call));
  sender.remote_readers = {remote_reader};
  receiver.remote_writer =
      made(call, theirs->register_matched_remote_datawriter(theirs, receiver.reader, b_of_a.crypto,
                                                            b_of_a.secret, call));
  carry_endpoint_tokens(sender, receiver, remote_reader);
}

Link::~Link() {
  auto* ours = a_.domain.cryptography().crypto_key_factory;
  auto* theirs = b_.domain.cryptography().crypto_key_factory;
  for (const auto reader : sender.remote_readers)
    ours->unregister_datareader(ours, reader, nullptr);
  if (receiver.remote_writer != 0)
    theirs->unregister_datawriter(theirs, receiver.remote_writer, nullptr);
  if (sender.writer != 0) ours->unregister_datawriter(ours, sender.writer, nullptr);
  if (receiver.reader != 0) theirs->unregister_datareader(theirs, receiver.reader, nullptr);
  auto& access_a = a_.domain.access_control();
  auto& access_b = b_.domain.access_control();
  access_a.return_datawriter_sec_attributes(&access_a, &writer_attributes, nullptr);
  access_b.return_datareader_sec_attributes(&access_b, &reader_attributes, nullptr);
  for (auto& [self, peer] : {std::pair<Participant&, Peer&>{a_, a_of_b}, {b_, b_of_a}}) {
    auto* factory = self.domain.cryptography().crypto_key_factory;
    if (peer.crypto != 0) factory->unregister_participant(factory, peer.crypto, nullptr);
    auto& access = self.domain.access_control();
    if (peer.permissions != 0) access.return_permissions_handle(&access, peer.permissions, nullptr);
    auto& auth = self.domain.authentication();
    if (peer.identity != 0) auth.return_identity_handle(&auth, peer.identity, nullptr);
  }
}

}  // namespace ddssec::driver
