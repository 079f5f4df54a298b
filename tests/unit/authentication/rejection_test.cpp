// Messages that must be refused, each with exactly its code, and without harm to the honest ones.
#include "tests/support/hostile_pki.hpp"
#include "tests/unit/authentication/fixture.hpp"

namespace ddssec::authentication {
namespace {

/// What somebody does to a message, and why it is refused.
struct Forgery {
  std::string name;
  Code code;
  std::function<Token(Token)> change;
};

Token renamed(Token token, std::string class_id) {
  token.class_id = std::move(class_id);
  return token;
}

Token doubled(Token token, std::string_view name) {
  token.binary_properties.push_back({std::string(name), field(token, name)});
  return token;
}

Forgery lacks(std::string name) {
  return {"Lacks_" + name, Code::token_field_missing,
          [name](Token t) { return without(std::move(t), name); }};
}
Forgery repeats(std::string name) {
  return {"Repeats_" + name, Code::token_field_repeated,
          [name](Token t) { return doubled(std::move(t), name); }};
}
Forgery resizes(std::string name, std::size_t size) {
  return {"Resizes_" + name + "_" + std::to_string(size), Code::token_field_length,
          [name, size](Token t) { return with(std::move(t), name, Bytes(size)); }};
}
Forgery flips(std::string name, Code code) {
  return {"Flips_" + name, code, [name](Token t) {
            auto octets = field(t, name);
            octets.back() ^= 1;
            return with(std::move(t), name, std::move(octets));
          }};
}
Forgery sets(std::string label, std::string name, Bytes value, Code code) {
  return {std::move(label), code,
          [name, value](Token t) { return with(std::move(t), name, value); }};
}
/// As an attacker would: hashes are optional, so that a change can be hidden from them.
Forgery unhashed(Forgery forgery) {
  forgery.name += "_unhashed";
  forgery.change = [change = forgery.change](Token t) {
    return without(without(change(std::move(t)), "hash_c1"), "hash_c2");
  };
  return forgery;
}

const Identity& stranger() {
  static const pki::Authority ca = make_ca("CN=Other CA");
  static const Identity identity = make_identity(ca, "CN=stranger");
  return identity;
}

Bytes stranger_pem() { return bytes(stranger().certificate.pem()); }

/// A certificate of 40 KB for which some patch levels of OpenSSL take many times as much memory.
Bytes memory_bomb_pem() {
  return bytes(test::with_distribution_points({stranger().certificate, stranger().key},
                                              test::PointName::relative, 1500, 200));
}

Bytes off_curve() {
  Bytes point(65, 1);
  point[0] = 4;
  return point;
}

std::vector<Forgery> of_credentials() {
  std::vector<Forgery> all;
  for (const auto* name : {"c.id", "c.pdata", "c.dsign_algo", "c.kagree_algo"}) {
    all.push_back(lacks(name));
    all.push_back(repeats(name));
    all.push_back(resizes(name, 0));
  }
  all.push_back(repeats("c.perm"));
  all.push_back(resizes("c.id", 64 * 1024 + 1));
  all.push_back(resizes("c.perm", 1024 * 1024 + 1));
  all.push_back(resizes("c.pdata", 64 * 1024 + 1));
  all.push_back(resizes("c.dsign_algo", 129));
  all.push_back(resizes("c.kagree_algo", 129));
  all.push_back(flips("c.dsign_algo", Code::signature_algorithm_unknown));
  all.push_back(flips("c.kagree_algo", Code::key_agreement_algorithm_unknown));
  all.push_back(flips("c.id", Code::token_field_differs));
  all.push_back(flips("c.perm", Code::token_field_differs));
  all.push_back(flips("c.pdata", Code::token_field_differs));
  all.push_back(
      unhashed(sets("GarbageCertificate", "c.id", bytes("garbage"), Code::certificate_malformed)));
  all.push_back(unhashed(sets("CertificateOfManyDistributionPoints", "c.id", memory_bomb_pem(),
                              Code::certificate_distribution_points)));
  all.push_back(unhashed(
      sets("StrangersCertificate", "c.id", stranger_pem(), Code::guid_not_bound_to_subject)));
  all.push_back(unhashed(
      sets("ShortList", "c.pdata", Bytes{0, 0x50, 0, 16}, Code::participant_data_malformed)));
  all.push_back(unhashed(
      sets("ListWithoutGuid", "c.pdata", Bytes{0, 1, 0, 0}, Code::participant_guid_missing)));
  all.push_back(unhashed(sets("AnothersData", "c.pdata", participant_data(candidate(99)),
                              Code::participant_guid_differs)));
  return all;
}

std::vector<Forgery> of_request() {
  auto all = of_credentials();
  for (const auto* name : {"dh1", "challenge1"}) {
    all.push_back(lacks(name));
    all.push_back(repeats(name));
    all.push_back(resizes(name, 0));
    all.push_back(resizes(name, 1025));
  }
  all.push_back(resizes("challenge1", 31));
  all.push_back(resizes("challenge1", 33));
  all.push_back(resizes("hash_c1", 31));
  all.push_back(repeats("hash_c1"));
  all.push_back(flips("hash_c1", Code::token_field_differs));
  all.push_back(sets("ShortPoint", "dh1", Bytes(64, 4), Code::public_key_malformed));
  all.push_back(sets("PointOffTheCurve", "dh1", off_curve(), Code::public_key_not_in_group));
  all.push_back({"OtherClass", Code::token_class_wrong,
                 [](Token t) { return renamed(std::move(t), "DDS:Auth:Other:1.0+Req"); }});
  all.push_back({"AsReply", Code::token_class_wrong,
                 [](Token t) { return renamed(std::move(t), "DDS:Auth:PKI-DH:1.0+Reply"); }});
  return all;
}

std::vector<Forgery> of_reply() {
  auto all = of_credentials();
  for (const auto* name : {"dh2", "challenge1", "challenge2", "signature"}) {
    all.push_back(lacks(name));
    all.push_back(repeats(name));
    all.push_back(resizes(name, 0));
    all.push_back(resizes(name, 2049));
  }
  for (const auto* name : {"dh1", "hash_c1", "hash_c2", "challenge1"})
    all.push_back(flips(name, Code::token_field_differs));
  for (const auto* name : {"challenge2", "signature"})
    all.push_back(flips(name, Code::signature_invalid));
  all.push_back(unhashed(flips("c.perm", Code::signature_invalid)));
  all.push_back(flips("dh2", Code::public_key_not_in_group));
  all.push_back(sets("OtherKeyAgreement", "c.kagree_algo", bytes("DH+MODP-2048-256"),
                     Code::key_agreement_algorithm_changed));
  all.push_back(unhashed(
      sets("OtherName", "c.kagree_algo", bytes("ECDHE-CEUM+P256"), Code::signature_invalid)));
  all.push_back(unhashed(sets("OtherSignatureName", "c.dsign_algo", bytes("RSASSA-PSS-SHA256"),
                              Code::signature_invalid)));
  all.push_back({"AsRequest", Code::token_field_length, [](Token t) {
                   return with(renamed(std::move(t), "DDS:Auth:PKI-DH:1.0+Req"), "dh1", {});
                 }});
  return all;
}

std::vector<Forgery> of_final() {
  std::vector<Forgery> all;
  for (const auto* name : {"challenge1", "challenge2", "signature"}) {
    all.push_back(lacks(name));
    all.push_back(repeats(name));
    all.push_back(resizes(name, 0));
    all.push_back(resizes(name, 2049));
  }
  for (const auto* name : {"challenge1", "challenge2", "dh1", "dh2", "hash_c1", "hash_c2"})
    all.push_back(flips(name, Code::token_field_differs));
  all.push_back(flips("signature", Code::signature_invalid));
  all.push_back({"OtherClass", Code::token_class_wrong,
                 [](Token t) { return renamed(std::move(t), "DDS:Auth:PKI-DH:1.0+Finale"); }});
  return all;
}

const auto kName = [](const auto& info) {
  std::string name = info.param.name;
  std::ranges::replace(name, '.', '_');
  return name;
};

class ForgedRequest : public testing::TestWithParam<Forgery> {};
INSTANTIATE_TEST_SUITE_P(Each, ForgedRequest, testing::ValuesIn(of_request()), kName);

TEST_P(ForgedRequest, IsRefusedAndTheHonestOneSucceeds) {
  Pairing pairing;
  auto& events = pairing.two.high.engine->events.events;
  const auto req = pairing.two.request();
  ASSERT_OK(req);
  const auto refused = pairing.two.reply(GetParam().change(*req->message));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code(), GetParam().code) << refused.error().to_sentence();
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].error.code(), GetParam().code);
  EXPECT_EQ(events[0].guid, pairing.two.low.guid.to_string());
  EXPECT_FALSE(events[0].is_returned);
  const auto rep = pairing.two.reply(*req->message);
  ASSERT_OK(rep);
  pairing.expect_finish(*req, *rep);
}

