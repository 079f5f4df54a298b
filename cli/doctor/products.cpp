#include "cli/doctor/products.hpp"

#include <cstdlib>
#include <optional>

#include <fmt/format.h>

#include "governance/doctor/installed_version.hpp"
#include "governance/doctor/measured_outcomes.hpp"

namespace ddssec::cli {
namespace {

namespace doctor = governance::doctor;
using doctor::Product;

std::optional<doctor::Version> installed(Product product) {
  const char* const path = std::getenv("LD_LIBRARY_PATH");
  return installed_version(product, doctor::library_folders(path != nullptr ? path : ""));
}

void add_note(Report& report, std::string message) {
  report.findings.push_back({.rule = Rule::DOC098, .message = std::move(message)});
}

void note_stand_in(Product product, doctor::Version version, Report& report) {
  const auto known = stand_in(product, version);
  const auto text = to_string(known.version);
  if (known.version != version)
    add_note(report, fmt::format("{} {} is predicted as {}, the {}", family(product),
                                 to_string(version), text,
                                 known.version < version ? "nearest older version that is known"
                                                         : "oldest version that is known"));
  if (known.source == doctor::Source::reported)
    add_note(report, fmt::format("what {} {} does was taken from a review of it and from what "
                                 "older versions were measured to do",
                                 family(product), text));
}

}  // namespace

doctor::Version version_of(const doctor::NamedProduct& product, Report& report) {
  if (product.name == Product::ddssec) return {};
  auto version = product.version ? product.version : installed(product.name);
  if (!version) {
    version = known_versions(product.name).front().version;
    add_note(report, fmt::format("{} was not found on this machine: version {} is assumed",
                                 family(product.name), to_string(*version)));
  }
  note_stand_in(product.name, *version, report);
  return *version;
}

doctor::Lineup installed_lineup() {
  doctor::Lineup out;
  for (const auto product : {Product::cyclonedds, Product::fastdds})
    if (const auto version = installed(product)) out.of(product) = *version;
  return out;
}

std::unexpected<Error> unknown_product_error(const std::string& word, std::string_view before) {
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
      for (const auto product : doctor::kProducts) named.push_back({product});
      continue;
    }
    const auto product = doctor::named_product_from(word);
    if (!product) return unknown_product_error(word, "all, ");
    named.push_back(*product);
  }
  if (named.empty())
    for (const auto product : doctor::kProducts) named.push_back({product});
  Products out;
  for (const auto product : doctor::kProducts) {
    std::optional<doctor::NamedProduct> one;
    for (const auto& next : named) {
      if (next.name != product) continue;
      if (one && one->version && next.version && one->version != next.version)
        return fail(Code::usage, {.field = "--vendor",
                                  .expected = "one version of a product at a time",
                                  .found = fmt::format("{} and {}", to_string(*one->version),
                                                       to_string(*next.version))});
      if (!one || next.version) one = next;
    }
    if (!one) continue;
    out.list.push_back(product);
    if (product != Product::ddssec) out.lineup.of(product) = version_of(*one, report);
  }
  return out;
}

}  // namespace ddssec::cli
