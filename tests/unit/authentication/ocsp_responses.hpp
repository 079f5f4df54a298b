// OCSP responses of the CA of the tests, and identities that have or demand one.
#pragma once

#include <algorithm>

#include "pki/ocsp.hpp"
#include "tests/support/ocsp_responder.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/unit/authentication/revocation_lists.hpp"

namespace ddssec::authentication {

inline Bytes response_about(const pki::Certificate& certificate,
                            int status = V_OCSP_CERTSTATUS_GOOD,
                            std::chrono::seconds this_update = 0s,
                            std::chrono::seconds next_update = 24h) {
  return test::ocsp_response({.answers = {{.certificate = certificate,
                                           .ca = test_ca().certificate(),
                                           .status = status,
                                           .this_update = this_update,
                                           .next_update = next_update}},
                              .signer = test_ca().certificate(),
                              .key = test_ca().key(),
                              .now = kNow});
}

/// Returns `identity` with a file for its response.
inline Identity with_file(Identity identity, const test::TemporaryFolder& folder,
                          const std::string& name = "ocsp.der") {
  set(identity.properties, spi::property::kOcspResponse, "file:" + folder.path() + "/" + name);
  set(identity.properties, spi::property::kFilesPollInterval, "1");
  return identity;
}
inline Identity with_policy(Identity identity, const std::string& policy) {
  set(identity.properties, spi::property::kOcsp, policy);
  return identity;
}

inline int count_of(const test::RecordedEvents& events, Code code) {
  return static_cast<int>(std::ranges::count_if(
      events.all, [&](const Event& event) { return event.error.code() == code; }));
}

}  // namespace ddssec::authentication
