// Results of the commands ca ...
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include <fmt/format.h>

#include "base/text.hpp"
#include "cli/ca/ca_progress.hpp"
#include "cli/ca/certificate_facts.hpp"
#include "cli/ca/revocation_lists.hpp"
#include "cli/ca/rotation_forecast.hpp"
#include "cli/frame/report.hpp"
#include "cli/inputs/times.hpp"

namespace ddssec::cli {

/// A CA of a folder.
struct CaOfFolder {
  CaFacts ca;
  std::string role;

  static constexpr auto fields() {
    return std::tuple_cat(fields_within(&CaOfFolder::ca),
                          std::tuple(field<&CaOfFolder::role>({.words = kRoles})));
  }
};

/// The result of `ca create`.
struct CreatedCas {
  std::filesystem::path dir;
  bool encrypted;
  std::vector<CaOfFolder> cas;
  bool in_token;  ///< true if the key is in a token

  static constexpr auto fields() {
    return std::tuple(field<&CreatedCas::dir>(), field<&CreatedCas::encrypted>(),
                      field<&CreatedCas::cas>({.min = 1, .max = 2}));
  }
  std::string text() const {
    auto out = fmt::format("created {}{}\n", dir.string(),
                           in_token    ? "  (its key stays in the token)"
                           : encrypted ? ""
                                       : "  (the CA keys are NOT encrypted)");
    for (const auto& [ca, role] : cas)
      out += fmt::format("  {:<12} {}  expires {}\n", role, ca.subject, date(ca.not_after));
    return out;
  }
};

/// The result of `ca import`.
struct ImportedCa {
  CaFacts ca;
  std::string role;
  bool key;

  static constexpr auto fields() {
    return std::tuple_cat(fields_within(&ImportedCa::ca),
                          std::tuple(field<&ImportedCa::role>({.words = kRoles}),
                                     field<&ImportedCa::key>({"true: taken over too"})));
  }
  std::string text() const {
    return fmt::format("imported {}  {} CA, {}\n", ca.subject, role,
                       key ? "with its key" : "without a key: it cannot issue here");
  }
};

/// The protection of a CA's private key: never the key itself.
struct KeyFacts {
  bool encrypted;
  std::string mode;
  std::optional<std::string> token = {};

  static constexpr auto fields() {
    return std::tuple(field<&KeyFacts::encrypted>(),
                      field<&KeyFacts::mode>({.pattern = "^[0-7]{4}$"}),
                      field<&KeyFacts::token>(
                          {.note = "its URI without a PIN, if it is in one", .omits_empty = true}));
  }
  std::string words() const {
    if (token) return "in a token, " + *token;
    return fmt::format("{}, mode {}", encrypted ? "encrypted" : "NOT encrypted", mode);
  }
};

/// The newest revocation list of a CA.
struct ListFacts {
  ListNumber number;
  std::optional<WallTime> next_update;

  static constexpr auto fields() {
    return std::tuple(field<&ListFacts::number>(), field<&ListFacts::next_update>({"null: none"}));
  }
  std::string words() const {
    return fmt::format("revocation list {} until {}", number.text,
                       next_update ? date(*next_update) : "it is replaced");
  }
};

/// One CA of a folder.
struct ShownCa {
  static constexpr std::string_view kDef = "shown_ca";
  std::optional<std::string> role;
  CaFacts ca;
  bool is_ca;
  std::optional<KeyFacts> key;
  std::size_t issued, revoked;
  std::optional<ListFacts> crl;
  std::optional<RotationFacts> rotation = {};
  std::string days_left;

  static constexpr auto fields() {
    return std::tuple_cat(
        std::tuple(
            field<&ShownCa::role>({.note = "null: the folder does not say", .words = kRoles})),
        fields_within(&ShownCa::ca),
        std::tuple(field<&ShownCa::is_ca>(), field<&ShownCa::key>({"null: no key here"}),
                   field<&ShownCa::issued>(), field<&ShownCa::revoked>(),
                   field<&ShownCa::crl>({"null: none"}),
                   field<&ShownCa::rotation>({"null: no overlap, and no folder left"})));
  }
  std::string text() const {
    return fmt::format(
               "subject  {}\nkey      {}, {}\nvalid    {} .. {}  ({} left)\nissued   {}, "
               "{} revoked, {}\nsha256   {}\n",
               ca.subject, ca.algorithm, key ? key->words() : "not here", date(ca.not_before),
               date(ca.not_after), days_left, count_text(issued, "certificate"), revoked,
               crl ? crl->words() : "no revocation list", ca.sha256) +
           (rotation ? rotation->text() : "");
  }
};

/// The result of `ca show`. A folder has one CA, or one for identities and one for permissions.
struct ShownCas {
  ShownCa first;
  std::vector<ShownCa> others = {};

