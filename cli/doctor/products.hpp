// The products and versions for which a command predicts.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "cli/frame/command.hpp"
#include "governance/doctor/product.hpp"

namespace ddssec::cli {

/// Products with one version each.
struct Products {
  std::vector<governance::doctor::Product> list;
  governance::doctor::Lineup lineup;
};

/// Returns the products of --vendor, or all if it is not given. Versions that are not given are the
/// installed ones. The report gets a note (DOC098) if a version was assumed, or if it stands for
/// another one. Error: usage.
Result<Products> products_of(const Arguments& arguments, Report& report);

/// Returns the version of one product: the named one, or else the installed one, or else the oldest
/// known. Adds notes as products_of does.
governance::doctor::Version version_of(const governance::doctor::NamedProduct& product,
                                       Report& report);

/// Returns the installed versions, without notes.
governance::doctor::Lineup installed_lineup();

/// Returns the error usage for an unknown --vendor. `before` and the products are the valid values.
std::unexpected<Error> unknown_product_error(const std::string& word, std::string_view before);

}  // namespace ddssec::cli
