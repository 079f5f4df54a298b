// Output buffers and handle lists of the message path.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdlib>
#include <iterator>
#include <memory>
#include <span>
#include <type_traits>
#include <vector>

#include "base/hash.hpp"
#include "plugins/cyclonedds/abi.hpp"
#include "plugins/cyclonedds/value_translation.hpp"

namespace ddssec::cyclonedds {

/// Gives the host one malloc block that `write(MutableBytes of at most `bound` octets) ->
/// Result<octets written>` has filled. The host frees it. After a failure there is no block and
/// `out` is empty. Errors: out_of_memory, internal, those of `write`.
template <class Write>
Status write_block(DDS_Security_OctetSeq& out, std::size_t bound, Write&& write) {
  struct Free {
    void operator()(std::uint8_t* block) const noexcept { std::free(block); }
  };
  out = {};
  std::unique_ptr<std::uint8_t, Free> block(
      static_cast<std::uint8_t*>(std::malloc(bound != 0 ? bound : 1)));
  if (!block) return fail(Code::out_of_memory);
  DDSSEC_ASSIGN_OR_RETURN(const auto written, write(MutableBytes(block.get(), bound)));
  if (written > bound) return fail(Code::internal);
  const auto length = static_cast<DDS_Security_unsigned_long>(written);
  out = {length, length, block.release()};
  return {};
}

/// Returns the host's list of receivers as handles, without the nil handles of unprotected
/// endpoints. If there are such handles, the result points into `kept`; otherwise into the list.
/// Error: null_argument.
template <class Handle>
Result<std::span<const Handle>> receivers_from(const DDS_Security_LongLongSeq* list,
                                               std::vector<Handle>& kept) {
  if (list == nullptr) return {};
  DDSSEC_ASSIGN_OR_RETURN(const auto values, elements_of(*list));
  // A Handle is one such integer and nothing else, so the list needs no copy.
  static_assert(std::is_standard_layout_v<Handle> && sizeof(Handle) == sizeof(values[0]));
  const std::span all(reinterpret_cast<const Handle*>(values.data()), values.size());
  if (std::ranges::find(values, 0) == values.end()) return all;
  std::ranges::copy_if(all, std::back_inserter(kept), [](Handle handle) { return bool(handle); });
  return kept;
}

/// While an object lives, the GUID prefix of a received RTPS header is in network order. Cyclone
/// converts it to host order, in place, before it asks for decoding. The buffer belongs to the
/// receiving thread alone.
class WireOrderPrefix {
 public:
  explicit WireOrderPrefix(BytesView message)
      : prefix_(message.size() >= kEnd ? const_cast<std::uint8_t*>(message.data()) + kBegin
                                       : nullptr) {
    swap();
  }
  ~WireOrderPrefix() { swap(); }
  WireOrderPrefix(const WireOrderPrefix&) = delete;
  WireOrderPrefix& operator=(const WireOrderPrefix&) = delete;

 private:
  static constexpr std::size_t kBegin = 8;
  static constexpr std::size_t kEnd = 20;

  /// Swaps the octets of three 32-bit words.
  void swap() {
    if (prefix_ == nullptr || std::endian::native == std::endian::big) return;
    for (std::size_t word = 0; word < kEnd - kBegin; word += 4)
      std::reverse(prefix_ + word, prefix_ + word + 4);
  }

  std::uint8_t* prefix_;
};

}  // namespace ddssec::cyclonedds
