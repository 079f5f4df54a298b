#include "pki/unverified_document.hpp"

#include <algorithm>
#include <string>
#include <string_view>

#include <openssl/evp.h>

#include "pki/certificate_source.hpp"
#include "pki/mime.hpp"
#include "pki/openssl.hpp"

namespace ddssec::pki {
namespace {

constexpr std::size_t kMaxSignatureText = 64 * 1024;
// The limit for octets that are not signed. OpenSSL and ddssec write some 600.
constexpr std::size_t kMaxUnsignedOctets = 4096;

Result<Bytes> decode_base64(std::string_view text) {
  const auto bad = [] {
    return openssl_error(Code::smime_signature_malformed, {.field = "base64 text"});
  };
  if (text.size() > kMaxSignatureText)
    return fail(Code::smime_signature_malformed,
                {.field = "base64 text",
                 .expected = "at most " + std::to_string(kMaxSignatureText) + " octets",
                 .found = std::to_string(text.size())});
  std::string joined;
  joined.reserve(text.size());
  for (char c : text)
    if (std::string_view(" \t\r\n").find(c) == std::string_view::npos) joined.push_back(c);
  // '=' is allowed only at the end. EVP_DecodeBlock reads one elsewhere as zeros, but OpenSSL's
  // other reader ends there.
  const auto digits = std::min(joined.find('='), joined.size());
  if (joined.empty() || joined.size() % 4 != 0 || joined.size() - digits > 2 ||
      joined.find_first_not_of('=', digits) != joined.npos)
    return bad();
  Bytes out(joined.size() / 4 * 3);
  const int size =
      EVP_DecodeBlock(out.data(), as_bytes(joined).data(), static_cast<int>(joined.size()));
  if (size < 0) return bad();
  // EVP_DecodeBlock counts the padding as zeros.
  const std::size_t padding = joined.ends_with("==") ? 2 : joined.ends_with('=') ? 1 : 0;
  out.resize(static_cast<std::size_t>(size) - padding);
  return out;
}

Result<BytesView> check_octets(BytesView file) {
  if (file.size() > kMaxDocumentOctets)
    return fail(Code::smime_too_large,
                {.expected = "at most " + std::to_string(kMaxDocumentOctets) + " octets",
                 .found = std::to_string(file.size())});
  if (!file.empty() && file.back() == 0) file = file.first(file.size() - 1);
  if (as_text(file).find('\0') == std::string_view::npos) return file;
  constexpr std::uint8_t kSequence = 0x30;  // the first octet of every DER signature
  if (file.front() == kSequence)
    return fail(Code::smime_not_multipart, {.expected = "Content-Type: multipart/signed",
                                            .found = "a binary (DER) signature"});
  return fail(Code::smime_nul);
}

// Limits the octets that are not signed: header lines, boundaries, blanks around the parts, and
// carriage returns before line feeds. The sender of a document could add more of them, to use up
// memory or to make it look new.
Status check_unsigned(BytesView file, BytesView content, BytesView signature) {
  const auto lines = static_cast<std::size_t>(std::ranges::count(content, '\n'));
  const auto base64_size = (signature.size() + 2) / 3 * 4;
  const auto most = content.size() + base64_size + kMaxUnsignedOctets + lines;
  if (file.size() <= most) return {};
  return fail(Code::smime_unsigned_octets,
              {.expected = "at most " + std::to_string(kMaxUnsignedOctets) + " octets",
               .found = std::to_string(file.size() - most) + " more"});
}

int line_breaks(std::string_view text) { return static_cast<int>(std::ranges::count(text, '\n')); }

}  // namespace

Result<UnverifiedDocument> read_document(BytesView file) {
  DDSSEC_ASSIGN_OR_RETURN(const auto octets, check_octets(file));
  DDSSEC_ASSIGN_OR_RETURN(const auto parts, split_multipart_signed(as_text(octets)));
  DDSSEC_ASSIGN_OR_RETURN(auto content, canonical_text(parts.content));
  DDSSEC_ASSIGN_OR_RETURN(const auto header, text_header_octets(as_text(content)));
  DDSSEC_ASSIGN_OR_RETURN(auto signature, decode_base64(parts.signature));
  DDSSEC_RETURN_IF_ERROR(check_unsigned(octets, content, signature));
  const auto before = static_cast<std::size_t>(parts.content.data() - as_text(octets).data());
  const int first_line = 1 + line_breaks(as_text(octets).substr(0, before)) +
                         line_breaks(as_text(content).substr(0, header));
  return UnverifiedDocument{std::move(content), header, first_line, std::move(signature)};
}

}  // namespace ddssec::pki
