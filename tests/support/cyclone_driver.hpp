// Drives any security plugin through Cyclone DDS's C ABI, without Cyclone DDS: ours, the stock ones
// and every mix of them. It calls in the order in which Cyclone's core does.
#pragma once

#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "plugins/cyclonedds/abi.hpp"

namespace ddssec::driver {

using Octets = std::vector<std::uint8_t>;
using cyclonedds::Exception;

/// The exception for a call that was refused; `code` is the plugin's.
struct Refused : std::runtime_error {
  Refused(const std::string& call, const Exception& ex);
  std::int32_t code;
};

/// A SecurityException that is freed at destruction. `check` turns a failure into Refused.
class Call {
 public:
  /// `name` must live as long as this object.
  explicit Call(const char* name) : name_(name) {}
  ~Call();
  Call(const Call&) = delete;
  Call& operator=(const Call&) = delete;
  operator Exception*() { return &ex_; }
  void check(bool ok) const {
    if (!ok) throw Refused(name_, ex_);
  }

 private:
  const char* name_;
  Exception ex_{};
};

/// One plugin library, loaded as Cyclone loads it, with a context of its own.
class Library {
 public:
  /// `init` and `finalize` are the names of the entry points. Throws std::runtime_error.
  Library(const std::string& path, const std::string& init, const std::string& finalize);
  ~Library();
  Library(const Library&) = delete;
  Library& operator=(const Library&) = delete;
  void* context() const { return context_; }

 private:
  using Init = int (*)(const char*, void**, ddsi_domaingv*);
  using Finalize = int (*)(void*);
  void* handle_;
  Finalize finalize_ = nullptr;
  void* context_ = nullptr;
};

/// The paths of the three libraries of a domain.
struct Paths {
  std::string authentication;
  std::string access_control;
  std::string cryptography;
};

/// The plugins of one domain. They are finalized in Cyclone's order.
class Domain {
 public:
  explicit Domain(const Paths& paths);
  ~Domain();
  dds_security_authentication& authentication();
  dds_security_access_control& access_control();
  dds_security_cryptography& cryptography();

 private:
  std::unique_ptr<Library> authentication_;
  std::unique_ptr<Library> access_control_;
  std::unique_ptr<Library> cryptography_;
};

/// A token of a plugin, freed as Cyclone's core frees it: block by block.
struct Token : DDS_Security_DataHolder {
  Token() : DDS_Security_DataHolder{} {}
  ~Token();
  Token(const Token&) = delete;
  Token& operator=(const Token&) = delete;
};

/// A result of a transformation, freed with free.
struct Block : DDS_Security_OctetSeq {
  Block() : DDS_Security_OctetSeq{} {}
  ~Block();
  Block(Block&& other) noexcept;
  Block(const Block&) = delete;
  Block& operator=(const Block&) = delete;
  Octets octets() const { return {_buffer, _buffer + _length}; }
};

DDS_Security_OctetSeq view(const Octets& octets);

/// The sending side, with three transformations of data; `Receiver` has their opposites. Both have
/// been matched and have each other's keys.
struct Sender {
  dds_security_cryptography* plugin;
  DDS_Security_ParticipantCryptoHandle participant;
  DDS_Security_DatawriterCryptoHandle writer;
  std::vector<DDS_Security_ParticipantCryptoHandle> remote_participants;
  std::vector<DDS_Security_DatareaderCryptoHandle> remote_readers;

  Block encode_payload(const Octets& plain) const;
  Block encode_submessage(const Octets& plain) const;
  Block encode_message(const Octets& plain) const;
};

struct Receiver {
  dds_security_cryptography* plugin;
  DDS_Security_ParticipantCryptoHandle participant;
  DDS_Security_DatareaderCryptoHandle reader;
  DDS_Security_ParticipantCryptoHandle remote_participant;
  DDS_Security_DatawriterCryptoHandle remote_writer;

