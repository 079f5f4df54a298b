// Creates one file through the descriptor of its folder, and describes what could not be written.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "base/bytes.hpp"
#include "base/file_descriptor.hpp"
#include "base/result.hpp"
#include "cli/frame/report.hpp"

namespace ddssec::cli {

/// From now on nothing is written (--dry-run): every check is made, and the files that would be
/// written are reported.
void write_nothing();
/// True after write_nothing().
bool writes_nothing();

/// Returns the folder of a path; "." for a bare name.
std::filesystem::path folder_of(const std::filesystem::path& path);
/// Returns the error file_unwritable for a path, by errno; it reports a missing folder.
std::unexpected<Error> unwritable_error(const std::filesystem::path& path, int error);
/// Returns the error of a rename that must not replace anything, by errno: would_overwrite or
/// file_unwritable.
std::unexpected<Error> rename_failed_error(const std::filesystem::path& target, int error);
/// Success if there is nothing at the path, not even a dangling link, and its folder exists.
/// Errors: would_overwrite, file_unwritable.
Status check_nothing_at(const std::filesystem::path& path);

/// A path of a file. If it is relative, it starts at `folder`, a descriptor.
struct FilePlace {
  int folder;
  std::string path;
};

enum class Flush : std::uint8_t { now, later };

/// Creates a file that does not exist, without following links. On error the descriptor is -1, with
/// errno.
FileDescriptor open_new(const FilePlace& at, unsigned mode);
/// Writes everything. Returns 0 or errno.
int write_all(int file, BytesView octets);
/// Writes to a file of open_new and closes it. On an error the file is removed. `meant` is its
/// final path, which errors name. Error: file_unwritable.
Status write_and_close(FileDescriptor file, const FilePlace& at, const std::filesystem::path& meant,
                       BytesView octets, Flush flush);

/// Returns the line of the report about a file.
WrittenFile written_file(const std::filesystem::path& path, BytesView octets, unsigned mode);

}  // namespace ddssec::cli
