// The subject that work and places are charged to.
#pragma once

#include <cstddef>
#include <cstdint>

#include "base/ids.hpp"

namespace ddssec::cryptography {

/// Names the subject of a certificate, whose participants share limits; see subject_of.
using SubjectId = std::uint64_t;

/// The first octets of a prefix, which a participant derives from the subject of its certificate
/// (DDS-Security 1.2, clause 10.3.3).
inline constexpr std::size_t kSubjectSize = 6;

/// Returns the subject that the prefix names. Only the authentication of its participant proves it.
inline SubjectId named_subject(const GuidPrefix& prefix) {
  SubjectId subject = 0;
  for (std::size_t i = 0; i < kSubjectSize; ++i) subject = subject << 8 | prefix.octets[i];
  return subject;
}

}  // namespace ddssec::cryptography
