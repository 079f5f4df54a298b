// Documents as stock products read them, written as the standard reads them: our decisions by the
// resulting document are those of the product.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "governance/model.hpp"

namespace ddssec::governance {

enum class StockProduct : std::uint8_t { cyclonedds, fastdds };
inline constexpr StockProduct kStockProducts[] = {StockProduct::cyclonedds, StockProduct::fastdds};
/// "Cyclone DDS", "Fast DDS".
std::string_view to_string(StockProduct product);

/// Both products read a range of domains without <max> as one domain. Nothing if that changes
/// nothing. Expressions are left as they are (dialect.hpp).
std::optional<Governance> as_stock_reads(const Governance& document);

/// The same; and Cyclone DDS takes a deny_rule without partitions for the partition "" only, and
/// passes over <tag>; Fast DDS denies in all partitions, and takes every <default> as DENY. With
/// Fast DDS a topic and its partitions may also stand in different elements of one rule, and the
/// first rule with the topic decides: after an allow_rule stands a deny_rule for its topics.
std::optional<Permissions> as_stock_reads(const Permissions& document, StockProduct product);

}  // namespace ddssec::governance
