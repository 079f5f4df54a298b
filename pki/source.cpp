#include "pki/source.hpp"

namespace ddssec::pki {

Result<KeyPem> load_key(std::string_view uri, std::string_view property) {
  return load_secret<KeyPem>(uri, property);
}

Error about_file(const Error& error, const std::filesystem::path& path) {
  auto details = error.details();
  details.document = path;
  if (details.found == path) details.found.clear();
  return Error(error.code(), std::move(details));
}

}  // namespace ddssec::pki
