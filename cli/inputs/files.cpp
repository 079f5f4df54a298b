#include "cli/inputs/files.hpp"

#include <algorithm>

#include "cli/frame/held_folder.hpp"
#include "pki/certificate_source.hpp"
#include "pki/participant_folder.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

std::string uri(const fs::path& path) { return "file://" + path.string(); }

}  // namespace

// A file may have been read by the path of its folder's descriptor, which users cannot understand.
std::unexpected<Error> file_error(const Error& error, const fs::path& path) {
  return std::unexpected(pki::file_error(pki::file_error(error, path_in_held_folder(path)), path));
}

Result<Bytes> read_file(const fs::path& path, std::size_t max_octets) {
  auto octets = pki::load_uri(uri(path_in_held_folder(path)), "", max_octets);
  if (!octets) return file_error(octets.error(), path);
  return octets;
}

bool path_exists(const fs::path& path) {
  std::error_code ignored;
  return fs::exists(path_in_held_folder(path), ignored);
}

Status check_directory(const fs::path& folder, std::string_view expected) {
  std::error_code error;
  const auto type = fs::status(folder, error).type();
  if (type == fs::file_type::directory) return {};
  ErrorDetails details{.document = folder, .expected = std::string(expected)};
  if (type == fs::file_type::not_found) return fail(Code::file_not_found, std::move(details));
  if (type == fs::file_type::none)
    details.note = error.message();
  else
    details.found = "a file";
  return fail(Code::file_unreadable, std::move(details));
}

Result<pki::Certificate> read_certificate(const fs::path& path) {
  DDSSEC_ASSIGN_OR_RETURN(const auto octets, read_file(path, pki::kMaxCertificateOctets));
  auto certificate = pki::Certificate::from_pem(octets);
  if (!certificate) return file_error(certificate.error(), path);
  return certificate;
}

fs::path certificate_path(const fs::path& given) {
  std::error_code ignored;
  return fs::is_directory(given, ignored) ? pki::participant_folder(given).certificate : given;
}

std::string folder_name(const fs::path& folder) {
  const auto clean = folder.lexically_normal();
  return (clean.has_filename() ? clean : clean.parent_path()).filename().string();
}

Result<std::vector<std::string>> read_topics(const fs::path& file) {
  constexpr std::size_t kMaxOctets = 4 * 1024 * 1024;
  DDSSEC_ASSIGN_OR_RETURN(const auto octets, read_file(file, kMaxOctets));
  std::vector<std::string> out;
  std::string_view rest = as_text(octets);
  while (!rest.empty()) {
    const auto end = std::min(rest.find('\n'), rest.size());
    auto line = rest.substr(0, end);
    if (line.ends_with('\r')) line.remove_suffix(1);
    if (!line.empty() && line.front() != '#') out.emplace_back(line);
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  if (!out.empty()) return out;
  return fail(Code::usage,
              {.document = file, .field = "--topics", .expected = "a topic on each line"});
}

}  // namespace ddssec::cli
