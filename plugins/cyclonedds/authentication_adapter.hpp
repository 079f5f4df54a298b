// Adapts spi::Authentication to Cyclone's dds_security_authentication.
#pragma once

#include <set>

#include "plugins/cyclonedds/adapter_calls.hpp"
#include "plugins/cyclonedds/core_timer.hpp"
#include "plugins/cyclonedds/dispose_announcements.hpp"
#include "plugins/cyclonedds/expiry_timer.hpp"
#include "plugins/cyclonedds/governance_facts.hpp"
#include "plugins/cyclonedds/handshake_watch.hpp"
#include "plugins/cyclonedds/lost_sessions.hpp"
#include "plugins/cyclonedds/own_announcements.hpp"
#include "plugins/cyclonedds/remote_identities.hpp"
#include "plugins/cyclonedds/shared_secrets.hpp"
#include "plugins/spi/authentication.hpp"

namespace ddssec::cyclonedds {

/// The adapter of one domain. The C struct is the base class; the host sees only that.
class AuthenticationAdapter final : public dds_security_authentication {
 public:
  /// How long the timer waits. Tests shorten it.
  struct Pace {
    std::chrono::milliseconds step{1000};      ///< between two turns, at most
    std::chrono::milliseconds patience{4000};  ///< for a new session with a peer that is back
    /// How long a handshake that was under way when permissions were renewed can go on, with the
    /// former ones, after the host has dropped the peer and discovered it again.
    std::chrono::milliseconds kept_handshake{10000};
  };
  AuthenticationAdapter(std::unique_ptr<Host> host, const MakePlugin<spi::Authentication>& make,
                        ddsi_domaingv* domain, Pace pace);
  AuthenticationAdapter(std::unique_ptr<Host> host, const MakePlugin<spi::Authentication>& make,
                        ddsi_domaingv* domain)
      : AuthenticationAdapter(std::move(host), make, domain, Pace{}) {}

  static AuthenticationAdapter& of(dds_security_authentication& instance) {
    return static_cast<AuthenticationAdapter&>(instance);
  }
  Host& host() { return *host_; }
  spi::Authentication& plugin() { return *plugin_; }
  SharedSecrets& secrets() { return secrets_; }
  RemoteIdentities& remotes() { return remotes_; }
  HandshakeWatch& watch() { return watch_; }
  HandshakeWatch::CoreTimerState stop_core_timer(const CoreTimer::Call& call) const {
    using enum HandshakeWatch::CoreTimerState;
    return core_timer_.stop(call) ? stopped : runs;
  }
  LostSessions& lost_sessions() { return lost_sessions_; }
  DisposeAnnouncements& dispose_announcements() { return dispose_announcements_; }
  OwnAnnouncements& own_announcements() { return own_announcements_; }

  /// Sets the listener. nullptr stops the timer; the call returns when no revocation is running any
  /// more.
  void listen(const dds_security_authentication_listener* listener);

 private:
  using Revoke = std::function<void(std::int64_t)>;
  /// True if this domain of the process has another local participant that has not expired.
  bool has_others(spi::IdentityHandle local) const;
  /// Makes later handshakes present permissions that access control has renewed.
  void present_renewed_permissions();
  /// Notes the sessions that must end, if renewed permissions changed the rights of an endpoint.
  void note_changed_rights(spi::IdentityHandle local, std::uint64_t changes);
  /// Makes the host begin again with the peers of the noted sessions. Returns true if there was
  /// any.
  bool revoke_noted(const std::stop_token& stop, const Revoke& revoke);
  /// Forgets the noted sessions with the peer that are over, or need not end. Returns true if one
  /// is to end now.
  bool take_noted(const Guid& remote, std::chrono::nanoseconds now);
  /// Handles a peer whose certificate has ended, or no longer counts.
  void cut_off_peer(spi::IdentityHandle remote, const Revoke& revoke);
  /// Makes the host begin again with peers whose handshake does not finish.
  void revoke_stuck(const std::stop_token& stop, const Revoke& revoke);
  /// Makes a peer that does not answer begin again too.
  void send_dispose_announcement(const Guid& peer);
  /// Makes the host begin again with peers that have lost their session with a local participant.
  /// If `resets_peers`, peers are to be reset in any case.
  void follow_resets(const std::stop_token& stop, const Revoke& revoke, bool resets_peers);
  /// True if the peer has ended its session within the last second.
  bool was_just_ended(const Guid& guid) const;
  /// Does one turn of follow_resets. Returns true if there was any such peer.
  bool revoke_reset(const std::stop_token& stop, const Revoke& revoke);
  /// Makes the host begin again with peers that have endpoints whose keys only a new session
  /// brings.
  void revoke_stranded(const std::stop_token& stop, const Revoke& revoke);
  /// Makes peers begin again whose session the local host has lost.
  void send_resets();
  /// Announces local participants to peers whose session was reset a while ago.
  void send_announcements();
  /// Reports peers that ended their session a while ago and are discovered again, without a new
  /// session.
  void report_ended_by_peer();

  std::unique_ptr<Host> host_;
  std::unique_ptr<spi::Authentication> plugin_;
  SharedSecrets secrets_;  ///< identified by the host's handles
  RemoteIdentities remotes_;
  const CoreTimer core_timer_;
  HandshakeWatch watch_;
  LostSessions lost_sessions_;
  DisposeAnnouncements dispose_announcements_;
  OwnAnnouncements own_announcements_;
  /// The number of times that the permissions of local participants were renewed; for the timer's
  /// thread.
  std::map<spi::IdentityHandle, std::uint64_t> renewals_;
  /// The permissions that their handshakes present, if these were renewed; for the timer's thread.
  std::map<spi::IdentityHandle, Sha256Digest> presented_;
  /// The number of times that renewed permissions changed the rights of their endpoints, when the
  /// last change was noted, and the permissions that handshakes have presented since; for the
  /// timer's thread.
  struct RightsChanges {
    std::uint64_t count = 0;
    std::chrono::nanoseconds noted{};
    std::set<Sha256Digest> presented = {};
  };
  std::map<spi::IdentityHandle, RightsChanges> rights_changes_;
  /// The sessions that presented permissions with other rights, or the handshakes that present
  /// them, by remote and local participant, and when they were noted; for the timer's thread.
  std::map<std::pair<Guid, spi::IdentityHandle>, std::chrono::nanoseconds> endings_;
  /// A remote participant that has proven the end of its session, and what happened after that.
  struct EndedSession {
    std::chrono::nanoseconds at;
    bool is_dropped = false;                                  ///< the host has dropped it, too
    std::optional<std::chrono::nanoseconds> discovered = {};  ///< when the host discovered it again
  };
  std::map<Guid, EndedSession> ended_by_peer_;      ///< for the timer's thread
  const std::chrono::milliseconds patience_;        ///< until such a participant is reported
  const std::chrono::milliseconds kept_handshake_;  ///< see Pace
  /// Reports such a participant, if it is time. Returns true if there is nothing more to report.
  bool is_settled(const Guid& guid, EndedSession& end);
  ExpiryTimer timer_;  ///< last member: destroyed before the objects that it uses
};

}  // namespace ddssec::cyclonedds
