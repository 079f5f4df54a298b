#include "base/reader.hpp"

#include <algorithm>

namespace ddssec {

Result<BytesView> Reader::read_bytes(std::size_t count) {
  if (count > remaining()) return fail(Code::truncated);
  const auto out = octets_.subspan(position_, count);
  position_ += count;
  return out;
}

Status Reader::read_into(MutableBytes out) {
  DDSSEC_ASSIGN_OR_RETURN(const auto octets, read_bytes(out.size()));
  std::ranges::copy(octets, out.begin());
  return {};
}

Status Reader::align(std::size_t alignment) { return skip(-position_ & (alignment - 1)); }

Status Reader::skip(std::size_t count) {
  if (count > remaining()) return fail(Code::truncated);
  position_ += count;
  return {};
}

Result<BytesView> Reader::read_octet_sequence() {
  const auto start = position_;
  const auto length = read_aligned<std::uint32_t>();
  const auto octets = length ? read_bytes(*length) : fail(Code::truncated);
  if (!octets) position_ = start;
  return octets;
}

Result<std::string_view> Reader::read_string() {
  const auto start = position_;
  DDSSEC_ASSIGN_OR_RETURN(auto octets, read_octet_sequence());
  if (octets.empty()) return std::string_view{};
  const auto text = as_text(octets.first(octets.size() - 1));
  if (octets.back() != 0 || text.find('\0') != text.npos) {
    position_ = start;
    return fail(Code::malformed);
  }
  return text;
}

Result<std::uint32_t> Reader::read_count(std::size_t min_element_size) {
  const auto start = position_;
  DDSSEC_ASSIGN_OR_RETURN(const auto count, read_aligned<std::uint32_t>());
  if (count > remaining() / std::max<std::size_t>(1, min_element_size)) {
    position_ = start;
    return fail(Code::length_out_of_range);
  }
  return count;
}

Status Reader::finish() const {
  if (!at_end()) return fail(Code::trailing_octets);
  return {};
}

}  // namespace ddssec