  static constexpr auto fields() {
    return std::tuple_cat(fields_within(&ShownCas::first),
                          std::tuple(field<&ShownCas::others>(
                              {.note = "the same of the folder's other CA, without --role",
                               .has_same_members = true,
                               .max = 1})));
  }
  std::string text() const {
    if (others.empty()) return first.text();
    auto out = titled(first);
    for (const auto& one : others) out += "\n" + titled(one);
    return out;
  }

 private:
  static std::string titled(const ShownCa& one) {
    return fmt::format("{} CA\n{}", one.role.value_or(""), one.text());
  }
};

/// The result of `ca renew`: a new certificate for the same key.
struct RenewedCa {
  CaFacts ca;
  std::filesystem::path dir;
  std::vector<std::string> folders = {};
  std::string steps;  ///< what to do with the new certificate, in words

  static constexpr auto fields() {
    return std::tuple_cat(
        fields_within(&RenewedCa::ca),
        std::tuple(field<&RenewedCa::dir>(),
                   field<&RenewedCa::folders>({"whose participants need the new certificate"})));
  }
  std::string text() const {
    auto out = fmt::format("{}  renewed with the same key, expires {}\n{}", ca.subject,
                           date(ca.not_after), steps);
    for (const auto& folder : folders) out += fmt::format("  {}\n", folder);
    return out;
  }
};

/// A step of a rotation. "until" and the lists are empty where the step has none.
struct RotatedCa {
  std::string role, step;
  std::optional<WallTime> until;  ///< when the former CA should end
  std::string subject;
  WallTime not_after;
  std::string sha256;
  std::vector<std::string> folders = {}, revoked = {}, unlogged = {}, elsewhere = {};
  std::optional<RotationForecast> forecast = {};

  static constexpr auto fields() {
    using Self = RotatedCa;
    return std::tuple(
        field<&Self::role>({.words = kRoles}),
        field<&Self::step>({.note = "replaced, begun, moved, ended, not due",
                            .words = "replaced|begun|moved|ended|not due"}),
        field<&Self::until>({"when the former CA should end; null: no overlap"}),
        field<&Self::subject>({.def = "subject"}), field<&Self::not_after>(),
        field<&Self::sha256>({.def = "sha256"}), field<&Self::folders>({"with new files"}),
        field<&Self::revoked>({"folders left as they were"}),
        field<&Self::unlogged>({"documents signed although the log lacks them"}),
        field<&Self::elsewhere>(
            {"folders, or CAs below, that the log knows and this machine does not have"}),
        field<&Self::forecast>({.note = "with `--dry-run`", .omits_empty = true}));
  }
  std::string text() const {
    auto out = summary();
    for (const auto& name : folders) out += fmt::format("  {}\n", printable(name));
    for (const auto& name : revoked)
      out += fmt::format("revoked and left out: {}\n", printable(name));
    for (const auto& file : unlogged)
      out += fmt::format("signed although the log does not have it: {}\n", printable(file));
    return out;
  }

 private:
  std::string summary() const {
    const auto count = count_text(folders.size(), "folder");
    if (step == "begun")
      return fmt::format("{} CA {} has a successor of that name; until {} both count in {}\n", role,
                         subject, until ? date(*until) : "", count);
    if (step == "moved")
      return fmt::format("{} with what the successor of the {} CA {} issued or signed\n", count,
                         role, subject);
    if (step == "ended")
      return fmt::format("the former {} CA {} has ended; its successor alone counts in {}\n", role,
                         subject, count);
    if (step == "not due")
      return fmt::format("not due: the former {} CA ends on {}\n", role, until ? date(*until) : "");
    return fmt::format("{} CA is {} with a new key now; {} signed again\n", role, subject, count);
  }
};

}  // namespace ddssec::cli
