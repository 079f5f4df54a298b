#include "plugins/cyclonedds/process_questions.hpp"

#include <dlfcn.h>

#include "plugins/cyclonedds/abi.hpp"

namespace ddssec::cyclonedds {

bool has_our_cryptography() { return dlsym(RTLD_DEFAULT, kSupportedCiphersSymbol) != nullptr; }

bool has_our_authentication() {
  return dlsym(RTLD_DEFAULT, kAuthenticationVersionSymbol) != nullptr;
}

std::optional<std::string> renewed_permissions(spi::IdentityHandle local, std::uint64_t& known) {
  void* const symbol = dlsym(RTLD_DEFAULT, kRenewedPermissionsSymbol);
  if (symbol == nullptr) return std::nullopt;
  std::optional<std::string> text;
  // No exception may pass through the other library.
  const auto take = [](void* context, const DDS_Security_octet* octets, std::size_t size) {
    try {
      *static_cast<std::optional<std::string>*>(context) =
          std::string(reinterpret_cast<const char*>(octets), size);
    } catch (...) {
    }
  };
  const auto times = reinterpret_cast<RenewedPermissions*>(symbol)(local.value, known, take, &text);
  if (text) known = times;
  return text;
}

std::uint64_t rights_changed(spi::IdentityHandle local) {
  void* const symbol = dlsym(RTLD_DEFAULT, kRightsChangedSymbol);
  return symbol == nullptr ? 0 : reinterpret_cast<RightsChanged*>(symbol)(local.value);
}

void end_sessions_now() noexcept {
  if (void* const symbol = dlsym(RTLD_DEFAULT, kEndSessionsNowSymbol))
    reinterpret_cast<EndSessionsNow*>(symbol)();
}

spi::CipherMask ciphers_of_process() {
  void* const symbol = dlsym(RTLD_DEFAULT, kSupportedCiphersSymbol);
  if (symbol == nullptr) return spi::kStandardCiphers;
  return reinterpret_cast<SupportedCiphers*>(symbol)();
}

HandshakeWatch::Questions questions_to_cryptography() {
  HandshakeWatch::Questions questions;
  if (void* const symbol = dlsym(RTLD_DEFAULT, kHasKeysOfSymbol))
    questions.has_keys = [ask = reinterpret_cast<HasKeysOf*>(symbol)](auto remote) {
      return ask(remote.value);
    };
  if (void* const symbol = dlsym(RTLD_DEFAULT, kHasKeysForSymbol))
    questions.has_keys_for = [ask = reinterpret_cast<HasKeysFor*>(symbol)](auto remote,
                                                                           auto local) {
      return ask(remote.value, local.value);
    };
  if (void* const symbol = dlsym(RTLD_DEFAULT, kIsMatchedWithSymbol))
    questions.is_matched = [ask = reinterpret_cast<IsMatchedWith*>(symbol)](auto remote) {
      return ask(remote.value);
    };
  if (void* const symbol = dlsym(RTLD_DEFAULT, kLastHeardOfSymbol))
    questions.last_heard = [ask = reinterpret_cast<LastHeardOf*>(symbol)](auto remote) {
      return HandshakeWatch::Duration(ask(remote.value));
    };
  return questions;
}

namespace {
void cut_off(const char* name, spi::IdentityHandle local) {
  if (void* const symbol = dlsym(RTLD_DEFAULT, name))
    reinterpret_cast<CutOff*>(symbol)(local.value);
}
}  // namespace

void cut_off_cryptography(spi::IdentityHandle local) { cut_off(kCutOffCryptographySymbol, local); }
void cut_off_access_control(spi::IdentityHandle local) {
  cut_off(kCutOffAccessControlSymbol, local);
}

void look_for_ended_readers() noexcept {
  if (void* const symbol = dlsym(RTLD_DEFAULT, kLookForEndedReadersSymbol))
    reinterpret_cast<LookForEndedReaders*>(symbol)();
}

void return_permissions_of(spi::IdentityHandle peer) noexcept {
  if (void* const symbol = dlsym(RTLD_DEFAULT, kReturnPermissionsOfSymbol))
    reinterpret_cast<ReturnPermissionsOf*>(symbol)(peer.value);
}

bool holds(GovernanceFact fact, spi::IdentityHandle local) {
  void* const symbol = dlsym(RTLD_DEFAULT, kGovernanceFactsOfSymbol);
  return symbol != nullptr && has(reinterpret_cast<GovernanceFactsOf*>(symbol)(local.value), fact);
}

}  // namespace ddssec::cyclonedds
