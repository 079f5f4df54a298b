// The library context in which certificates are read.
#include "pki/certificate_context.hpp"

#include <algorithm>
#include <bit>
#include <memory>
#include <string_view>
#include <vector>

#include <openssl/core_dispatch.h>
#include <openssl/crypto.h>
#include <openssl/evp.h>
#include <openssl/provider.h>

#include "pki/openssl_pointers.hpp"

namespace ddssec::pki {
namespace {

using LibraryContextPtr = std::unique_ptr<OSSL_LIB_CTX, Deleter<OSSL_LIB_CTX_free>>;
using Algorithms = std::vector<OSSL_ALGORITHM>;

// A provider that offers only the wanted algorithms of the default provider.
struct RestrictedProvider {
  OSSL_PROVIDER* whole = nullptr;  // the default provider, in a context of its own
  Algorithms decoders, key_managers;
};

RestrictedProvider& restricted_provider() {
  static auto* const provider =
      new RestrictedProvider;  // lives as long as the context, which is never freed
  return *provider;
}

bool is_allowed_key(std::string_view names) {
  const auto first = names.substr(0, names.find(':'));
  return first == "EC" || first == "RSA" || first == "RSA-PSS";
}

bool reads_public_keys(std::string_view properties) {
  return properties.find("input=der") != properties.npos &&
         properties.find("structure=SubjectPublicKeyInfo") != properties.npos;
}

// The default provider's algorithms that `wanted` accepts, followed by the empty entry that ends
// OpenSSL's lists.
Algorithms algorithms_of_allowed_keys(int operation, bool (*wanted)(const OSSL_ALGORITHM&)) {
  Algorithms out;
  int no_cache = 0;
  const auto* all =
      OSSL_PROVIDER_query_operation(restricted_provider().whole, operation, &no_cache);
  for (; all != nullptr && all->algorithm_names != nullptr; ++all)
    if (is_allowed_key(all->algorithm_names) && wanted(*all)) out.push_back(*all);
  out.push_back({});
  return out;
}

// ---- functions that OpenSSL calls

const OSSL_ALGORITHM* query(void*, int operation, int* no_cache) {
  *no_cache = 0;
  if (operation == OSSL_OP_DECODER) return restricted_provider().decoders.data();
  if (operation == OSSL_OP_KEYMGMT) return restricted_provider().key_managers.data();
  return OSSL_PROVIDER_query_operation(restricted_provider().whole, operation, no_cache);
}

void tear_down(void*) {}

const OSSL_DISPATCH kFunctions[] = {
    {OSSL_FUNC_PROVIDER_QUERY_OPERATION, std::bit_cast<void (*)()>(&query)},
    {OSSL_FUNC_PROVIDER_TEARDOWN, std::bit_cast<void (*)()>(&tear_down)},
    {0, nullptr}};

int start(const OSSL_CORE_HANDLE*, const OSSL_DISPATCH*, const OSSL_DISPATCH** functions,
          void** context) {
  *functions = kFunctions;
  *context = OSSL_PROVIDER_get0_provider_ctx(restricted_provider().whole);
  return 1;
}

OSSL_LIB_CTX* make_context() {
  const bool is_usual = EVP_default_properties_is_fips_enabled(nullptr) == 0 &&
                        OSSL_PROVIDER_available(nullptr, "default") == 1;
  LibraryContextPtr inner(is_usual ? OSSL_LIB_CTX_new() : nullptr);
  LibraryContextPtr outer(inner ? OSSL_LIB_CTX_new() : nullptr);
  if (!outer) return nullptr;
  restricted_provider().whole = OSSL_PROVIDER_load(inner.get(), "default");
  if (restricted_provider().whole == nullptr) return nullptr;
  restricted_provider().decoders = algorithms_of_allowed_keys(
      OSSL_OP_DECODER, [](const auto& one) { return reads_public_keys(one.property_definition); });
  restricted_provider().key_managers =
      algorithms_of_allowed_keys(OSSL_OP_KEYMGMT, [](const auto&) { return true; });
  constexpr const char* kName = "ddssec";
  if (OSSL_PROVIDER_add_builtin(outer.get(), kName, start) != 1 ||
      OSSL_PROVIDER_load(outer.get(), kName) == nullptr)
    return nullptr;
  static_cast<void>(inner.release());
  return outer.release();
}

}  // namespace

OSSL_LIB_CTX* certificate_context() {
  static OSSL_LIB_CTX* const context = make_context();
  return context;
}

}  // namespace ddssec::pki
