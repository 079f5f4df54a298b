// How the subject of a renewed certificate differs from that of the one in place.
#pragma once

#include <optional>

#include "base/result.hpp"
#include "pki/certificate.hpp"
#include "pki/subject_name.hpp"

namespace ddssec::cli {

/// Returns what to report of a renewed certificate with another subject; nothing if it is the same.
/// The GUID of a participant is derived from the octets of its subject (DDS-Security 1.2, clause
/// 10.3.3), so a running participant cannot use the same text in another string type.
inline std::optional<ErrorDetails> other_subject(const pki::Certificate& present,
                                                 const pki::Certificate& renewed) {
  if (renewed.subject_digest() == present.subject_digest()) return std::nullopt;
  if (renewed.subject() != present.subject())
    return ErrorDetails{.expected = present.subject(), .found = renewed.subject()};
  return ErrorDetails{
      .expected = pki::subject_with_types(present),
      .found = pki::subject_with_types(renewed),
      .hint =
          "the CA writes the same subject in another string type, and the GUID depends on it: "
          "stop the participant, put a certificate of this CA in place of cert.pem once "
          "(docs/agent.md), and start it again; from then on the agent renews it. Or let the CA "
          "copy the subject of the request"};
}

}  // namespace ddssec::cli
