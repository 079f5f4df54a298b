#include "base/uri_source.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <fcntl.h>
#include <filesystem>
#include <string>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>

#include "base/errno_text.hpp"
#include "base/file_descriptor.hpp"

namespace ddssec {
namespace {

Result<std::size_t> file_size(const FileDescriptor& file, const std::string& path) {
  if (file.number() < 0) {
    if (errno == ENOENT || errno == ENOTDIR)
      return fail(Code::file_not_found, {.note = "looked for " + path});
    return fail(Code::file_unreadable, {.found = path, .note = errno_text(errno)});
  }
  struct stat status {};
  if (::fstat(file.number(), &status) != 0)
    return fail(Code::file_unreadable, {.found = path, .note = errno_text(errno)});
  if (!S_ISREG(status.st_mode))
    return fail(Code::file_unreadable, {.expected = "a regular file", .found = path});
  return static_cast<std::size_t>(status.st_size);
}

// Reads until `out` is full or the file ends. Returns the number of octets that were read.
Result<std::size_t> read_up_to(const FileDescriptor& file, const std::string& path,
                               MutableBytes out) {
  std::size_t done = 0;
  while (done < out.size()) {
    const auto got = ::read(file.number(), out.data() + done, out.size() - done);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return fail(Code::file_unreadable, {.found = path, .note = errno_text(errno)});
    if (got == 0) break;
    done += static_cast<std::size_t>(got);
  }
  return done;
}

enum class Scheme { file, data };
struct Uri {
  Scheme scheme;
  std::string_view rest;
};

std::string_view without_blanks(std::string_view uri) {
  return uri.substr(std::min(uri.find_first_not_of(" \t\r\n"), uri.size()));
}

Result<Uri> parse_uri(std::string_view uri) {
  uri = without_blanks(uri);
  if (uri.empty()) return fail(Code::missing_property);
  if (uri.starts_with("data:,")) return Uri{Scheme::data, uri.substr(6)};
  if (uri.starts_with("file://")) return Uri{Scheme::file, uri.substr(7)};
  if (uri.starts_with("file:")) return Uri{Scheme::file, uri.substr(5)};
  if (names_token(uri)) return fail(Code::pkcs11_unsupported, {.found = without_pin(uri)});
  const std::string start(uri.substr(0, 64));
  // A key pasted without "data:," must not reach a log.
  const bool pasted = uri.find("-----BEGIN") != uri.npos;
  return fail(Code::unsupported_uri, {.expected = "file:PATH or data:,TEXT",
                                      .found = pasted ? "PEM text without data:," : start});
}

Result<Bytes> load_file(const std::string& path, std::size_t max_octets) {
  // O_NONBLOCK keeps a FIFO in place of the file from blocking the process.
  const FileDescriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  DDSSEC_ASSIGN_OR_RETURN(const std::size_t size, file_size(file, path));
  if (size > max_octets)
    return std::unexpected(too_many_octets_error(Code::file_too_large, max_octets, size));
  Bytes octets(size);
  const auto read = read_up_to(file, path, octets);
  if (!read) {
    wipe(octets);  // it may be a key
    return std::unexpected(read.error());
  }
  octets.resize(*read);
  if (octets.empty()) return fail(Code::item_empty, {.found = path});
  return octets;
}

Result<Bytes> load_unnamed(std::string_view text, std::size_t max_octets) {
  DDSSEC_ASSIGN_OR_RETURN(const Uri uri, parse_uri(text));
  if (uri.scheme == Scheme::file) return load_file(std::string(uri.rest), max_octets);
  if (uri.rest.empty()) return fail(Code::item_empty);
  if (uri.rest.size() > max_octets)
    return std::unexpected(
        too_many_octets_error(Code::file_too_large, max_octets, uri.rest.size()));
  return to_bytes(as_bytes(uri.rest));
}

// True for attributes of RFC 7512 that tell where an object is. Any other attribute, such as a
// misspelt pin-value, may be a secret.
bool is_shown(std::string_view attribute) {
  constexpr std::array<std::string_view, 13> kShown = {"token",
                                                       "manufacturer",
                                                       "serial",
                                                       "model",
                                                       "library-manufacturer",
                                                       "library-version",
                                                       "library-description",
                                                       "object",
                                                       "type",
                                                       "id",
                                                       "slot-manufacturer",
                                                       "slot-description",
                                                       "slot-id"};
  return std::ranges::find(kShown, attribute) != kShown.end();
}

}  // namespace

Error too_many_octets_error(Code code, std::size_t max_octets, std::size_t found) {
  return Error(code, {.expected = "at most " + std::to_string(max_octets) + " octets",
                      .found = std::to_string(found)});
}

Result<Bytes> load_uri(std::string_view uri, std::string_view property, std::size_t max_octets) {
  return with_default_document(load_unnamed(uri, max_octets), std::string(property));
}

Result<Bytes> load_secret_octets(std::string_view uri, std::string_view property,
                                 std::size_t max_octets) {
  auto octets = load_uri(uri, property, max_octets);
  // A secret pasted without "data:," must not reach a log.
  if (octets || octets.error().code() != Code::unsupported_uri) return octets;
  return fail(Code::unsupported_uri, {.document = std::string(property),
                                      .expected = "file:PATH or data:,TEXT",
                                      .found = "neither"});
}

bool names_token(std::string_view uri) { return without_blanks(uri).starts_with("pkcs11:"); }

std::string without_pin(std::string_view uri) {
  constexpr std::size_t kMax = 256;
  constexpr std::string_view kScheme = "pkcs11:";
  uri = without_blanks(uri);
  if (!uri.starts_with(kScheme)) return {};
  std::string out(kScheme);
  auto rest = uri.substr(kScheme.size());
  while (!rest.empty() && out.size() < kMax) {
    const auto attribute = rest.substr(0, rest.find_first_of(";?&"));
    rest.remove_prefix(std::min(attribute.size() + 1, rest.size()));
    const auto name = attribute.substr(0, attribute.find('='));
    if (name == attribute || !is_shown(name)) continue;
    if (!out.ends_with(':')) out += ';';
    // A value with another "=" may hold the next attribute after a wrong separator.
    const auto value = attribute.substr(name.size() + 1);
    out.append(name).append("=").append(value.substr(0, value.find('=')));
  }
  out.resize(std::min(out.size(), kMax));
  return out;
}

std::optional<std::string> file_named_by(std::string_view text) {
  const auto uri = parse_uri(text);
  if (!uri || uri->scheme != Scheme::file) return std::nullopt;
  return std::string(uri->rest);
}

std::string absolute_uri(std::string_view uri) {
  const auto path = file_named_by(uri);
  if (!path || path->empty() || path->front() == '/') return std::string(uri);
  std::error_code error;
  const auto absolute = std::filesystem::absolute(*path, error);
  return error ? std::string() : "file:" + absolute.string();
}

bool readable_by_others(std::string_view text) {
  const auto path = file_named_by(text);
  struct stat status {};
  return path && ::stat(path->c_str(), &status) == 0 && (status.st_mode & (S_IRGRP | S_IROTH)) != 0;
}

}  // namespace ddssec