class ForgedReply : public testing::TestWithParam<Forgery> {};
INSTANTIATE_TEST_SUITE_P(Each, ForgedReply, testing::ValuesIn(of_reply()), kName);

TEST_P(ForgedReply, IsRefusedAndTheHonestOneSucceeds) {
  Pairing pairing;
  auto& events = pairing.two.low.engine->events.events;
  const auto req = pairing.two.request();
  const auto rep = pairing.two.reply(*req->message);
  ASSERT_OK(rep);
  const auto refused = pairing.two.at_low(req->handle, GetParam().change(*rep->message));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code(), GetParam().code) << refused.error().to_sentence();
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].error.code(), GetParam().code);
  EXPECT_CODE((*pairing.two.low.engine)->shared_secret(req->handle), handshake_not_finished);
  pairing.expect_finish(*req, *rep);
}

class ForgedFinal : public testing::TestWithParam<Forgery> {};
INSTANTIATE_TEST_SUITE_P(Each, ForgedFinal, testing::ValuesIn(of_final()), kName);

TEST_P(ForgedFinal, IsRefusedAndTheHonestOneSucceeds) {
  Pairing pairing;
  const auto req = pairing.two.request();
  const auto rep = pairing.two.reply(*req->message);
  const auto fin = pairing.two.at_low(req->handle, *rep->message);
  ASSERT_OK(fin);
  const auto refused = pairing.two.at_high(rep->handle, GetParam().change(*fin->message));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code(), GetParam().code) << refused.error().to_sentence();
  EXPECT_CODE((*pairing.two.high.engine)->shared_secret(rep->handle), handshake_not_finished);
  EXPECT_CODE((*pairing.two.high.engine)->authenticated_peer_credential_token(rep->handle),
              handshake_not_finished);
  ASSERT_OK(pairing.two.at_high(rep->handle, *fin->message));
}

