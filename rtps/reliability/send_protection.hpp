// What a message sender asks before something leaves: the seam to rtps/security.
#pragma once

#include "base/ids.hpp"
#include "base/result.hpp"

namespace ddssec::rtps {

/// Encodes what local endpoints send (DDS-Security 8.5.1.9.1 to 8.5.1.9.4). Writes to `out`, which
/// must have room for the plain octets and kProtectionRoom, and returns how many octets it wrote.
/// Allocates nothing. Whatever cannot be protected must not be sent.
class SendProtection {
 public:
  /// By what a whole message is protected.
  enum class Wrap : std::uint8_t { none, pre_shared_key, participant_key };
  struct Levels {
    bool payload = false;
    bool submessage = false;
    Wrap message = Wrap::none;
  };

  virtual ~SendProtection() = default;
  virtual Levels levels(const EntityId& sender) const = 0;
  /// `plain` in whole words.
  virtual Result<std::size_t> protect_payload(const EntityId& writer, BytesView plain,
                                              MutableBytes out) = 0;
  /// A receiver without a prefix or an entity stands for all that are matched.
  virtual Result<std::size_t> protect_submessage(const EntityId& sender, const Guid& receiver,
                                                 BytesView plain, MutableBytes out) = 0;
  /// `wrap` is not none.
  virtual Result<std::size_t> protect_message(Wrap wrap, const GuidPrefix& receiver,
                                              BytesView plain, MutableBytes out) = 0;
  /// Something was not sent because it could not be protected.
  virtual void on_unprotectable(const Error& error) = 0;
};

}  // namespace ddssec::rtps
