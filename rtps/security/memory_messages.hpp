// The messages of two participants about shared memory, over their protected channel.
#pragma once

#include <optional>

#include "base/ids.hpp"
#include "plugins/spi/token.hpp"
#include "rtps/memory/descriptor_server.hpp"

namespace ddssec::rtps {

/// The offer of a writer's memory, from the writer's participant to one that has a matched reader.
struct MemoryOffer {
  EntityId writer = {};
  memory::DescriptorOffer offer = {};
};

/// The answer of the reader's participant: it has mapped the memory, or cannot read it.
struct MemoryAnswer {
  EntityId writer = {};
  std::uint64_t segment = 0;
  /// The reason why it cannot be read; empty: mapped.
  std::optional<memory::MemoryRefusal> refusal = {};
  bool operator==(const MemoryAnswer&) const = default;
};

spi::Token token_of(const MemoryOffer& offer);
spi::Token token_of(const MemoryAnswer& answer);
/// Both functions return nothing for a token that this version does not understand.
std::optional<MemoryOffer> offer_in(const spi::Token& token);
std::optional<MemoryAnswer> answer_in(const spi::Token& token);

}  // namespace ddssec::rtps
