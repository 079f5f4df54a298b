// The domain that a peer signs: an announcement that was copied into another domain joins no two
// participants.
#include "plugins/authentication/participant_data.hpp"
#include "tests/unit/authentication/authentication_fixture.hpp"

namespace ddssec::authentication {
namespace {

constexpr VendorId kDdssec{0x01, 0xd5};

// Returns c.pdata of a participant in a domain with a tag; "": without the parameter.
Bytes data_in_domain(const Participant& participant, std::optional<std::uint32_t> domain,
                     std::string_view tag, const VendorId& vendor = kCycloneDds) {
  Writer writer(Endian::big);
  if (domain) {
    writer.write(std::uint16_t{0x000f});
    writer.write(std::uint16_t{4});
    writer.write(*domain);
  }
  auto rest = participant_data(participant.guid, &participant.token, vendor);
  if (!tag.empty()) {
    // The tag takes the place of the fixture's empty tag, which is the last parameter.
    constexpr std::size_t kEmptyTag = 12, kSentinel = 4;
    rest.resize(rest.size() - kEmptyTag - kSentinel);
    Bytes text = to_bytes(as_bytes(tag));
    text.resize(tag.size() / 4 * 4 + 4);  // a NUL, and up to three octets of padding
    writer.write(std::uint16_t{0x4014});
    writer.write(static_cast<std::uint16_t>(4 + text.size()));
    writer.write(static_cast<std::uint32_t>(tag.size() + 1));
    writer.write_bytes(text);
  }
  auto out = writer.take();
  out.insert(out.end(), rest.begin(), rest.end());
  return out;
}

// Returns the codes with which the initiator refuses the reply, and the replier the final message.
std::pair<std::optional<Code>, std::optional<Code>> refusals(Pairing& pairing) {
  const auto request = pairing.two.request();
  EXPECT_TRUE(request);
  const auto reply = pairing.two.reply(*request->message);
  EXPECT_TRUE(reply);
  const auto final = pairing.two.process_at_lower_guid(request->handle, *reply->message);
  if (!final) return {final.error().code(), std::nullopt};
  const auto end = pairing.two.process_at_higher_guid(reply->handle, *final->message);
  return {std::nullopt, end ? std::nullopt : std::optional(end.error().code())};
}

struct Case {
  std::optional<std::uint32_t> low, high;
  std::string low_tag, high_tag;
  VendorId high_vendor = kCycloneDds;
  bool is_same = true;
};

TEST(SignedDomain, OtherIdOrTag_IsRefusedOnceItIsProven) {
  const std::optional<std::uint32_t> none;
  for (const auto& one : std::vector<Case>{
           {7, 7, "", ""},
           {7, none, "", ""},
           {none, 8, "", ""},
           {7, 8, "", "", kCycloneDds, false},
           {7, 7, "real", "real"},
           {7, 7, "real", "simu", kCycloneDds, false},
           {7, 7, "real", "", kCycloneDds, false},
           {7, 7, "", "real", kCycloneDds, false},
           {7, 7, "real", "", kDdssec, false},
           {7, 8, "", "", kFastDds, false},
       }) {
    Pairing pairing;
    pairing.two.low.data = data_in_domain(pairing.two.low, one.low, one.low_tag);
    pairing.two.high.data =
        data_in_domain(pairing.two.high, one.high, one.high_tag, one.high_vendor);
    const auto [process_at_lower_guid, process_at_higher_guid] = refusals(pairing);
    const auto expected = one.is_same ? std::nullopt : std::optional(Code::rtps_domain_differs);
    EXPECT_EQ(process_at_lower_guid ? process_at_lower_guid : process_at_higher_guid, expected)
        << one.low_tag << " and " << one.high_tag << " of " << int(one.high_vendor[1]);
  }
}

// Fast DDS signs no tag, so the initiator finds no difference. The replier knows that it has no tag
// itself.
TEST(SignedDomain, ReplierAlone_RefusesToo) {
  Pairing pairing;
  pairing.two.low.data = data_in_domain(pairing.two.low, 7, "real");
  pairing.two.high.data = data_in_domain(pairing.two.high, 7, "", kFastDds);
  EXPECT_EQ(refusals(pairing),
            std::pair(std::optional<Code>(), std::optional(Code::rtps_domain_differs)));
}

// Once the first value is the honest one, and once the last one is. Neither counts.
TEST(SignedDomain, ParameterThatComesTwice_IsRefused) {
  const auto own = domain_in_participant_data(Bytes{0, 0x0f, 0, 4, 0, 0, 0, 7});
  ASSERT_OK(check_same_domain(own, own));
  const Bytes seven = {0, 0x0f, 0, 4, 0, 0, 0, 7}, eight = {0, 0x0f, 0, 4, 0, 0, 0, 8};
  const Bytes tag = {0x40, 0x14, 0, 8, 0, 0, 0, 1, 0, 0, 0, 0},
              vendor = {0, 0x16, 0, 4, 1, 15, 0, 0};
  const auto joined = [](const Bytes& one, const Bytes& other) {
    Bytes out = one;
    out.insert(out.end(), other.begin(), other.end());
    return out;
  };
  for (const auto& list : {joined(seven, eight), joined(eight, seven), joined(seven, seven),
                           joined(tag, tag), joined(vendor, vendor)}) {
    const auto refused = check_same_domain(domain_in_participant_data(list), own);
    ASSERT_FALSE(refused) << to_hex(list);
    EXPECT_EQ(refused.error().code(), Code::rtps_domain_differs);
    EXPECT_THAT(refused.error().to_sentence(), testing::HasSubstr("comes twice"));
  }
}

TEST(SignedDomain, Refusal_NamesBothDomains) {
  const auto refused = check_same_domain({7, "real", false}, {8, "", false});
  ASSERT_FALSE(refused);
  const auto sentence = refused.error().to_sentence();
  EXPECT_THAT(sentence, testing::HasSubstr("domain 7, tag \"real\""));
  EXPECT_THAT(sentence, testing::HasSubstr("domain 8, tag \"\""));
}

}  // namespace
}  // namespace ddssec::authentication
