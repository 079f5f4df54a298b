// The splitter before the signature check: its views lie in the input and do not overlap, and
// canonical text stays unchanged.
#include <cstdlib>

#include "pki/mime.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace ddssec;
  const auto text = as_text({data, size});
  const auto parts = pki::split_multipart_signed(text);
  if (!parts) return 0;
  const char* const content_end = parts->content.data() + parts->content.size();
  if (parts->content.data() < text.data() || content_end > parts->signature.data() ||
      parts->signature.data() + parts->signature.size() > text.data() + text.size())
    std::abort();
  const auto canonical = pki::canonical_text(parts->content);
  if (!canonical) return 0;
  const auto again = pki::canonical_text(as_text(*canonical));
  if (!again || *again != *canonical) std::abort();
  const auto header = pki::text_header_octets(as_text(*canonical));
  if (header && *header > canonical->size()) std::abort();
  return 0;
}
