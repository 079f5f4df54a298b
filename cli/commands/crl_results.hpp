// Results of the commands crl ...
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include <fmt/format.h>

#include "cli/ca/participant_places.hpp"
#include "cli/ca/revocation_lists.hpp"
#include "cli/frame/answer.hpp"
#include "cli/inputs/times.hpp"

namespace ddssec::cli {

/// The facts that a revocation list contains about itself.
struct ListHead {
  std::string issuer;
  ListNumber number;
  WallTime this_update;
  std::optional<WallTime> next_update;

  static ListHead of(const pki::Crl& list) {
    return {list.issuer(), ListNumber::of(list), list.this_update(), list.next_update()};
  }
  static constexpr auto fields() {
    return std::tuple(field<&ListHead::issuer>({.def = "subject"}), field<&ListHead::number>(),
                      field<&ListHead::this_update>(),
                      field<&ListHead::next_update>({"null: none"}));
  }
  std::string until() const {
    return next_update ? "until " + date(*next_update) : "without an end";
  }
};

/// The result of `crl new`.
struct NewList {
  std::filesystem::path file;
  ListHead list;
  std::size_t revoked;

  static constexpr auto fields() {
    return std::tuple_cat(std::tuple(field<&NewList::file>()), fields_within(&NewList::list),
                          std::tuple(field<&NewList::revoked>({"how many"})));
  }
  std::string text() const {
    return fmt::format("{}  number {}, {} revoked, {}\n", file.string(), list.number.text, revoked,
                       list.until());
  }
};

template <>
struct FieldsOf<pki::Revocation> {
  using T = pki::Revocation;
  static constexpr auto fields() {
    return std::tuple(field<&T::serial>({.def = "serial"}), field<&T::time>(), field<&T::reason>());
  }
};

/// One revocation list as `crl show` prints it. Its signature has not been verified.
struct ShownList {
  ListHead list;
  std::vector<pki::Revocation> revoked;

  static constexpr auto fields() {
    return std::tuple_cat(fields_within(&ShownList::list),
                          std::tuple(field<&ShownList::revoked>()));
  }
  std::string text() const {
    auto out =
        fmt::format("issuer   {}\nnumber   {}\nvalid    {} .. {}\n", list.issuer, list.number.text,
                    date(list.this_update), list.next_update ? date(*list.next_update) : "");
    for (const auto& one : revoked)
      out +=
          fmt::format("revoked  {}  {}  {}\n", one.serial, date(one.time), to_string(one.reason));
    return out;
  }
};

/// The result of `crl show`: all lists of a file.
struct ShownLists {
  std::filesystem::path file;
  ShownList first;
  std::vector<ShownList> others;

  static constexpr auto fields() {
    return std::tuple_cat(
        std::tuple(field<&ShownLists::file>()), fields_within(&ShownLists::first),
        std::tuple(field<&ShownLists::others>(
            {.note = "the same of further lists of the file", .has_same_members = true})));
  }
  std::string text() const {
    auto out = first.text();
    for (const auto& one : others) out += "\n" + one.text();
    return out;
  }
};

/// The result of `crl verify`: the list of the given CA whose signature is valid.
struct VerifiedList {
  /// A list in the file.
  struct ListInFile {
    ListHead list;
    bool is_of_another_ca;
  };
  std::filesystem::path file;
  ListHead list;
  std::vector<ListInFile> all = {};

  static constexpr auto fields() {
    return std::tuple_cat(std::tuple(field<&VerifiedList::file>()),
                          fields_within(&VerifiedList::list));
  }
  std::string text() const {
    std::string out;
    for (const auto& [one, is_of_another_ca] : all)
      out += is_of_another_ca
                 ? fmt::format("{}: a list of {} is in it as well\n", file.string(), one.issuer)
                 : fmt::format("{}: {}signed by {}, holds {}\n", file.string(),
                               all.size() > 1 ? fmt::format("number {}, ", one.number.text) : "",
                               one.issuer, one.until());
    return out;
  }
};

/// The numbers of entries of a renewal list.
struct RenewalCounts {
  std::size_t certificates, permissions;

  static constexpr auto fields() {
    return std::tuple(field<&RenewalCounts::certificates>(), field<&RenewalCounts::permissions>());
  }
};

/// The result of `crl distribute`: the folders that got the list, and those that did not, by
/// reason.
struct DistributedLists {
  ListHead list;
  RenewalCounts renewals;
  std::vector<std::string> folders, elsewhere, left_behind, of_other_cas, of_revoked = {},
                                                                          without_permissions = {};

  static constexpr auto fields() {
    using Self = DistributedLists;
    return std::tuple_cat(
        fields_within(&Self::list),
        std::tuple(
            field<&Self::folders>(),
            field<&Self::elsewhere>({"folders that the log knows and this machine does not have"}),
            field<&Self::left_behind>({"here, with a certificate from before a rotation"}),
            field<&Self::of_other_cas>({"here, with a certificate of another CA"}),
            field<&Self::of_revoked>({"here, with a revoked certificate: they get no list"}),
            field<&Self::renewals>({"entries of the renewal list"}),
            field<&Self::without_permissions>(
                {"folders that get none of its permissions: no permissions CA is in them"})));
  }
  std::string text() const {
    std::string out;
    for (const auto& folder : folders) out += folder + "\n";
    out += fmt::format("list {} of {} is in {}, holds {}\n", list.number.text, list.issuer,
                       count_text(folders.size(), "folder"), list.until());
    if (renewals.certificates + renewals.permissions > 0)
      out += fmt::format("renewal list with {} and {}\n",
                         count_text(renewals.certificates, "certificate"),
                         count_text(renewals.permissions, "permissions document"));
    for (const auto& folder : without_permissions)
      out += fmt::format(
          "without the permissions, since no permissions CA is in the folder; copy it there: {}\n",
          folder);
    return out;
  }
};

}  // namespace ddssec::cli
