#include "wire/content_filter_info.hpp"

#include "wire/parameter_list.hpp"

namespace ddssec::rtps {

void write_content_filter_info(SpanWriter& out, const FilterResults& results) {
  const auto& list = results.list;
  if (list.empty()) return;
  const ParameterScope scope(out, pid::kContentFilterInfo);
  const auto words = (list.size() + 31) / 32;
  out.write(static_cast<std::uint32_t>(words));
  for (std::size_t word = 0; word < words; ++word) {
    std::uint32_t bits = 0;
    for (std::size_t i = word * 32; i < std::min(list.size(), (word + 1) * 32); ++i)
      if (list[i].passed) bits |= std::uint32_t{1} << (31 - i % 32);
    out.write(bits);
  }
  out.write(static_cast<std::uint32_t>(list.size()));
  for (const auto& result : list) out.write_bytes(result.signature);
}

}  // namespace ddssec::rtps
