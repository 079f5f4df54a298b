// Rewrites documents as stock products read them, in the standard's terms: ddssec's decisions by
// the rewritten document are those of the product.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "governance/model.hpp"

namespace ddssec::governance {

enum class StockProduct : std::uint8_t { cyclonedds, fastdds };
inline constexpr StockProduct kStockProducts[] = {StockProduct::cyclonedds, StockProduct::fastdds};
/// Returns "Cyclone DDS" or "Fast DDS".
std::string_view to_string(StockProduct product);

/// Returns a governance document as the product reads it; empty if nothing changes. A range of
/// domains without <max> becomes one domain. An expression that the product reads in its own way
/// becomes one that matches the same names (dialect.hpp); for Fast DDS, one between blanks becomes
/// one that matches none.
std::optional<Governance> rewritten_for(const Governance& document, StockProduct product);

/// Returns the validity as the product reads it. Cyclone DDS reads some ends as times long past.
/// Fast DDS ignores zones; its local time is taken to be UTC here.
Validity rewritten_for(const Validity& validity, StockProduct product);

/// Returns a permissions document as the product reads it; empty if nothing changes. Ranges,
/// expressions and validities are read as above.
/// - Cyclone DDS applies a deny_rule without partitions to the partition "" only, and ignores
///   <tag>.
/// - Fast DDS denies in all partitions, and reads every <default> as DENY. A topic and its
///   partitions may be in different elements of one rule. The first rule with the topic decides, so
///   each allow_rule is followed by a deny_rule for its topics.
std::optional<Permissions> rewritten_for(const Permissions& document, StockProduct product);

/// Two documents as Fast DDS applies them to the endpoints of its own process: there rules for
/// other domains count too (measured with 2.9.1), so each rule is for every domain that an
/// allow_rule of the two is for. To peers it applies them differently.
struct PermissionsOfOwnEndpoints {
  Permissions before, after;
};
/// Returns the two documents as Fast DDS applies them to the endpoints of its own process. Empty if
/// all rules of each grant are for the same domains.
std::optional<PermissionsOfOwnEndpoints> rewritten_for_own_endpoints_of_fastdds(
    const Permissions& before, const Permissions& after);

/// Returns a part of a document with the expressions of its topics and partitions as the product
/// reads them; everything else stays. Empty if nothing changes.
std::optional<DomainRule> rewritten_expressions(const DomainRule& rule, StockProduct product);
std::optional<Grant> rewritten_expressions(const Grant& grant, StockProduct product);

}  // namespace ddssec::governance
