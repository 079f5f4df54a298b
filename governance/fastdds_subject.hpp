// Predicts whether Fast DDS applies a grant to a certificate, by the texts of both subjects.
#pragma once

#include <string_view>

namespace ddssec::governance {

/// True if Fast DDS 2.9 applies a grant for the text `grant` to a certificate with the RFC 2253
/// subject `certificate`, in UTF-8. It compares part by part, ignoring spaces beside a `,`, and
/// stops at an empty part (measured).
bool fastdds_takes(std::string_view grant, std::string_view certificate);

/// As fastdds_takes, for Fast DDS 3.1: neither the order of the parts nor spaces around '=' matter,
/// and a part without '=' is the end (measured).
bool fastdds3_applies_grant(std::string_view grant, std::string_view certificate);

}  // namespace ddssec::governance
