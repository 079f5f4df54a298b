#include "pki/pem_block.hpp"

#include <openssl/err.h>
#include <openssl/pem.h>

#include "pki/openssl.hpp"

namespace ddssec::pki {

bool is_der(BytesView octets) {
  constexpr std::uint8_t kSequence = 0x30, kLongForm = 0x80, kMaxLengthOctets = 4;
  constexpr std::size_t kHeader = 2;  // tag and length of a short object
  if (octets.size() < kHeader || octets[0] != kSequence) return false;
  const auto length = octets[1];
  return length < kLongForm ? octets.size() == kHeader + length
                            : length > kLongForm && length <= kLongForm + kMaxLengthOctets;
}

Result<std::optional<PemBlock>> next_pem_block(BIO* bio) {
  char* label = nullptr;
  char* header = nullptr;
  unsigned char* data = nullptr;
  long size = 0;
  const bool read = PEM_read_bio(bio, &label, &header, &data, &size) == 1;
  const OpensslTextPtr label_owner(label), header_owner(header);
  const OpensslMemoryPtr data_owner(data);
  if (!read) {
    const bool at_end = ERR_GET_REASON(ERR_peek_last_error()) == PEM_R_NO_START_LINE;
    if (!at_end) return openssl_error(Code::malformed);
    ERR_clear_error();
    return std::nullopt;
  }
  if (*header != '\0') return fail(Code::malformed, {.note = "the PEM block has headers"});
  return PemBlock{label, Bytes(data, data + size)};
}

}  // namespace ddssec::pki
