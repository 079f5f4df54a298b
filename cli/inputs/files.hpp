// Files and folders that commands read.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "base/bytes.hpp"
#include "base/result.hpp"
#include "pki/certificate.hpp"

namespace ddssec::cli {

/// Returns the error about a file. The user knows the file by `path`, but it may have been read by
/// the path of its folder's descriptor.
std::unexpected<Error> file_error(const Error& error, const std::filesystem::path& path);

/// Reads a whole file. Errors: those of pki::load, with the path.
Result<Bytes> read_file(const std::filesystem::path& path, std::size_t max_octets);

/// The first certificate of a PEM file. Errors: those of read_file and Certificate::from_pem.
Result<pki::Certificate> read_certificate(const std::filesystem::path& path);

/// True if something exists at `path`. False for a dangling link, and for a file in a folder that
/// cannot be searched: the command reports that when it writes there (compare pki::may_exist).
bool path_exists(const std::filesystem::path& path);

/// Success if a folder can be read. Errors: file_not_found, file_unreadable (not a folder, or not
/// accessible); both name what was `expected`.
Status check_directory(const std::filesystem::path& folder, std::string_view expected);

/// The path of a certificate: the one in a participant's folder, or `given` itself.
std::filesystem::path certificate_path(const std::filesystem::path& given);

/// The name of a folder: the last part of its path.
std::string folder_name(const std::filesystem::path& folder);

/// Reads a file with one topic per line; empty lines and those that begin with '#' are skipped.
/// Errors: those of read_file; usage if there is no topic.
Result<std::vector<std::string>> read_topics(const std::filesystem::path& file);

}  // namespace ddssec::cli
