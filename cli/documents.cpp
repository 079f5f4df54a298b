#include "cli/documents.hpp"

#include <charconv>
#include <optional>

#include "cli/inputs.hpp"
#include "cli/transaction.hpp"
#include "pki/source.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

/// "3" or "0-5"; nothing if it is neither.
std::optional<governance::DomainRange> range_from(std::string_view text) {
  governance::DomainRange range;
  const auto* const end = text.data() + text.size();
  auto [at, error] = std::from_chars(text.data(), end, range.first);
  range.last = range.first;
  if (error == std::errc() && at != end && *at == '-')
    std::tie(at, error) = [&](auto r) {
      return std::tuple(r.ptr, r.ec);
    }(std::from_chars(at + 1, end, range.last));
  const bool is_whole = error == std::errc() && at == end;
  const bool is_sound =
      0 <= range.first && range.first <= range.last && range.last <= governance::kHighestDomainId;
  return is_whole && is_sound ? std::optional(range) : std::nullopt;
}

}  // namespace

Result<pki::SignedDocument> verified(const fs::path& file, const fs::path& ca, WallTime now) {
  const auto octets = DDSSEC_TRY(read_file(file, pki::kMostDocumentOctets));
  auto anchors = named(
      pki::Certificate::bundle_from_pem(DDSSEC_TRY(read_file(ca, pki::kMostBundleOctets))), ca);
  const auto verifier =
      DDSSEC_TRY(named(pki::DocumentVerifier::make(DDSSEC_TRY(std::move(anchors))), ca));
  return named(verifier.verify(octets, now), file);
}

Result<std::vector<governance::DomainRange>> domain_ranges(const Arguments& arguments,
                                                           std::string_view option) {
  std::vector<governance::DomainRange> out;
  for (const auto& text : arguments.all(option)) {
    const auto range = range_from(text);
    if (!range)
      return fail(Code::usage, {.field = std::string(option),
                                .expected = "a domain such as 3 or a range such as 0-5, up to 230",
                                .found = '"' + text + '"'});
    out.push_back(*range);
  }
  return out;
}

fs::path signed_path(const fs::path& document) {
  return fs::path(document).replace_extension("p7s");
}

Result<std::vector<WrittenFile>> write_document(const std::string& xml, const Arguments& arguments,
                                                const Context& context) {
  fs::path plain = arguments.text("-o");
  std::vector<WrittenFile> out;
  if (!arguments.has("--sign")) {
    out.push_back(DDSSEC_TRY(write_new_file(plain, as_bytes(xml), 0644)));
    return out;
  }
  if (plain.extension() == ".p7s") plain.replace_extension("xml");
  if (!arguments.has("--ca"))
    return fail(Code::usage, {.field = "--sign", .note = "it needs --ca DIR"});
  const auto ca = DDSSEC_TRY(load_ca(ca_folder(arguments.text("--ca"), "permissions"), arguments));
  const auto signature =
      DDSSEC_TRY(ca.sign_document(as_bytes(xml), context.clock.now(), context.random));
  out.push_back(DDSSEC_TRY(write_new_file(plain, as_bytes(xml), 0644)));
  auto second = write_new_file(signed_path(plain), signature, 0644);
  if (!second) {
    std::error_code ignored;
    fs::remove(plain, ignored);
    return std::unexpected(second.error());
  }
  out.push_back(*std::move(second));
  return out;
}

}  // namespace ddssec::cli
