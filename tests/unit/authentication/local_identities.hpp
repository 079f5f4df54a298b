// Identities that are made from properties, and the faults for which they must be refused.
#pragma once

#include "tests/unit/authentication/authentication_fixture.hpp"

namespace ddssec::authentication::local_identities {

namespace property = spi::property;

inline Result<spi::Authentication::LocalIdentity> create(const PropertyList& properties,
                                                         TestPlugin& plugin) {
  return plugin->validate_local_identity(0, properties, candidate(1));
}

inline Result<spi::Authentication::LocalIdentity> create(const PropertyList& properties) {
  TestPlugin plugin;
  return create(properties, plugin);
}

/// Expects a refusal with exactly this code, about exactly this property.
inline void expect_refused(const PropertyList& properties, Code code, std::string_view document) {
  TestPlugin plugin;
  const auto result = create(properties, plugin);
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code(), code) << result.error().to_sentence();
  EXPECT_EQ(result.error().details().document, document) << result.error().to_sentence();
  ASSERT_EQ(plugin.events.all.size(), 1u);
  EXPECT_EQ(plugin.events.all[0].error.code(), code);
  EXPECT_TRUE(plugin.events.all[0].is_returned);
  EXPECT_FALSE(plugin->next_expiry());
}

}  // namespace ddssec::authentication::local_identities
