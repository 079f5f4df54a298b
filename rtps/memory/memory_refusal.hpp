// The reasons why memory is not used. The caller then falls back to UDP.
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
  wrong_size,       ///< it is empty, above the limit, or has pages that do not exist yet
  other_memory,     ///< it is not the memory that the writer offered
  other_segment,    ///< the reference is to another segment
  outside,          ///< the reference leaves the segment
  gone,             ///< the slot has other content by now: request a retransmission
  no_socket,        ///< the local socket cannot be made or reached
  wrong_process,    ///< a process other than the writer's listens
  no_answer,        ///< the token was refused, or the answer is late or malformed
  too_many_tokens,  ///< the limit of offers is reached
  not_matched,      ///< no reader of the participant has matched the writer yet
  limit_reached,    ///< the memory limit of the writer's participant is reached
  other_user,       ///< the other process is of another user
  no_room,          ///< the memory cgroup has too little room
  held_up,          ///< the thread that passes descriptors is held up by another process
  off               ///< shared memory is off in the reader's participant
};
inline constexpr std::uint32_t kRefusals = 1 + static_cast<std::uint32_t>(MemoryRefusal::off);

/// True if the next attempt may succeed: the reader has not matched yet, its process is slow, or
/// strangers fill the socket.
bool may_pass_by(MemoryRefusal why);

/// Returns the reason as text, such as "the token was refused, ...".
std::string_view to_string(MemoryRefusal why);

template <class T>
using MemoryResult = std::expected<T, MemoryRefusal>;

inline std::unexpected<MemoryRefusal> refuse(MemoryRefusal why) { return std::unexpected(why); }

}  // namespace ddssec::rtps::memory
