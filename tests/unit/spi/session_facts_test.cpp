#include "plugins/spi/session_facts.hpp"

#include <gtest/gtest.h>

namespace ddssec::spi {
namespace {

Sha256Digest digest() {
  Sha256Digest out{};
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = static_cast<std::uint8_t>(i * 9);
  return out;
}

TEST(SessionFacts, Added_AreFoundAgainAsText) {
  for (const bool keeps : {false, true}) {
    Token token{.properties = {{"c.perm", "a document"}}};
    add_session_facts(token, {.presented_permissions = digest(), .peer_keeps_session = keeps});
    EXPECT_TRUE(token.binary_properties.empty()) << "Cyclone DDS has only text in this token";
    const auto facts = session_facts_in(token);
    EXPECT_EQ(facts.presented_permissions, digest());
    EXPECT_EQ(facts.peer_keeps_session, keeps);
  }
}

TEST(SessionFacts, Added_AreNotSent) {
  Token token{.properties = {{"c.perm", "a document"}}};
  Writer before(Endian::big);
  write_token(before, token);
  add_session_facts(token, {.presented_permissions = digest(), .peer_keeps_session = true});
  Writer after(Endian::big);
  write_token(after, token);
  EXPECT_EQ(before.take(), after.take());
}

TEST(SessionFacts, MissingOrMalformed_AreNone) {
  const std::string name = "org.ddssec.presented_permissions";
  for (const auto& value : {std::string(), std::string("00"), std::string(64, 'x'),
                            std::string(62, '0'), std::string(66, '0'), std::string(128, '0')}) {
    const auto facts = session_facts_in({.properties = {{name, value}}});
    EXPECT_FALSE(facts.presented_permissions) << value;
    EXPECT_FALSE(facts.peer_keeps_session);
  }
  const Token other{.properties = {{"org.ddssec.peer_keeps_session", "yes"}}};
  EXPECT_FALSE(session_facts_in(other).peer_keeps_session);
}

}  // namespace
}  // namespace ddssec::spi
