// What two participants say to each other about shared memory, over their protected channel.
#pragma once

#include <optional>

#include "base/ids.hpp"
#include "plugins/spi/token.hpp"
#include "rtps/memory/descriptor_server.hpp"

namespace ddssec::rtps {

/// A writer's participant offers the writer's memory to one that has a matched reader.
struct MemoryOffer {
  EntityId writer = {};
  memory::DescriptorOffer offer = {};
};

/// The reader's participant has mapped it, or says why it cannot be read.
struct MemoryAnswer {
  EntityId writer = {};
  std::uint64_t segment = 0;
  std::optional<memory::MemoryRefusal> refusal = {};  ///< empty: mapped
  bool operator==(const MemoryAnswer&) const = default;
};

spi::Token token_of(const MemoryOffer& offer);
spi::Token token_of(const MemoryAnswer& answer);
/// Empty: it is not one that this version understands.
std::optional<MemoryOffer> offer_in(const spi::Token& token);
std::optional<MemoryAnswer> answer_in(const spi::Token& token);

}  // namespace ddssec::rtps
