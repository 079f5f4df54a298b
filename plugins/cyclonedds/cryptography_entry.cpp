// libddssec_cryptography.so
#include "plugins/cryptography/cryptography.hpp"
#include "plugins/cyclonedds/cryptography_adapter.hpp"
#include "plugins/cyclonedds/entry.hpp"
#include "plugins/cyclonedds/peers_with_keys.hpp"
#include "plugins/cyclonedds/plugins_in_use.hpp"
#include "plugins/cyclonedds/session_resets.hpp"

using namespace ddssec;
using cyclonedds::CryptographyAdapter;

DDSSEC_EXPORT int init_crypto(const char*, void** context, ddsi_domaingv* domain) {
  return cyclonedds::init<CryptographyAdapter, dds_security_cryptography>(
      context, domain, __builtin_return_address(0), [](const PluginServices& services) {
        // Cyclone's core does not remember the owners of keys.
        return cryptography::make_cryptography(services, {.host_checks_sources = false});
      });
}

DDSSEC_EXPORT std::uint32_t ddssec_supported_ciphers() { return cryptography::supported_ciphers(); }

DDSSEC_EXPORT bool ddssec_has_keys_of(DDS_Security_IdentityHandle remote) {
  return cyclonedds::PeersWithKeys::of_process().has_sent_keys({remote});
}

DDSSEC_EXPORT bool ddssec_has_keys_for(DDS_Security_IdentityHandle remote,
                                       DDS_Security_IdentityHandle local) {
  return cyclonedds::PeersWithKeys::of_process().has_sent_keys(spi::IdentityHandle{remote},
                                                               {local});
}

DDSSEC_EXPORT bool ddssec_is_matched_with(DDS_Security_IdentityHandle remote) {
  return cyclonedds::PeersWithKeys::of_process().is_matched({remote});
}

DDSSEC_EXPORT std::int64_t ddssec_last_heard_of(DDS_Security_IdentityHandle remote) {
  return cyclonedds::PeersWithKeys::of_process().last_heard({remote}).count();
}

DDSSEC_EXPORT cyclonedds::SessionReset ddssec_take_session_reset(
    DDS_Security_IdentityHandle remote) {
  return cyclonedds::SessionResets::of_process().take({remote},
                                                      cyclonedds::PeersWithKeys::of_process());
}

DDSSEC_EXPORT bool ddssec_take_stranded_keys(DDS_Security_IdentityHandle remote) {
  return CryptographyAdapter::poll_stranded_keys({remote});
}

DDSSEC_EXPORT void ddssec_cut_off_cryptography(DDS_Security_IdentityHandle local) {
  CryptographyAdapter::cut_off({local});
}

DDSSEC_EXPORT void ddssec_look_for_ended_readers() {
  CryptographyAdapter::look_for_ended_readers();
}

DDSSEC_EXPORT int finalize_crypto(void* context) {
  return cyclonedds::finalize<CryptographyAdapter, dds_security_cryptography>(context);
}

DDSSEC_EXPORT const char* ddssec_cryptography_version() { return cyclonedds::version(); }
