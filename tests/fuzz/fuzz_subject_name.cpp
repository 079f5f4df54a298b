// The text of a subject name: read or refused; every name that is read equals itself.
#include <cstdlib>

#include "pki/subject_name.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace ddssec;
  const auto name = pki::SubjectName::parse(as_text({data, size}));
  if (name && !name->matches(*name)) std::abort();
  return 0;
}
