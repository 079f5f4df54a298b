// The subject that work and places are charged to.
#pragma once

#include <cstdint>

namespace ddssec::cryptography {

/// Names the subject of a certificate, whose participants share limits; see subject_of.
using SubjectId = std::uint64_t;

}  // namespace ddssec::cryptography