  Block decode_payload(const DDS_Security_OctetSeq& encoded) const;
  /// Calls preprocess and decode, as for a received submessage.
  Block decode_submessage(const DDS_Security_OctetSeq& encoded) const;
  /// Decodes a message. The header's prefix must be in machine order (see to_machine_order).
  Block decode_message(const DDS_Security_OctetSeq& encoded) const;
};

/// Changes a received RTPS header as Cyclone does before it asks for decoding.
void to_machine_order(DDS_Security_OctetSeq& message);

/// A shared secret in the layout that the plugins share.
struct MadeUpSecret {
  explicit MadeUpSecret(std::uint8_t seed);
  DDS_Security_SharedSecretHandle handle() const;
  Octets secret;
  cyclonedds::SharedSecretLayout layout;
};

/// The protection of one sender and its receivers, which have made-up secrets. Only cryptography is
/// involved.
struct Keys {
  DDS_Security_ParticipantSecurityAttributes participant{};
  DDS_Security_EndpointSecurityAttributes endpoint{};
};
/// Returns the protection of these kinds. `message` and `submessage` are 0 for none, 1 for sign, 2
/// for encrypt, and 2 more with origin authentication; `payload` is 0 to 2.
Keys keys_of(int message, int submessage, int payload);

class CryptoLink {
 public:
  CryptoLink(dds_security_cryptography& sending, dds_security_cryptography& receiving,
             const Keys& keys, std::size_t receivers);
  CryptoLink(const CryptoLink&) = delete;
  CryptoLink& operator=(const CryptoLink&) = delete;
  /// Unregisters everything.
  ~CryptoLink();

 private:
  std::int64_t identity_;

 public:
  Sender sender;
  std::vector<Receiver> receivers;

 private:
  void match(std::size_t number, const Keys& keys);
  std::vector<std::unique_ptr<MadeUpSecret>> secrets_;
};

/// A participant with all three plugins: identity, permissions, keys.
class Participant {
 public:
  /// Takes the identity `name`.pem and the other files of the folder that make_pki.sh made, and
  /// governance_KIND.p7s. Participants of one name differ by `number`.
  Participant(Domain& domain, const std::string& pki, const std::string& name,
              const std::string& governance, std::uint8_t number = 0);
  ~Participant();
  Participant(const Participant&) = delete;
  Participant& operator=(const Participant&) = delete;

  Domain& domain;
  DDS_Security_GUID_t guid{};
  DDS_Security_IdentityHandle identity = 0;
  DDS_Security_PermissionsHandle permissions = 0;
  DDS_Security_ParticipantCryptoHandle crypto = 0;
  Token identity_token;
  Token permissions_token;
  DDS_Security_ParticipantSecurityAttributes attributes{};
  Octets data;  ///< ParticipantBuiltinTopicData as a big-endian parameter list
};

/// The handles that one participant has for the other after the handshake.
struct Peer {
  DDS_Security_IdentityHandle identity = 0;
  DDS_Security_HandshakeHandle handshake = 0;
  DDS_Security_SharedSecretHandle secret = 0;
  DDS_Security_PermissionsHandle permissions = 0;
  DDS_Security_ParticipantCryptoHandle crypto = 0;
};

/// Runs one handshake of two participants, from discovery to the OK of both sides. Throws Refused.
void authenticate(Participant& a, Participant& b, Peer& a_of_b, Peer& b_of_a);

/// Two participants with authentication, permissions, participant keys, one writer at `a` and one
/// reader at `b` on `topic`, and their keys. The constructor throws Refused.
class Link {
 public:
  Link(Participant& a, Participant& b, const std::string& topic);
  ~Link();
  Link(const Link&) = delete;
  Link& operator=(const Link&) = delete;
  Sender sender{};
  Receiver receiver{};
  DDS_Security_EndpointSecurityAttributes writer_attributes{};
  DDS_Security_EndpointSecurityAttributes reader_attributes{};
  Peer a_of_b, b_of_a;

 private:
  /// The constructor without links: after it, the destructor runs even if the other constructor
  /// throws.
  Link(Participant& a, Participant& b) : a_(a), b_(b) {}
  void judge(Participant& self, Participant& remote, Peer& peer);
  void exchange_participant_keys(Participant& from, Peer& to, Participant& at, Peer& remote);
  void add_endpoints(const std::string& topic);
  Participant& a_;
  Participant& b_;
};

}  // namespace ddssec::driver
