// OCSP responses in handshakes: what the response of a peer means under each policy.
#include "pki/renewal_list.hpp"
#include "tests/unit/authentication/ocsp_responses.hpp"

namespace ddssec::authentication {
namespace {

// Two participants that shake hands. What each of them sends is changed on the way.
struct Meeting {
  Meeting(const Identity& first, const Identity& second) : pairing(first, second) {}

  using Change = std::function<Token(Token)>;
  static Change replace(std::optional<Bytes> response) {
    return [=](Token token) {
      return response ? with(std::move(token), "ocsp_status", *response)
                      : without(std::move(token), "ocsp_status");
    };
  }
  // Returns the first error of the handshake.
  Status meet(const Change& request_change, const Change& reply_change) {
    auto& two = pairing.two;
    DDSSEC_ASSIGN_OR_RETURN(const auto request, two.request());
    DDSSEC_ASSIGN_OR_RETURN(const auto reply, two.reply(request_change(*request.message)));
    DDSSEC_ASSIGN_OR_RETURN(
        const auto final, two.process_at_lower_guid(request.handle, reply_change(*reply.message)));
    DDSSEC_RETURN_IF_ERROR(two.process_at_higher_guid(reply.handle, *final.message));
    return {};
  }
  // Both present the response that `response` returns for their certificate.
  Status meet_with(const std::function<std::optional<Bytes>(const pki::Certificate&)>& response) {
    const auto& low = pairing.two.low.guid == pairing.a.guid ? alice() : bob();
    const auto& high = pairing.two.low.guid == pairing.a.guid ? bob() : alice();
    return meet(replace(response(low.certificate)), replace(response(high.certificate)));
  }
  int events_of(Code code) const {
    return count_of(pairing.first_plugin.events, code) +
           count_of(pairing.second_plugin.events, code);
  }
  Pairing pairing;
};

// ---- the policies

struct OcspPolicies : testing::TestWithParam<bool> {
  // Only one side demands a response: that of the request or that of the reply.
  Status meet(const std::string& policy,
              std::optional<Bytes> (*response)(const pki::Certificate&)) {
    Meeting meeting(GetParam() ? with_policy(alice(), policy) : with_policy(alice(), "ignore"),
                    GetParam() ? with_policy(bob(), "ignore") : with_policy(bob(), policy));
    const auto status = meeting.meet_with(response);
    unused = meeting.events_of(Code::ocsp_status_unused);
    return status;
  }
  int unused = 0;
};
INSTANTIATE_TEST_SUITE_P(OfEitherSide, OcspPolicies, testing::Bool());

using Response = std::optional<Bytes>;
Response good(const pki::Certificate& of) { return response_about(of); }
Response none(const pki::Certificate&) { return {}; }
Response revoked(const pki::Certificate& of) {
  return response_about(of, V_OCSP_CERTSTATUS_REVOKED);
}
Response expired(const pki::Certificate& of) {
  return response_about(of, V_OCSP_CERTSTATUS_GOOD, -48h, -24h);
}
Response unknown(const pki::Certificate& of) {
  return response_about(of, V_OCSP_CERTSTATUS_UNKNOWN);
}
Response of_another(const pki::Certificate&) { return response_about(test_ca().certificate()); }
Response garbage(const pki::Certificate&) { return Bytes(100, 0x41); }
Response empty(const pki::Certificate&) { return Bytes(); }
Response too_long(const pki::Certificate&) { return Bytes(pki::kMaxOcspOctets + 1, 0x30); }

TEST_P(OcspPolicies, Hard_WantsAGoodResponse) {
  EXPECT_TRUE(meet("hard", good));
  EXPECT_CODE(meet("hard", none), ocsp_status_missing);
  EXPECT_CODE(meet("hard", revoked), ocsp_revoked);
  EXPECT_CODE(meet("hard", expired), ocsp_expired);
  EXPECT_CODE(meet("hard", unknown), ocsp_unknown);
  EXPECT_CODE(meet("hard", of_another), ocsp_other_certificate);
  EXPECT_CODE(meet("hard", garbage), ocsp_malformed);
  EXPECT_CODE(meet("hard", empty), ocsp_malformed);
  EXPECT_CODE(meet("hard", too_long), ocsp_too_large);
}

// DDS-Security 1.2, Table 59: "revoked" and "good" count, and everything else is treated as a
// missing response.
TEST_P(OcspPolicies, Soft_RefusesARevokedPeerOnly) {
  EXPECT_TRUE(meet("soft", good));
  EXPECT_EQ(unused, 0);
  EXPECT_TRUE(meet("soft", none));
  EXPECT_EQ(unused, 0);
  EXPECT_CODE(meet("soft", revoked), ocsp_revoked);
  for (const auto response : {expired, unknown, of_another, garbage, empty, too_long}) {
    EXPECT_TRUE(meet("soft", response));
    EXPECT_EQ(unused, 1);
  }
}

TEST_P(OcspPolicies, Ignore_LooksAtNothing) {
  EXPECT_TRUE(meet("ignore", revoked));
  EXPECT_TRUE(meet("ignore", garbage));
  EXPECT_TRUE(meet("ignore", too_long));
  EXPECT_EQ(unused, 0);
}

TEST(OcspPolicy, MissingPolicy_IsSoftAndUnknownWordsAreRefused) {
  Meeting meeting(alice(), bob());
  EXPECT_CODE(meeting.meet_with(revoked), ocsp_revoked);
  for (const auto* value : {"", "Hard", "true", "none"}) {
    TestPlugin plugin;
    EXPECT_CODE(
        plugin->validate_local_identity(0, with_policy(alice(), value).properties, candidate(1)),
        invalid_property);
  }
}

// A stranger that copies messages cannot end an honest handshake.
TEST(OcspStatus, GarbageInACopyOfARequest_LeavesTheHonestOneAlone) {
  Meeting meeting(with_policy(alice(), "hard"), with_policy(bob(), "hard"));
  auto& two = meeting.pairing.two;
  const auto& low = two.low.guid == meeting.pairing.a.guid ? alice() : bob();
  const auto& high = two.low.guid == meeting.pairing.a.guid ? bob() : alice();
  const auto showing = [](const Token& token, const Identity& of) {
    return with(token, "ocsp_status", response_about(of.certificate));
  };
  const auto request = two.request();
  ASSERT_OK(request);
  EXPECT_CODE(two.reply(*request->message), ocsp_status_missing);
  EXPECT_CODE(two.reply(with(*request->message, "ocsp_status", Bytes(9))), ocsp_malformed);
  const auto reply = two.reply(showing(*request->message, low));
  ASSERT_OK(reply);
  // The same request without its response gets the same reply, because the request was already
  // judged.
  ASSERT_OK(two.reply(*request->message));
  EXPECT_CODE(two.process_at_lower_guid(request->handle, *reply->message), ocsp_status_missing);
  EXPECT_CODE(
      two.process_at_lower_guid(request->handle, with(*reply->message, "ocsp_status", Bytes(9))),
      ocsp_malformed);
  auto honest = *reply;
  honest.message = showing(*reply->message, high);
  meeting.pairing.expect_finish(*request, honest);
}

TEST(OcspStatus, Twice_IsRefused) {
  Meeting meeting(alice(), bob());
  const auto request = meeting.pairing.two.request();
  ASSERT_OK(request);
  auto twice = *request->message;
  for (int i = 0; i < 2; ++i) twice.binary_properties.push_back({"ocsp_status", Bytes(1)});
  EXPECT_CODE(meeting.pairing.two.reply(twice), token_field_repeated);
}

TEST(OcspStatus, GoodResponse_DoesNotHelpACertificateOnAList) {
  const std::array listed = {alice().certificate, bob().certificate};
  const auto crl =
      test_ca().make_crl({.revoked = listed, .this_update = kNow - 1h, .next_update = kNow + 24h});
  auto carol = make_identity(test_ca(), "CN=carol,O=Example", {}, kYear, 2);
  set(carol.properties, spi::property::kCrl, "data:," + crl->pem());
  Meeting meeting(with_policy(carol, "hard"), bob());
  auto& two = meeting.pairing.two;
  const auto request = two.request();
  ASSERT_OK(request);
  const bool carol_begins = two.low.guid == meeting.pairing.a.guid;
  const auto change =
      Meeting::replace(response_about(carol_begins ? carol.certificate : bob().certificate));
  const auto reply = two.reply(change(*request->message));
  if (!carol_begins) {
    EXPECT_CODE(reply, certificate_revoked);
    return;
  }
  ASSERT_OK(reply);
  EXPECT_CODE(two.process_at_lower_guid(request->handle, with(*reply->message, "ocsp_status",
                                                              response_about(bob().certificate))),
              certificate_revoked);
}

// A renewal list contains no OCSP responses.
TEST(RenewalListUnderOcsp, ListWithoutTheDemandedResponse_KeepsNoPeer) {
  for (const auto* const policy : {"hard", "soft"}) {
    const test::TemporaryFolder folder;
    const auto short_lived =
        make_identity(test_ca(), "CN=bob,O=Example", {}, {kNow - 24h, kNow + 20s}, 1);
    const auto renewed =
        make_identity(test_ca(), "CN=bob,O=Example", {}, {kNow, kNow + 24h}, 1).certificate;
    auto demanding = with_policy(alice(), policy);
    const pki::RenewalList list{.certificates = {renewed}};
    set(demanding.properties, spi::property::kRenewalList,
        "file:" + folder.write("renewed.pem", list.text().value()));
    Meeting meeting(demanding, short_lived);
    auto& pairing = meeting.pairing;
    const bool alice_is_low = pairing.two.low.guid == pairing.a.guid;
    const auto& low = alice_is_low ? alice().certificate : short_lived.certificate;
    const auto& high = alice_is_low ? short_lived.certificate : alice().certificate;
    ASSERT_OK(meeting.meet(Meeting::replace(good(low)), Meeting::replace(good(high))));
    pairing.first_plugin.clock.advance(20s);
    EXPECT_EQ(pairing.first_plugin->poll().size(), policy == std::string_view("hard") ? 1u : 0u);
  }
}

}  // namespace
}  // namespace ddssec::authentication
