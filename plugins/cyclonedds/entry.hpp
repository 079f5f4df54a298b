// The common part of the six exported functions.
#pragma once

#include <memory>

#include "base/process_exit.hpp"
#include "plugins/cyclonedds/abi.hpp"
#include "plugins/cyclonedds/host.hpp"

namespace ddssec::cyclonedds {

/// Creates one context, which contains all its state: each domain of a process has its own.
/// `caller` is an address in the host's code. Any result except 0 fails the creation of the
/// participant.
template <class Adapter, class CStruct, class Make>
int init(void** context, ddsi_domaingv* domain, const void* caller, Make&& make) noexcept {
  if (context == nullptr) return DDS_SECURITY_FAILED;
  *context = nullptr;
  keep_openssl_at_exit();
  try {
    auto adapter = std::make_unique<Adapter>(
        std::make_unique<Host>(make_host_log_for(caller), caller), make, domain);
    *context = static_cast<CStruct*>(adapter.release());
    return DDS_SECURITY_SUCCESS;
  } catch (...) {
    return DDS_SECURITY_FAILED;
  }
}

/// Ends the context's thread, if it has one, and wipes and frees its memory.
template <class Adapter, class CStruct>
int finalize(void* context) noexcept {
  if (context == nullptr) return DDS_SECURITY_FAILED;
  const std::unique_ptr<Adapter> adapter(static_cast<Adapter*>(static_cast<CStruct*>(context)));
  return DDS_SECURITY_SUCCESS;
}

}  // namespace ddssec::cyclonedds
