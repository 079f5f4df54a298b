// Tokens on their way to the host and back through its C structures are copied alike or refused,
// with nothing lost and nothing freed twice. Structures with missing parts are refused.
#include <cstdlib>

#include "plugins/cyclonedds/token_translation.hpp"

namespace {

using namespace ddssec;

// Takes one part of the host's structure away and gives it back.
template <class T>
void must_refuse_without(T*& part, const DDS_Security_DataHolder& holder) {
  T* const kept = std::exchange(part, nullptr);
  if (cyclonedds::token_from(&holder)) std::abort();
  part = kept;
}

void check_missing_parts(DDS_Security_DataHolder& holder) {
  must_refuse_without(holder.class_id, holder);
  if (holder.properties._length > 0) {
    must_refuse_without(holder.properties._buffer[0].name, holder);
    must_refuse_without(holder.properties._buffer[0].value, holder);
    must_refuse_without(holder.properties._buffer, holder);
  }
  if (holder.binary_properties._length > 0) {
    auto& first = holder.binary_properties._buffer[0];
    must_refuse_without(first.name, holder);
    if (first.value._length > 0) must_refuse_without(first.value._buffer, holder);
    must_refuse_without(holder.binary_properties._buffer, holder);
  }
}

void check(const spi::Token& token) {
  DDS_Security_DataHolder holder;
  if (!cyclonedds::copy_token(token, holder)) {
    if (!cyclonedds::is_nil(&holder)) std::abort();
    return;
  }
  const auto back = cyclonedds::token_from(&holder);
  if (!back || *back != token) std::abort();
  check_missing_parts(holder);
  cyclonedds::free_token(holder);
  cyclonedds::free_token(holder);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Reader reader({data, size}, Endian::little);
  const auto token = spi::read_token(reader);
  if (!token) return 0;
  check(*token);
  if (const auto text = cyclonedds::with_text_properties(*token)) {
    if (!text->binary_properties.empty()) std::abort();
    check(*text);
  }
  return 0;
}
