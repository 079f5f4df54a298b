// Predicts which grant of a document Cyclone DDS's own plugins apply to a certificate.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "governance/model.hpp"

namespace ddssec::governance {

/// Returns the parts of a subject that Cyclone DDS's own plugins compare: the texts between `,`,
/// `/` and `|`. They are views into the text.
std::vector<std::string_view> pieces_for_cyclonedds(std::string_view subject);

/// True if Cyclone DDS's own plugins apply a grant for the RFC 2253 subject `grant` to a
/// certificate with the subject `certificate`. They search for each piece of the certificate's
/// subject among those of the grant: a grant for CN=/a/b also applies to CN=/a and CN=/b/a.
bool cyclonedds_applies_grant(std::string_view grant, std::string_view certificate);

/// Index of a document's grants by their pieces. The document must outlive it.
class GrantsForCyclone {
 public:
  explicit GrantsForCyclone(const Permissions& document);

  /// Returns the first grant that applies to a certificate with this RFC 2253 subject, which is the
  /// only one that Cyclone DDS uses, or nullptr.
  const Grant* applied_grant_for(std::string_view certificate) const;

 private:
  std::unordered_map<std::string_view, std::vector<const Grant*>> by_piece_;
};

/// Two documents as Cyclone DDS's own plugins read them for the same certificates: each document
/// has one grant for a certificate, under the certificate's own subject.
struct CycloneDdsDocuments {
  Permissions before, after;
};

/// Returns such pairs for certificates of all subjects of both documents. One subject can be
/// written in several ways in certificates, so there can be several pairs. Empty if Cyclone DDS
/// applies the same grants as ddssec. Subject expressions are left out, because Cyclone DDS refuses
/// such documents.
std::vector<CycloneDdsDocuments> applied_by_cyclonedds(const Permissions& old_document,
                                                       const Permissions& new_document);

/// A grant that Cyclone DDS applies to a certificate of another subject.
struct MisappliedGrant {
  const Grant* grant;
  std::string certificate;  ///< the subject, RFC 2253
  bool has_own = false;     ///< the document has a grant for that subject, which is ignored
};

/// Returns the misapplied grants of the document for certificates of the subjects in `subjects`, in
/// their order. Subject expressions are left out, because Cyclone DDS refuses such documents.
std::vector<MisappliedGrant> misapplied_grants(const Permissions& document,
                                               std::span<const Permissions* const> subjects);

/// Returns a sentence that explains a misapplied grant.
std::string to_sentence(const MisappliedGrant& stray);
inline constexpr std::string_view kStrayGrantHint =
    "put the grants into documents of their own, or let no subject's attributes be a part of "
    "another's";

}  // namespace ddssec::governance
