#include "plugins/spi/renewal_list_places.hpp"

#include <algorithm>

#include "base/uri_source.hpp"
#include "plugins/spi/property_names.hpp"

namespace ddssec::spi {
namespace {

// The name in a pki::ParticipantFolder.
constexpr std::string_view kUsualName = "renewed.pem";

}  // namespace

Result<std::vector<std::string>> renewal_list_places(const PropertyList& properties) {
  std::vector<std::string> uris;
  const auto named = property_value(properties, property::kRenewalList);
  if (!named.empty()) {
    const auto path = file_named_by(absolute_uri(named));
    if (path) return std::vector{"file:" + *path};
    return fail(Code::invalid_property, {.document = std::string(property::kRenewalList),
                                         .expected = "file:PATH",
                                         .found = std::string(named.substr(0, 64))});
  }
  for (const auto name : {property::kIdentityCertificate, property::kIdentityCa}) {
    const auto file = file_named_by(absolute_uri(property_value(properties, name)));
    if (!file) continue;
    const auto slash = file->rfind('/');
    auto uri = "file:" + file->substr(0, slash == std::string::npos ? 0 : slash + 1) +
               std::string(kUsualName);
    if (std::ranges::find(uris, uri) == uris.end()) uris.push_back(std::move(uri));
  }
  return uris;
}

}  // namespace ddssec::spi
