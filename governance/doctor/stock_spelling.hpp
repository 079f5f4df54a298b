// What stock products start with although ddssec does not read it: it cannot say what they then
// allow. Measured with Cyclone DDS 0.10.2.
#pragma once

#include <string_view>

#include "governance/doctor/loaded_folder.hpp"

namespace ddssec::governance::doctor {

/// True if Cyclone DDS starts with a document of which ours reports `error`: it reads numbers as
/// strtol does (+0, 0x0, nothing), takes any word as <default> or <not_before>, passes over empty
/// elements, and attributes that stand twice.
bool cyclonedds_starts_with(const Error& error);

/// True if a file holds certificates under one of OpenSSL's other labels, such as X509 CERTIFICATE.
bool has_other_certificate_label(const std::filesystem::path& path);
/// True if it is a key of 256 bits whose curve is written out.
bool is_key_of_explicit_curve(const Error& error);

/// The file with which Cyclone DDS starts and of which ddssec cannot say what it then does; null if
/// there is none.
const std::filesystem::path* unpredictable_file(const LoadedFolder& folder);

}  // namespace ddssec::governance::doctor
