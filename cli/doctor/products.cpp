#include "cli/doctor/products.hpp"

#include <cstdlib>
#include <optional>

#include <fmt/format.h>

#include "governance/doctor/installed_version.hpp"
#include "governance/doctor/measured_outcomes.hpp"

namespace ddssec::cli {
namespace {

namespace doctor = governance::doctor;
using doctor::Vendor;

std::optional<doctor::Version> installed(Vendor vendor) {
  const char* const path = std::getenv("LD_LIBRARY_PATH");
  return installed_version(vendor, doctor::library_folders(path != nullptr ? path : ""));
}

void add_note(Report& report, std::string message) {
  report.findings.push_back({.rule = Rule::DOC098, .message = std::move(message)});
}

void note_stand_in(Vendor vendor, doctor::Version version, Report& report) {
  const auto known = stand_in(vendor, version);
  const auto text = to_string(known.version);
  if (known.version != version)
    add_note(report, fmt::format("{} {} is predicted as {}, the {}", family(vendor),
                                 to_string(version), text,
                                 known.version < version ? "nearest older version that is known"
                                                         : "oldest version that is known"));
  if (known.source == doctor::Source::reported)
    add_note(report, fmt::format("what {} {} does was taken from a review of it and from what "
                                 "older versions were measured to do",
                                 family(vendor), text));
}

}  // namespace

doctor::Version version_of(const doctor::NamedProduct& product, Report& report) {
  if (product.vendor == Vendor::ddssec) return {};
  auto version = product.version ? product.version : installed(product.vendor);
  if (!version) {
    version = known_versions(product.vendor).front().version;
    add_note(report, fmt::format("{} was not found on this machine: version {} is assumed",
                                 family(product.vendor), to_string(*version)));
  }
  note_stand_in(product.vendor, *version, report);
  return *version;
}

doctor::Lineup installed_lineup() {
  doctor::Lineup out;
  for (const auto vendor : {Vendor::cyclonedds, Vendor::fastdds})
    if (const auto version = installed(vendor)) out.of(vendor) = *version;
  return out;
}

std::unexpected<Error> unknown_vendor_error(const std::string& word, std::string_view before) {
  return fail(Code::usage, {.field = "--vendor",
                            .expected = fmt::format("{}cyclonedds, fastdds or ddssec, the first "
                                                    "two with a version if wanted "
                                                    "(cyclonedds@0.10.5)",
                                                    before),
                            .found = '"' + word + '"'});
}

Result<Products> products_of(const Arguments& arguments, Report& report) {
  std::vector<doctor::NamedProduct> named;
  for (const auto& word : arguments.all("--vendor")) {
    if (word == "all") {
      for (const auto vendor : doctor::kVendors) named.push_back({vendor});
      continue;
    }
    const auto product = doctor::product_from(word);
    if (!product) return unknown_vendor_error(word, "all, ");
    named.push_back(*product);
  }
  if (named.empty())
    for (const auto vendor : doctor::kVendors) named.push_back({vendor});
  Products out;
  for (const auto vendor : doctor::kVendors) {
    std::optional<doctor::NamedProduct> one;
    for (const auto& product : named) {
      if (product.vendor != vendor) continue;
      if (one && one->version && product.version && one->version != product.version)
        return fail(Code::usage, {.field = "--vendor",
                                  .expected = "one version of a product at a time",
                                  .found = fmt::format("{} and {}", to_string(*one->version),
                                                       to_string(*product.version))});
      if (!one || product.version) one = product;
    }
    if (!one) continue;
    out.vendors.push_back(vendor);
    if (vendor != Vendor::ddssec) out.lineup.of(vendor) = version_of(*one, report);
  }
  return out;
}

}  // namespace ddssec::cli