// ---- one flipped bit in any octet of any field

TEST(FlippedBit, AnywhereInAReplyIsRefused) {
  Pairing pairing;
  const auto req = pairing.two.request();
  const auto rep = pairing.two.reply(*req->message);
  ASSERT_OK(rep);
  for (const auto& property : rep->message->binary_properties) {
    const std::size_t step = property.value.size() > 200 ? 7 : 1;
    for (std::size_t at = 0; at < property.value.size(); at += step)
      EXPECT_FALSE(pairing.two.at_low(
          req->handle, with(*rep->message, property.name, flipped(property.value, at))))
          << property.name << " " << at;
  }
  pairing.expect_finish(*req, *rep);
}

// Without the hashes the signature alone must notice.
TEST(FlippedBit, AnywhereInAReplyWithoutOptionalFieldsIsRefused) {
  Pairing pairing;
  const auto req = pairing.two.request();
  const auto rep = pairing.two.reply(*req->message);
  ASSERT_OK(rep);
  const Token bare = without(without(without(*rep->message, "hash_c1"), "hash_c2"), "dh1");
  for (const auto& property : bare.binary_properties) {
    const std::size_t step = property.value.size() > 200 ? 7 : 1;
    for (std::size_t at = 0; at < property.value.size(); at += step)
      EXPECT_FALSE(
          pairing.two.at_low(req->handle, with(bare, property.name, flipped(property.value, at))))
          << property.name << " " << at;
  }
  const auto fin = pairing.two.at_low(req->handle, bare);
  ASSERT_OK(fin);
  ASSERT_OK(pairing.two.at_high(rep->handle, *fin->message));
}

