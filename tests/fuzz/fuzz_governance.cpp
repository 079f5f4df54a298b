// A governance document is read or refused. What was read is written and read alike.
#include <algorithm>
#include <cstdlib>

#include "governance/read.hpp"
#include "governance/write.hpp"

namespace {

using namespace ddssec;
using namespace ddssec::governance;

bool same(const TopicRule& a, const TopicRule& b) {
  return a.topic_expression == b.topic_expression &&
         a.enable_discovery_protection == b.enable_discovery_protection &&
         a.enable_liveliness_protection == b.enable_liveliness_protection &&
         a.enable_read_access_control == b.enable_read_access_control &&
         a.enable_write_access_control == b.enable_write_access_control &&
         a.metadata_protection_kind == b.metadata_protection_kind &&
         a.data_protection_kind == b.data_protection_kind;
}

bool same(const std::optional<AllowedAlgorithms>& a, const std::optional<AllowedAlgorithms>& b) {
  if (!a || !b) return a.has_value() == b.has_value();
  return a->digital_signature == b->digital_signature &&
         a->digital_signature_identity_trust_chain == b->digital_signature_identity_trust_chain &&
         a->key_establishment == b->key_establishment && a->symmetric_cipher == b->symmetric_cipher;
}

bool same(const DomainRule& a, const DomainRule& b) {
  return a.domains == b.domains &&
         a.allow_unauthenticated_participants == b.allow_unauthenticated_participants &&
         a.enable_join_access_control == b.enable_join_access_control &&
         a.enable_key_revision == b.enable_key_revision &&
         a.discovery_protection_kind == b.discovery_protection_kind &&
         a.liveliness_protection_kind == b.liveliness_protection_kind &&
         a.rtps_protection_kind == b.rtps_protection_kind &&
         a.rtps_psk_protection_kind == b.rtps_psk_protection_kind &&
         same(a.allowed_algorithms, b.allowed_algorithms) &&
         std::ranges::equal(a.topic_rules, b.topic_rules,
                            [](const auto& x, const auto& y) { return same(x, y); });
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto first = read_governance({data, size});
  if (!first) return 0;
  const auto again = read_governance(as_bytes(to_xml(*first)));
  if (!again || !std::ranges::equal(first->domain_rules, again->domain_rules,
                                    [](const auto& a, const auto& b) { return same(a, b); }))
    std::abort();
  return 0;
}
