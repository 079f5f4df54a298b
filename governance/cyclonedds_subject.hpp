// Which grant of a document Cyclone DDS's own plugins take for a certificate.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "governance/model.hpp"

namespace ddssec::governance {

/// The parts of a subject that Cyclone DDS's own plugins compare: the text between `,`, `/` and
/// `|`. Views into the text.
std::vector<std::string_view> pieces_for_cyclonedds(std::string_view subject);

/// True if Cyclone DDS's own plugins take a grant of one RFC 2253 subject for a certificate of the
/// other. They look for each piece of the certificate among those of the grant: a grant for CN=/a/b
/// is taken for CN=/a and CN=/b/a, too.
bool cyclonedds_takes(std::string_view grant, std::string_view certificate);

/// The grants of one document by their pieces. The document must outlive it.
class GrantsForCyclone {
 public:
  explicit GrantsForCyclone(const Permissions& document);

  /// The first grant that is taken for a certificate with this RFC 2253 subject, which is the only
  /// one that Cyclone DDS looks at; null if there is none.
  const Grant* taken_for(std::string_view certificate) const;

 private:
  std::unordered_map<std::string_view, std::vector<const Grant*>> by_piece_;
};

/// Two documents, as Cyclone DDS's own plugins read them for the same certificates: of each
/// document one grant for a certificate, under the certificate's own subject.
struct TakenByCyclone {
  Permissions before, after;
};

/// For certificates of all subjects of both documents. One subject can be written in several ways
/// in certificates, so there can be several pairs; nothing: they take what ddssec takes. Subject
/// expressions are left out: Cyclone DDS refuses such documents.
std::vector<TakenByCyclone> taken_by_cyclonedds(const Permissions& old_document,
                                                const Permissions& new_document);

/// A grant that Cyclone DDS takes for a certificate of another subject.
struct StrayGrant {
  const Grant* grant;
  std::string certificate;  ///< the subject, RFC 2253
  bool has_own = false;     ///< the document has a grant for that subject, which is passed over
};

/// Those of the document for certificates of the subjects of `subjects`, in the order of these.
/// Subject expressions are left out: Cyclone DDS refuses such documents.
std::vector<StrayGrant> stray_grants(const Permissions& document,
                                     std::span<const Permissions* const> subjects);

/// What a stray grant means, as a sentence.
std::string to_sentence(const StrayGrant& stray);
inline constexpr std::string_view kStrayGrantHint =
    "put the grants into documents of their own, or let no subject's attributes be a part of "
    "another's";

}  // namespace ddssec::governance