TEST(FlippedBit, AnywhereInAFinalIsRefused) {
  Pairing pairing;
  const auto req = pairing.two.request();
  const auto rep = pairing.two.reply(*req->message);
  const auto fin = pairing.two.at_low(req->handle, *rep->message);
  ASSERT_OK(fin);
  for (const auto& property : fin->message->binary_properties)
    for (std::size_t at = 0; at < property.value.size(); ++at)
      EXPECT_FALSE(pairing.two.at_high(
          rep->handle, with(*fin->message, property.name, flipped(property.value, at))))
          << property.name << " " << at;
  ASSERT_OK(pairing.two.at_high(rep->handle, *fin->message));
}

// A request is not signed: what was changed in it must be noticed in the reply.
TEST(FlippedBit, InARequestThatIsAnsweredMakesTheInitiatorRefuse) {
  for (const auto* name : {"c.perm", "challenge1"}) {
    Pairing pairing;
    const auto req = pairing.two.request();
    Token changed = without(*req->message, "hash_c1");
    changed = with(changed, name, flipped(field(changed, name), 0));
    const auto rep = pairing.two.reply(changed);
    ASSERT_OK(rep);
    const auto refused = pairing.two.at_low(req->handle, *rep->message);
    EXPECT_CODE(refused, token_field_differs);
    const auto honest = pairing.two.reply(*req->message);
    ASSERT_OK(honest);
    pairing.expect_finish(*req, *honest);
  }
}

// ---- wrong state

TEST(WrongState, EveryMessageThatDoesNotFitIsRefused) {
  Pairing pairing;
  const auto req = pairing.two.request();
  const auto rep = pairing.two.reply(*req->message);
  const auto fin = pairing.two.at_low(req->handle, *rep->message);
  ASSERT_OK(fin);
  const auto req2 = Pairing().two.request();
  // Established, initiator.
  EXPECT_CODE(pairing.two.at_low(req->handle, *req->message), unexpected_message);
  EXPECT_CODE(pairing.two.at_low(req->handle, *fin->message), unexpected_message);
  EXPECT_CODE(pairing.two.at_low(req->handle, with(*rep->message, "signature", Bytes(70))),
              unexpected_message);
  // Waiting for a final.
  EXPECT_CODE(pairing.two.at_high(rep->handle, *rep->message), unexpected_message);
  EXPECT_CODE(pairing.two.at_high(rep->handle, *req2->message), unexpected_message);
  ASSERT_OK(pairing.two.at_high(rep->handle, *fin->message));
  // Established, replier.
  EXPECT_CODE(pairing.two.at_high(rep->handle, *req->message), unexpected_message);
  EXPECT_CODE(pairing.two.at_high(rep->handle, *rep->message), unexpected_message);
  EXPECT_CODE(pairing.two.at_high(rep->handle, with(*fin->message, "signature", Bytes(70))),
              unexpected_message);
  EXPECT_CODE(pairing.two.reply(*req->message), unexpected_message);
}

TEST(WrongState, AnInitiatorWaitingForAReplyTakesNothingElse) {
  Pairing pairing, other;
  const auto req = pairing.two.request();
  const auto rep = pairing.two.reply(*req->message);
  const auto req2 = other.two.request();
  const auto rep2 = other.two.reply(*req2->message);
  const auto fin2 = other.two.at_low(req2->handle, *rep2->message);
  ASSERT_OK(fin2);
  EXPECT_CODE(pairing.two.at_low(req->handle, *req->message), unexpected_message);
  EXPECT_CODE(pairing.two.at_low(req->handle, *fin2->message), unexpected_message);
  EXPECT_CODE(pairing.two.at_low(req->handle, {"DDS:Auth:PKI-DH:1.0"}), token_class_wrong);
  EXPECT_CODE(pairing.two.at_low(req->handle, {"DDS:Auth:PKI-DH:1.0+AuthReq"}), token_class_wrong);
  pairing.expect_finish(*req, *rep);
}

