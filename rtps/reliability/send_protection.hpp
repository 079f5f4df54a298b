// The protection that a message sender applies before it sends: the interface to rtps/security.
#pragma once

#include "base/ids.hpp"
#include "base/result.hpp"

namespace ddssec::rtps {

/// Encodes what local endpoints send (DDS-Security 1.2, clauses 9.5.1.10.1 to 9.5.1.10.4). Each
/// call writes to `out`, which must have room for the plain octets and spi::protection_overhead,
/// and returns the number of octets written. Allocates nothing. If a call fails, the data must not
/// be sent.
class SendProtection {
 public:
  /// The key that protects a whole message.
  enum class Wrap : std::uint8_t { none, pre_shared_key, participant_key };
  struct Levels {
    bool payload = false;
    bool submessage = false;
    Wrap message = Wrap::none;
    /// The largest number of octets that protect_message adds, for all receivers that there are
    /// now.
    std::size_t message_room = 0;
    bool receiver_macs = false;  ///< true if a submessage carries a MAC for each matched endpoint
  };

  virtual ~SendProtection() = default;
  virtual Levels levels(const EntityId& sender) const = 0;
  /// Protects a payload. The size of `plain` must be a multiple of 4 octets.
  virtual Result<std::size_t> protect_payload(const EntityId& writer, BytesView plain,
                                              MutableBytes out) = 0;
  /// Protects a submessage. A receiver without a prefix or an entity stands for all matched ones.
  virtual Result<std::size_t> protect_submessage(const EntityId& sender, const Guid& receiver,
                                                 BytesView plain, MutableBytes out) = 0;
  /// Protects a whole message. `wrap` must not be none.
  virtual Result<std::size_t> protect_message(Wrap wrap, const GuidPrefix& receiver,
                                              BytesView plain, MutableBytes out) = 0;
  /// Called if something was not sent because it could not be protected.
  virtual void on_unprotectable(const Error& error) = 0;
};

}  // namespace ddssec::rtps
