// Which products, in which versions, a command predicts.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "cli/command.hpp"
#include "governance/doctor/vendor.hpp"

namespace ddssec::cli {

/// Products with one version each.
struct Products {
  std::vector<governance::doctor::Vendor> vendors;
  governance::doctor::Lineup lineup;
};

/// What --vendor says; all of them if it is not given. Versions that are not named are those that
/// are installed. The report gets a note (DOC098) where a version was assumed or stands for
/// another. Error: usage.
Result<Products> products_of(const Arguments& arguments, Report& report);

/// The version of one product: the named one, else the installed one, else the oldest known. Notes
/// as above.
governance::doctor::Version version_of(const governance::doctor::NamedProduct& product,
                                       Report& report);

/// The installed versions, without notes.
governance::doctor::Lineup installed_lineup();

/// Error: usage, of a --vendor that is none: `before` and the vendors may be named.
std::unexpected<Error> unknown_vendor(const std::string& word, std::string_view before);

}  // namespace ddssec::cli