TEST(WrongState, RolesAreDecidedByTheGuids) {
  Pairing pairing;
  auto& two = pairing.two;
  EXPECT_CODE(
      (*two.high.engine)->begin_handshake_request(two.high.handle, two.low_at_high, two.high.data),
      handshake_role_wrong);
  const auto req = two.request();
  EXPECT_CODE(
      (*two.low.engine)
          ->begin_handshake_reply(*req->message, two.high_at_low, two.low.handle, two.low.data),
      handshake_role_wrong);
}

TEST(WrongState, OwnParticipantDataMustFit) {
  Pairing pairing;
  auto& two = pairing.two;
  for (const std::size_t size : {0u, 64u * 1024 + 1})
    EXPECT_CODE(
        (*two.low.engine)->begin_handshake_request(two.low.handle, two.high_at_low, Bytes(size)),
        token_field_length);
  EXPECT_CODE((*two.high.engine)->begin_handshake_reply({}, two.low_at_high, two.high.handle, {}),
              token_field_length);
}

// ---- repetitions

TEST(Repetition, GetsTheSameAnswerWithoutNewKeys) {
  Pairing pairing;
  const auto req = pairing.two.request();
  const auto again = pairing.two.request();
  ASSERT_OK(again);
  EXPECT_EQ(again->handle, req->handle);
  EXPECT_EQ(again->message, req->message);
  const auto rep = pairing.two.reply(*req->message);
  const auto rep_again = pairing.two.reply(*req->message);
  ASSERT_OK(rep_again);
  EXPECT_EQ(rep_again->handle, rep->handle);
  EXPECT_EQ(rep_again->message, rep->message);
  const auto by_process = pairing.two.at_high(rep->handle, *req->message);
  ASSERT_OK(by_process);
  EXPECT_EQ(by_process->message, rep->message);
  EXPECT_EQ(by_process->result, ValidationResult::pending_handshake_message);
  const auto fin = pairing.two.at_low(req->handle, *rep->message);
  const auto fin_again = pairing.two.at_low(req->handle, *rep->message);
  ASSERT_OK(fin_again);
  EXPECT_EQ(fin_again->message, fin->message);
  EXPECT_EQ(fin_again->result, ValidationResult::ok_final_message);
  ASSERT_OK(pairing.two.at_high(rep->handle, *fin->message));
  const auto end_again = pairing.two.at_high(rep->handle, *fin->message);
  ASSERT_OK(end_again);
  EXPECT_EQ(end_again->result, ValidationResult::ok);
}

// ---- announced challenges

TEST(FutureChallenge, BindsTheHandshake) {
  Pairing pairing;
  auto& two = pairing.two;
  const auto of_low = two.low.discover(two.high);
  const auto of_high = two.high.discover(two.low);
  ASSERT_TRUE(of_low->local_auth_request && of_high->local_auth_request);
  const auto told_low = two.low.discover(two.high, of_high->local_auth_request);
  const auto told_high = two.high.discover(two.low, of_low->local_auth_request);
  ASSERT_OK(told_low);
  ASSERT_OK(told_high);
  EXPECT_FALSE(told_low->local_auth_request);
  EXPECT_EQ(told_low->handle, of_low->handle);
  const auto req = two.request();
  EXPECT_EQ(field(*req->message, "challenge1"),
            field(*of_low->local_auth_request, "future_challenge"));
  pairing.expect_success();
}

