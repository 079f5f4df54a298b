// The room that a sample store has on its disk.
#pragma once

#include <cstddef>
#include <string>

namespace ddssec::rtps {

/// How many octets a store may still write. A part of the disk is kept free for what makes room:
/// removals and checkpoints write before they free anything. `pages`: the octets of what is
/// committed; what the file does not have of them yet is counted as written. If it cannot be
/// determined, all octets are free.
std::size_t room_on_disk(const std::string& path, std::size_t pages);

}  // namespace ddssec::rtps
