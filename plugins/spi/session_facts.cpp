#include "plugins/spi/session_facts.hpp"

#include <algorithm>
#include <string>

namespace ddssec::spi {
namespace {

constexpr std::string_view kPresentedPermissions = "org.ddssec.presented_permissions";
constexpr std::string_view kPeerKeepsSession = "org.ddssec.peer_keeps_session";
constexpr std::string_view kPeerReadsLists = "org.ddssec.peer_reads_lists";

}  // namespace

void add_session_facts(Token& credential, const SessionFacts& facts) {
  if (const auto& digest = facts.presented_permissions)
    credential.properties.push_back({std::string(kPresentedPermissions), to_hex(*digest), false});
  if (facts.peer_keeps_session)
    credential.properties.push_back({std::string(kPeerKeepsSession), "true", false});
  if (facts.peer_reads_lists)
    credential.properties.push_back({std::string(kPeerReadsLists), "true", false});
}

SessionFacts session_facts_in(const Token& credential) {
  SessionFacts facts;
  const auto hex = property_value(credential.properties, kPresentedPermissions);
  const auto digest = hex.size() == 2 * Sha256Digest{}.size() ? from_hex(hex) : std::nullopt;
  if (digest && digest->size() == Sha256Digest{}.size())
    std::ranges::copy(*digest, facts.presented_permissions.emplace().begin());
  facts.peer_keeps_session = property_value(credential.properties, kPeerKeepsSession) == "true";
  facts.peer_reads_lists = property_value(credential.properties, kPeerReadsLists) == "true";
  return facts;
}

}  // namespace ddssec::spi
