// Finds subjects that Cyclone DDS's own plugins cannot distinguish.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <unordered_map>
#include <vector>

#include "base/clock.hpp"
#include "cli/frame/report.hpp"
#include "pki/certificate.hpp"
#include "pki/issue_log.hpp"

namespace ddssec::cli {

/// The subjects of valid certificates. Cyclone DDS's own plugins give a certificate the permissions
/// of every subject that has all attributes of the certificate.
class SubjectsInUse {
 public:
  /// Reads the subjects in a CA's log. Certificates for `folder`, which gets a new one, are left
  /// out.
  SubjectsInUse(const pki::IssueLog& log, const std::filesystem::path& folder, WallTime now);

  /// Adds a subject. `where` is the name of its certificate in messages.
  void add(const std::string& subject, std::string where);
  /// Success unless another subject in use has all attributes of this one, or only attributes of
  /// this one. Error: subject_taken.
  Status check(const std::string& subject) const;

 private:
  struct Entry {
    std::string subject;
    std::string where;
  };
  Status check(const std::string& subject, const std::vector<std::size_t>& entries) const;

  std::vector<Entry> entries_;
  /// The indices of entries that contain a piece, and of those that begin with it.
  std::unordered_map<std::string, std::vector<std::size_t>> entries_with_piece_,
      entries_by_first_piece_;
};

/// Finds participants of a fleet that neither permissions nor a revocation can distinguish.
class SubjectsOfFleet {
 public:
  explicit SubjectsOfFleet(std::filesystem::path fleet) : fleet_(std::move(fleet)) {}

  /// Adds the error subject_shared if another participant has the subject.
  void add(const std::string& name, const pki::Certificate& certificate, Report& report);

 private:
  std::filesystem::path fleet_;
  std::map<std::string, std::string> names_;  ///< by SubjectName::key()
};

}  // namespace ddssec::cli
