#include "plugins/cyclonedds/own_domain_tag.hpp"

#include <string>

#include "base/reader.hpp"
#include "wire/parameter_list.hpp"

namespace ddssec::cyclonedds {

Status check_no_domain_tag(BytesView participant_data) {
  rtps::ParameterReader list(participant_data, Endian::big);
  while (!list.at_end()) {
    const auto parameter = list.next();
    if (!parameter || !*parameter) break;
    if ((*parameter)->id != pid::kDomainTag) continue;
    auto value = (*parameter)->reader();
    // The core writes no empty tag. A tag that cannot be read is one, too.
    const auto octets = value.read<std::uint32_t>();
    const auto text = octets ? value.read_bytes(*octets) : Result<BytesView>(BytesView());
    const auto tag = text && !text->empty() ? std::string(as_text(text->first(text->size() - 1)))
                                            : std::string();
    return fail(
        Code::domain_not_covered,
        {.document = "the configuration of Cyclone DDS (CYCLONEDDS_URI)",
         .field = "<Discovery><Tag>",
         .expected = "no tag, because rules for a domain tag do not count under Cyclone DDS",
         .found = tag,
         .hint = "remove <Tag>; to keep participants apart, use another domain id, or other "
                 "certificates and permissions"});
  }
  return {};
}

}  // namespace ddssec::cyclonedds
