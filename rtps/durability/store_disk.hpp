// The room that a sample store has on its disk.
#pragma once

#include <cstddef>
#include <string>

namespace ddssec::rtps {

/// Returns the number of octets that a store may still write. A part of the disk is kept free for
/// operations that make room: removals and checkpoints write before they free anything. `pages` are
/// the octets of committed pages; those that the file does not have yet are counted as written. If
/// the room cannot be determined, all octets are free.
std::size_t room_on_disk(const std::string& path, std::size_t pages);

}  // namespace ddssec::rtps
