#include "pki/key_derivation.hpp"

#include <limits>
#include <string_view>

#include <fmt/format.h>
#include <openssl/pem.h>

#include "pki/openssl.hpp"

namespace ddssec::pki {
namespace {

using EncryptedKeyPtr = std::unique_ptr<X509_SIG, Deleter<X509_SIG_free>>;
using Pbes1Ptr = std::unique_ptr<PBEPARAM, Deleter<PBEPARAM_free>>;
using Pbes2Ptr = std::unique_ptr<PBE2PARAM, Deleter<PBE2PARAM_free>>;
using Pbkdf2Ptr = std::unique_ptr<PBKDF2PARAM, Deleter<PBKDF2PARAM_free>>;
using ScryptPtr = std::unique_ptr<SCRYPT_PARAMS, Deleter<SCRYPT_PARAMS_free>>;

// Returns the parameters of an algorithm; nullptr if they have another form.
template <class Pointer>
Pointer parameters_of(const X509_ALGOR& algorithm, const ASN1_ITEM* form) {
  const void* value = nullptr;
  int type = V_ASN1_UNDEF;
  X509_ALGOR_get0(nullptr, &type, &value, &algorithm);
  if (type != V_ASN1_SEQUENCE) return nullptr;
  const auto* const text = static_cast<const ASN1_STRING*>(value);
  return Pointer(static_cast<typename Pointer::pointer>(ASN1_item_unpack(text, form)));
}

int nid_of(const X509_ALGOR& algorithm) {
  const ASN1_OBJECT* name = nullptr;
  X509_ALGOR_get0(&name, nullptr, nullptr, &algorithm);
  return OBJ_obj2nid(name);
}

// Returns the number, or the largest one if it is negative or larger.
std::int64_t number_of(const ASN1_INTEGER* number) {
  std::int64_t out = 0;
  if (ASN1_INTEGER_get_int64(&out, number) == 1 && out >= 0) return out;
  return std::numeric_limits<std::int64_t>::max();
}

std::unexpected<Error> too_costly_error(std::string_view what, std::int64_t max,
                                        std::int64_t found) {
  return fail(
      Code::key_not_allowed,
      {.field = "derivation of the key from the passphrase",
       .expected = fmt::format("{} of at most {}", what, max),
       .found = fmt::format("{}", found),
       .hint = "do not use a key that a stranger sent; encrypt one of your own again: openssl "
               "pkcs8 -topk8 -iter 600000 -in FILE -out NEW"});
}

Status check_iterations(const ASN1_INTEGER* iterations) {
  const auto found = number_of(iterations);
  if (found <= kMaxIterations) return {};
  return too_costly_error("a number of iterations", kMaxIterations, found);
}

Status check_scrypt(const SCRYPT_PARAMS& scrypt) {
  std::int64_t product = 1;
  for (const auto* const factor :
       {scrypt.costParameter, scrypt.blockSize, scrypt.parallelizationParameter})
    if (__builtin_mul_overflow(product, number_of(factor), &product))
      product = std::numeric_limits<std::int64_t>::max();
  if (product <= kMaxScryptCost) return {};
  return too_costly_error("a product of scrypt's N, r and p", kMaxScryptCost, product);
}

Status check_algorithm(const X509_ALGOR& algorithm) {
  if (nid_of(algorithm) != NID_pbes2) {
    const auto pbes1 = parameters_of<Pbes1Ptr>(algorithm, ASN1_ITEM_rptr(PBEPARAM));
    return pbes1 ? check_iterations(pbes1->iter) : Status{};
  }
  const auto pbes2 = parameters_of<Pbes2Ptr>(algorithm, ASN1_ITEM_rptr(PBE2PARAM));
  if (!pbes2) return {};
  const auto pbkdf2 = parameters_of<Pbkdf2Ptr>(*pbes2->keyfunc, ASN1_ITEM_rptr(PBKDF2PARAM));
  if (pbkdf2 && nid_of(*pbes2->keyfunc) == NID_id_pbkdf2) return check_iterations(pbkdf2->iter);
  const auto scrypt = parameters_of<ScryptPtr>(*pbes2->keyfunc, ASN1_ITEM_rptr(SCRYPT_PARAMS));
  return scrypt ? check_scrypt(*scrypt) : Status{};
}

// One block of a PEM text. Its octets may be a plain key, so OpenSSL wipes them and all buffers
// (PEM_FLAG_SECURE).
struct Block {
  Block() = default;
  ~Block() {
    OPENSSL_secure_free(name);
    OPENSSL_secure_free(header);
    OPENSSL_secure_clear_free(octets, static_cast<std::size_t>(size));
  }
  Block(const Block&) = delete;
  Block& operator=(const Block&) = delete;

  char* name = nullptr;
  char* header = nullptr;
  unsigned char* octets = nullptr;
  long size = 0;
};

Status check_block(const Block& block) {
  // With a header, the octets are encrypted a second time, so that they cannot be read here.
  if (std::string_view(block.name) == PEM_STRING_PKCS8 && !std::string_view(block.header).empty())
    return fail(Code::private_key_malformed,
                {.expected = "an encrypted key without headers (RFC 7468)", .found = "headers"});
  const unsigned char* at = block.octets;
  const EncryptedKeyPtr key(d2i_X509_SIG(nullptr, &at, block.size));
  if (!key) return {};
  const X509_ALGOR* algorithm = nullptr;
  X509_SIG_get0(key.get(), &algorithm, nullptr);
  return check_algorithm(*algorithm);
}

}  // namespace

Status check_key_derivation(BytesView pem) {
  const BioPtr bio = bio_over(pem);
  for (;;) {
    Block block;
    const bool is_read =
        PEM_read_bio_ex(bio.get(), &block.name, &block.header, &block.octets, &block.size,
                        PEM_FLAG_SECURE | PEM_FLAG_EAY_COMPATIBLE) == 1;
    auto status = is_read ? check_block(block) : Status{};
    take_openssl_reason();
    if (!is_read || !status) return status;
  }
}

}  // namespace ddssec::pki
