// Why memory is not used. The caller then falls back to UDP.
#pragma once

#include <cstdint>
#include <expected>
#include <string_view>

namespace ddssec::rtps::memory {

enum class MemoryRefusal : std::uint8_t {
  no_memory,        ///< the system gave no memory, descriptor or mapping
  no_seals,         ///< the kernel cannot seal memory against writing (Linux before 5.1)
  bad_shape,        ///< slots of no size, or too many
  too_large,        ///< the payload does not fit a slot
  full,             ///< readers still need every slot
  wrong_kind,       ///< the descriptor is not of memory that can be sealed
  not_sealed,       ///< a seal is missing
  wrong_size,       ///< empty, above the limit, or memory that is not there yet
  other_memory,     ///< not the memory that the writer offered
  other_segment,    ///< the reference is to another segment
  outside,          ///< the reference leaves the segment
  gone,             ///< the slot has other content by now: ask for a retransmission
  no_socket,        ///< the local socket cannot be made or reached
  wrong_process,    ///< another process than the writer's listens
  no_answer,        ///< the token was refused, or the answer is late or malformed
  too_many_tokens,  ///< the limit of offers is reached
  not_matched,      ///< no reader of the participant has matched the writer yet
  limit_reached,    ///< the limit of the writer's participant for its memory
  other_user,       ///< the other process is of another user
  no_room,          ///< the memory cgroup has too little room
  held_up,          ///< what passes descriptors on is held up by another process
  off               ///< shared memory is off in the reader's participant
};
inline constexpr std::uint32_t kRefusals = 1 + static_cast<std::uint32_t>(MemoryRefusal::off);

/// The next attempt may succeed: the reader has not matched yet, its process is slow, or strangers
/// fill the socket.
bool may_pass_by(MemoryRefusal why);

/// The reason for people: "the token was refused, ...".
std::string_view to_string(MemoryRefusal why);

template <class T>
using MemoryResult = std::expected<T, MemoryRefusal>;

inline std::unexpected<MemoryRefusal> refuse(MemoryRefusal why) { return std::unexpected(why); }

}  // namespace ddssec::rtps::memory
