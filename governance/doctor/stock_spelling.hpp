// Recognises documents with which stock products start although ddssec does not parse them, so that
// ddssec cannot tell what they allow. Measured with Cyclone DDS 0.10.2 and Fast DDS 2.9.1.
#pragma once

#include "governance/doctor/loaded_folder.hpp"

namespace ddssec::governance::doctor {

/// True if Cyclone DDS starts, or may start, with a document for which ddssec reports `error`.
/// Cyclone DDS reads numbers like strtol (+0, -0, 0x0, nothing), accepts any word as <default> or
/// <not_before>, and ignores empty elements and repeated attributes. If an element is there several
/// times instead of once, the last one counts.
bool cyclonedds_starts_with(const Error& error);
/// As cyclonedds_starts_with, for Fast DDS: it reads numbers that are out of range, days that no
/// month has, dates as std::get_time does, ranges that end before they begin, text between elements
/// and a second root element, and uses the first of several elements in permissions.
bool fastdds_starts_with(const Error& error);

/// True if OpenSSL, and so a stock product, reads a certificate from the file, whatever text is
/// before it and whatever label it has (such as X509 CERTIFICATE). Measured for files of 70 kB and
/// with each label.
bool has_certificate_for_openssl(const std::filesystem::path& path);
/// True for a 256-bit key with explicit curve parameters.
bool is_key_of_explicit_curve(const Error& error);

/// Returns the file with which the product starts although ddssec cannot predict the effect, or
/// nullptr.
const std::filesystem::path* unpredictable_file(const LoadedFolder& folder, Product product,
                                                const Lineup& lineup = {});

}  // namespace ddssec::governance::doctor
