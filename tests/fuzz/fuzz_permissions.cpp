// A permissions document is read or refused. What was read is written and read alike.
#include <algorithm>
#include <cstdlib>

#include "governance/read.hpp"
#include "governance/write.hpp"

namespace {

using namespace ddssec;
using namespace ddssec::governance;

bool same(const Criteria& a, const Criteria& b) {
  return a.topics == b.topics && a.partitions == b.partitions && a.data_tags == b.data_tags;
}
bool same(const std::vector<Criteria>& a, const std::vector<Criteria>& b) {
  return std::ranges::equal(a, b, [](const auto& x, const auto& y) { return same(x, y); });
}
bool same(const GrantRule& a, const GrantRule& b) {
  return a.allow == b.allow && a.domains == b.domains && same(a.publish, b.publish) &&
         same(a.subscribe, b.subscribe) && same(a.relay, b.relay);
}
bool same(const Grant& a, const Grant& b) {
  // A grant without a name gets one when it is written.
  return (a.name == b.name || a.name.empty()) && a.subject_name == b.subject_name &&
         a.subject_is_expression == b.subject_is_expression && a.validity == b.validity &&
         a.default_allow == b.default_allow &&
         std::ranges::equal(a.rules, b.rules,
                            [](const auto& x, const auto& y) { return same(x, y); });
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto first = read_permissions({data, size});
  if (!first) return 0;
  const auto again = read_permissions(as_bytes(to_xml(*first)));
  if (!again || !std::ranges::equal(first->grants, again->grants,
                                    [](const auto& a, const auto& b) { return same(a, b); }))
    std::abort();
  return 0;
}
