// A local participant: the documents by which it judges, and the topics that it uses.
#pragma once

#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "governance/decision.hpp"
#include "plugins/access_control/documents.hpp"
#include "plugins/spi/end_warning.hpp"
#include "plugins/spi/handles.hpp"

namespace ddssec::access_control {

class ListedPermissions;

/// The documents by which a local participant judges itself and its peers. The object is replaced
/// as a whole.
struct JudgingDocuments {
  std::shared_ptr<const PermissionsCa> ca;
  std::shared_ptr<const governance::CompiledGovernance> governance;
  Sha256Digest governance_digest{};  ///< digest of its signed text
  /// identity_ca, if the governance restricts algorithms
  std::vector<pki::Certificate> identity_authorities = {};

  /// Returns the lists of the governance, or nullptr if all algorithms are allowed.
  const governance::AllowedAlgorithms* allowed_algorithms() const {
    const auto& allowed = governance->domain_rule().allowed_algorithms;
    return allowed ? &*allowed : nullptr;
  }
};

/// A local participant. Thread-safe, once it is shared.
class LocalParticipant {
 public:
  /// The largest number of topics that are remembered.
  static constexpr std::size_t kMaxTopicsInUse = 4096;

  /// Set once, before the object is shared, and only read afterwards: they need no lock.
  spi::IdentityHandle identity = {};
  DomainId domain = 0;
  std::string domain_tag = {};
  std::string governance_name = {};  ///< the document's name in errors
  spi::WarningDays warn_before_end = {};

  /// Returns the documents in force.
  std::shared_ptr<const JudgingDocuments> judging_documents() const;
  /// Records that the topic is in use, because the host asks how it is protected and keeps the
  /// answer. Builtin topics are not recorded. Returns the documents in force. Error:
  /// governance_change_under_way, if the topic comes into use while a document waits that cannot be
  /// applied to it; it then is not in use.
  Result<std::shared_ptr<const JudgingDocuments>> use_topic(std::string_view topic);
  /// Notes that the host no longer uses the topic, and has no attributes of it.
  void forget_topic(std::string_view topic);
  /// The way in which a governance document may replace the one in force.
  enum class Change : std::uint8_t {
    at_once,  ///< the domain, and each topic that is in use, are protected as before
    phased,   ///< the domain or some of the topics are protected more
  };
  /// Success if the document adds topic rules, or raises what topics or the domain are protected
  /// with (governance::live_change), and has a higher revision. It may also have none if the one in
  /// force has none and nothing is protected more. Error: governance_renewal_refused.
  Result<Change> check_governance(const governance::CompiledGovernance& next) const;
  /// Sets the documents; their governance must be one that can be taken at once. Error: that of
  /// check_governance, if the governance differs from the former one.
  Status set_judging_documents(JudgingDocuments documents);

  /// Returns the permissions in the renewal list; nullptr if there are none.
  std::shared_ptr<const ListedPermissions> listed() const;
  void set_listed(std::shared_ptr<const ListedPermissions> listed);

  /// A governance document that waits until the host has changed the protection of its endpoints.
  struct PendingGovernance {
    std::shared_ptr<const governance::CompiledGovernance> governance;
    Sha256Digest digest{};  ///< digest of its signed text
  };
  /// Returns the document that waits; nullptr if none does.
  std::shared_ptr<const PendingGovernance> pending() const;
  /// Makes a document wait. It replaces one that waits already.
  void set_pending(PendingGovernance pending);
  /// Gives up the document that waits, if there is one. The document in force stays.
  void drop_pending();
  /// Returns the rules of the document with that digest; nullptr unless it waits, or was in force
  /// before the last one that waited.
  std::shared_ptr<const governance::CompiledGovernance> governance_of(
      const Sha256Digest& digest) const;
  /// Puts the document with that digest, which waited, into force. Returns false if it does not
  /// wait.
  bool apply_pending(const Sha256Digest& digest);

 private:
  Status check_new_topic(std::string_view topic) const;
  Result<Change> check(const governance::CompiledGovernance& next) const;

  mutable std::mutex mutex_;
  std::shared_ptr<const JudgingDocuments> judging_documents_;
  std::shared_ptr<const PendingGovernance> pending_;
  std::shared_ptr<const ListedPermissions> listed_;
  PendingGovernance
      former_;  ///< in force before the last document that waited; nullptr: there was none
  std::set<std::string, std::less<>> topics_in_use_;
  bool has_more_topics_ = false;
};

}  // namespace ddssec::access_control