TEST(FutureChallenge, AnotherOneIsRefusedInBothRoles) {
  Pairing pairing;
  auto& two = pairing.two;
  const Token forged{.class_id = "DDS:Auth:PKI-DH:1.0+AuthReq",
                     .binary_properties = {{"future_challenge", Bytes(32, 9)}}};
  ASSERT_OK(two.high.discover(two.low, forged));
  const auto req = two.request();
  EXPECT_CODE(two.reply(*req->message), challenge_not_announced);
  // The honest announcement mends it.
  ASSERT_OK(two.high.discover(two.low, two.low.discover(two.high)->local_auth_request));
  const auto rep = two.reply(*req->message);
  ASSERT_OK(rep);
  ASSERT_OK(two.low.discover(two.high, forged));
  EXPECT_CODE(two.at_low(req->handle, *rep->message), challenge_not_announced);
  ASSERT_OK(two.low.discover(two.high, two.high.discover(two.low)->local_auth_request));
  pairing.expect_finish(*req, *rep);
}

TEST(FutureChallenge, AMalformedOneIsRefused) {
  Pairing pairing;
  EXPECT_CODE(pairing.a.discover(pairing.b, Token{"DDS:Auth:PKI-DH:1.0+AuthReq"}),
              token_field_missing);
}

// ---- remote identities

TEST(RemoteIdentity, Refusals) {
  Pairing pairing;
  auto& a = pairing.a;
  auto& engine = *a.engine;
  Token wrong = pairing.b.token;
  wrong.class_id = "DDS:Auth:PKI-DH:2.0";
  EXPECT_CODE(engine->validate_remote_identity(a.handle, {}, wrong, candidate(0x85)),
              token_class_wrong);
  EXPECT_CODE(engine->validate_remote_identity(a.handle, {}, pairing.b.token, candidate(0x05)),
              guid_not_adjusted);
  EXPECT_CODE(engine->validate_remote_identity(a.handle, {}, pairing.b.token, a.guid),
              remote_guid_is_local);
  EXPECT_CODE(engine->validate_remote_identity({99}, {}, pairing.b.token, pairing.b.guid),
              unknown_identity);
}

TEST(RemoteIdentity, AnotherTokenIsRefusedOnlyAfterSomebodyAuthenticated) {
  Pairing pairing;
  auto& two = pairing.two;
  auto& engine = *two.low.engine;
  Token other = two.high.token;
  other.properties[0].value = "/CN=forged";
  const auto replaced = engine->validate_remote_identity(two.low.handle, {}, other, two.high.guid);
  ASSERT_OK(replaced);
  EXPECT_EQ(replaced->handle, two.high_at_low);
  ASSERT_OK(two.low.discover(two.high));
  pairing.expect_success();
  EXPECT_CODE(engine->validate_remote_identity(two.low.handle, {}, other, two.high.guid),
              identity_token_changed);
  // The same one still is the same one; after it left, a restarted peer may come with another.
  ASSERT_OK(two.low.discover(two.high));
  ASSERT_OK(engine->return_identity_handle(two.high_at_low));
  const auto fresh = engine->validate_remote_identity(two.low.handle, {}, other, two.high.guid);
  ASSERT_OK(fresh);
  EXPECT_NE(fresh->handle, two.high_at_low);
}

TEST(RemoteIdentity, OfAnotherCaIsRefused) {
  static const pki::Authority other_ca = make_ca("CN=Other CA");
  Pairing pairing(make_identity(test_ca(), "CN=alice"),
                  make_identity(other_ca, "CN=bob", {}, kYear, 1));
  const auto req = pairing.two.request();
  EXPECT_CODE(pairing.two.reply(*req->message), issuer_unknown);
}

// The subject's text is on the event as soon as it is proven.
TEST(RemoteIdentity, EventsNameThePeer) {
  Pairing pairing;
  pairing.expect_success();
  auto& two = pairing.two;
  EXPECT_CODE(two.reply(Token{"DDS:Auth:PKI-DH:1.0+Req"}), token_field_missing);
  const auto& event = two.high.engine->events.events.back();
  EXPECT_EQ(event.peer_subject, &two.low == &pairing.a ? "CN=alice,O=Example" : "CN=bob,O=Example");
  EXPECT_EQ(event.guid, two.low.guid.to_string());
}

}  // namespace
}  // namespace ddssec::authentication
