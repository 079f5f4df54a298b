// Hashes and signature inputs, against the vectors of the reference.
#include "plugins/authentication/transcript.hpp"

#include "tests/unit/authentication/authentication_fixture.hpp"

namespace ddssec::authentication {
namespace {

TEST(SignatureInput, EachMessage_NamesTheSixValuesInTheStandardsOrder) {
  const Transcript transcript{.dh1 = {1}, .dh2 = {2}};
  const auto reply = transcript.reply_input();
  const auto final = transcript.final_input();
  EXPECT_EQ(reply.size(), final.size());
  const auto order = [](BytesView octets, std::vector<std::string_view> names) {
    std::size_t at = 0;
    for (const auto name : names) {
      const auto found = as_text(octets).find(name, at);
      ASSERT_NE(found, std::string_view::npos) << name;
      at = found;
    }
  };
  order(reply, {"hash_c2", "challenge2", "dh2", "challenge1", "dh1", "hash_c1"});
  order(final, {"hash_c1", "challenge1", "dh1", "challenge2", "dh2", "hash_c2"});
}

}  // namespace
}  // namespace ddssec::authentication
