#include "tests/fuzz/rtps_kind.hpp"

std::optional<ddssec::rtps::SubmessageId> ddssec::fuzz::kind() {
#ifdef DDSSEC_FUZZ_KIND
  return rtps::SubmessageId::DDSSEC_FUZZ_KIND;
#else
  return {};
#endif
}
