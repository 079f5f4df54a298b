// Results of the commands keystore ...
#pragma once

#include <filesystem>
#include <string>
#include <tuple>
#include <vector>

#include <fmt/format.h>

#include "base/ids.hpp"
#include "base/text.hpp"
#include "cli/ca/certificate_facts.hpp"
#include "cli/frame/fields.hpp"
#include "cli/inputs/times.hpp"

namespace ddssec::cli {

/// The result of `keystore create`.
struct CreatedKeystore {
  std::filesystem::path dir;
  bool encrypted;
  std::vector<NewCaFacts> cas;

  static constexpr auto fields() {
    return std::tuple(field<&CreatedKeystore::dir>(), field<&CreatedKeystore::encrypted>(),
                      field<&CreatedKeystore::cas>({.min = 2, .max = 2}));
  }
  std::string text() const {
    auto out = fmt::format("created {}{}\n", dir.string(),
                           encrypted ? "" : "  (the CA keys are NOT encrypted)");
    for (const auto& ca : cas) out += fmt::format("  {:<15} {}\n", ca.role + " CA", ca.subject);
    return out;
  }
};

/// The result of `keystore enclave`.
struct MadeEnclave {
  std::string name;
  std::filesystem::path dir;
  std::string subject, serial;
  WallTime not_after;

  static constexpr auto fields() {
    return std::tuple(field<&MadeEnclave::name>(), field<&MadeEnclave::dir>(),
                      field<&MadeEnclave::subject>({.def = "subject"}),
                      field<&MadeEnclave::serial>({.def = "serial"}),
                      field<&MadeEnclave::not_after>());
  }
  std::string text() const {
    return fmt::format("{}  {}  expires {}\n", dir.string(), subject, date(not_after));
  }
};

/// The result of `keystore list`.
struct ListedEnclaves {
  std::vector<std::string> enclaves;

  static constexpr auto fields() { return std::tuple(field<&ListedEnclaves::enclaves>()); }
  std::string text() const {
    std::string out;
    for (const auto& name : enclaves) out += printable(name) + "\n";
    return out;
  }
};

/// The result of `keystore permission`.
struct SignedForEnclave {
  std::string name;
  std::filesystem::path file;
  std::string subject;
  std::string signer;

  static constexpr auto fields() {
    return std::tuple(field<&SignedForEnclave::name>(), field<&SignedForEnclave::file>(),
                      field<&SignedForEnclave::subject>({.def = "subject"}));
  }
  std::string text() const {
    return fmt::format(
        "{}  signed by {}; ddssec's plugins take it while they run, others when they start again\n",
        file.string(), signer);
  }
};

/// The prediction for one enclave.
struct VerifiedEnclave {
  std::string name;
  DomainId domain;
  Json verdicts = Json::object();
  std::string words = {};  ///< the verdicts, with the products' names

  static constexpr auto fields() {
    using Self = VerifiedEnclave;
    return std::tuple(field<&Self::name>(), field<&Self::domain>(),
                      field<&Self::verdicts>({.note = "by vendor", .def = "outcomes"}));
  }
};

/// The result of `keystore verify`. Success does not mean that no key is readable by other users.
struct VerifiedKeystore {
  std::vector<VerifiedEnclave> enclaves = {};
  std::vector<std::string> keys_for_others = {};

  static constexpr auto fields() {
    return std::tuple(field<&VerifiedKeystore::enclaves>(),
                      field<&VerifiedKeystore::keys_for_others>({"that other users can read"}));
  }
  std::string text() const {
    if (enclaves.empty())
      return "there is no enclave in it yet: ddssec keystore enclave KEYSTORE ENCLAVE\n";
    std::string out;
    for (const auto& one : enclaves)
      out += fmt::format("{:<30}  domain {}{}\n", printable(one.name), one.domain, one.words);
    return out;
  }
};

/// The changes to a keystore that another tool made.
struct ImportedKeystore {
  std::vector<std::string> folders_closed = {}, keys_closed = {}, logged = {};
  std::vector<std::string> subjects = {};  ///< the subjects of `logged`
  std::string closed_mode = {};            ///< the mode that a closed folder had
  bool is_complete = false;                ///< true if there was no error

  static constexpr auto fields() {
    using Self = ImportedKeystore;
    return std::tuple(field<&Self::folders_closed>(), field<&Self::keys_closed>(),
                      field<&Self::logged>());
  }
  std::string text() const {
    std::string out;
    for (std::size_t i = 0; i < logged.size(); ++i)
      out += fmt::format("logged {}  {}\n", printable(logged[i]), subjects[i]);
    for (const auto& key : keys_closed)
      out += fmt::format(
          "{} is for its owner only now; other users of this machine may have copied it\n",
          printable(key));
    for (const auto& folder : folders_closed)
      out += fmt::format("{} is for its owner only now; it was mode {}\n", folder, closed_mode);
    return out.empty() && is_complete ? "nothing was left to do\n" : out;
  }
};

}  // namespace ddssec::cli
