#include "tests/sim/insider.hpp"

#include "tests/sim/claims.hpp"
#include "wire/header.hpp"

namespace ddssec::rtps::sim {
namespace {

class Permissive final : public spi::AccessControl {
 public:
  Permissive(std::unique_ptr<spi::AccessControl> real, std::string borrowed)
      : real_(std::move(real)), borrowed_(std::move(borrowed)) {}

 private:
  using Permissions = spi::PermissionsHandle;
  using Request = spi::EndpointRequest;
  template <class T>
  using List = std::vector<T>;

  Result<Permissions> validate_local_permissions(spi::IdentityHandle identity, DomainId domain,
                                                 const spi::PropertyList& properties,
                                                 std::string_view tag) override {
    return real_->validate_local_permissions(identity, domain, properties, tag);
  }
  Result<Permissions> validate_remote_permissions(spi::IdentityHandle local,
                                                  spi::IdentityHandle remote,
                                                  const spi::Token& token,
                                                  const spi::Token& credential) override {
    return real_->validate_remote_permissions(local, remote, token, credential);
  }
  Status check_create_participant(Permissions, DomainId) override { return {}; }
  Status check_create_datawriter(Permissions, DomainId, const Request&) override { return {}; }
  Status check_create_datareader(Permissions, DomainId, const Request&) override { return {}; }
  Status check_create_topic(Permissions, DomainId, std::string_view) override { return {}; }
  Status check_remote_participant(Permissions, DomainId) override { return {}; }
  Status check_remote_datawriter(Permissions, DomainId, const Request&) override { return {}; }
  Result<RemoteDatareader> check_remote_datareader(Permissions, DomainId, const Request&) override {
    return RemoteDatareader{};
  }
  Status check_remote_match(Permissions, const Match&) override { return {}; }
  Status check_remote_topic(Permissions, DomainId, std::string_view) override { return {}; }
  Result<spi::Token> permissions_token(Permissions local) override {
    return real_->permissions_token(local);
  }
  Result<spi::Token> permissions_credential_token(Permissions local) override {
    auto out = real_->permissions_credential_token(local);
    if (out && !borrowed_.empty()) out->properties = {{"dds.perm.cert", borrowed_}};
    return out;
  }
  Result<spi::ParticipantSecurityAttributes> participant_sec_attributes(
      Permissions local) override {
    return real_->participant_sec_attributes(local);
  }
  Result<spi::TopicSecurityAttributes> topic_sec_attributes(Permissions local,
                                                            std::string_view topic) override {
    return real_->topic_sec_attributes(local, topic);
  }
  Result<spi::EndpointSecurityAttributes> datawriter_sec_attributes(
      Permissions local, const Request& request) override {
    return real_->datawriter_sec_attributes(local, request);
  }
  Result<spi::EndpointSecurityAttributes> datareader_sec_attributes(
      Permissions local, const Request& request) override {
    return real_->datareader_sec_attributes(local, request);
  }
  Result<spi::EndpointSecurityAttributes> unused_topic_attributes(Permissions local,
                                                                  std::string_view topic) override {
    return real_->unused_topic_attributes(local, topic);
  }
  void forget_topic(Permissions local, std::string_view topic) override {
    real_->forget_topic(local, topic);
  }
  Status return_permissions_handle(Permissions permissions) override {
    return real_->return_permissions_handle(permissions);
  }
  std::optional<WallTime> next_expiry() override { return {}; }
  List<Permissions> poll(Permissions) override { return {}; }

  std::unique_ptr<spi::AccessControl> real_;
  const std::string borrowed_;
};

class Tampering final : public testing::KeyThief, private spi::CryptoTransform {
 public:
  Tampering(std::unique_ptr<spi::Cryptography> real, Malice& malice)
      : KeyThief(std::move(real), malice.stolen), malice_(malice) {}
  spi::CryptoTransform& transform() override { return *this; }

 private:
  using Size = Result<std::size_t>;
  template <class Handle>
  using Handles = std::span<const Handle>;

  spi::CryptoTransform& real() { return KeyThief::transform(); }
  Bytes changed(BytesView plain) {
    auto out = to_bytes(plain);
    if (malice_.further.chance(malice_.claims))
      claim(out, [&](bool writes) { return malice_.endpoint(writes); });
    if (malice_.dice.chance(malice_.tampers)) mangle(out, malice_.dice, malice_.names);
    return out;
  }
  // Changes the content of a message under the same header, which says whose key it is: the content
  // is changed submessages, its own endpoints in another name, or others' submessages instead, if
  // there is room.
  Bytes exchanged(BytesView message) {
    auto content = changed(message.subspan(kHeaderSize));
    if (malice_.dice.chance(malice_.tampers) && !malice_.names.empty())
      sim::exchange(content, message.subspan(8, GuidPrefix::size),
                    malice_.dice.of(malice_.names).view());
    if (malice_.dice.chance(malice_.tampers / 2)) {
      auto others = malice_.submessages();
      if (others.size() <= content.size()) content = std::move(others);
    }
    auto out = to_bytes(message);
    out.resize(kHeaderSize);
    out.insert(out.end(), content.begin(), content.end());
    return out;
  }

  Size encode_serialized_payload(DataWriter sender, BytesView plain, MutableBytes out) override {
    return real().encode_serialized_payload(sender, changed(plain), out);
  }
  Size encode_datawriter_submessage(DataWriter sender, Handles<DataReader> receivers,
                                    BytesView plain, MutableBytes out) override {
    return real().encode_datawriter_submessage(sender, receivers, changed(plain), out);
  }
  Size encode_datareader_submessage(DataReader sender, Handles<DataWriter> receivers,
                                    BytesView plain, MutableBytes out) override {
    return real().encode_datareader_submessage(sender, receivers, changed(plain), out);
  }
  Size encode_rtps_message(Participant sender, Handles<Participant> receivers, BytesView plain,
                           MutableBytes out) override {
    return real().encode_rtps_message(sender, receivers, exchanged(plain), out);
  }
  Size decode_rtps_message(Participant receiver, Participant sender, BytesView encoded,
                           MutableBytes out) override {
    return real().decode_rtps_message(receiver, sender, encoded, out);
  }
  Result<spi::SecureSubmessage> preprocess_secure_submessage(Participant receiver,
                                                             Participant sender,
                                                             BytesView encoded) override {
    return real().preprocess_secure_submessage(receiver, sender, encoded);
  }
  Size decode_datawriter_submessage(DataReader receiver, DataWriter sender, BytesView encoded,
                                    MutableBytes out) override {
    return real().decode_datawriter_submessage(receiver, sender, encoded, out);
  }
  Size decode_datareader_submessage(DataWriter receiver, DataReader sender, BytesView encoded,
                                    MutableBytes out) override {
    return real().decode_datareader_submessage(receiver, sender, encoded, out);
  }
  Size decode_serialized_payload(DataReader receiver, DataWriter sender, BytesView encoded,
                                 MutableBytes out) override {
    return real().decode_serialized_payload(receiver, sender, encoded, out);
  }

  Malice& malice_;
};

class FalseName final : public testing::ForwardingAuthentication {
 public:
  FalseName(std::unique_ptr<spi::Authentication> real, const GuidPrefix& name)
      : ForwardingAuthentication(std::move(real)), name_(name) {}
  Result<LocalIdentity> validate_local_identity(DomainId domain,
                                                const spi::PropertyList& properties,
                                                const Guid& candidate) override {
    auto out = ForwardingAuthentication::validate_local_identity(domain, properties, candidate);
    if (out) out->adjusted_guid.prefix = name_;
    return out;
  }

 private:
  GuidPrefix name_;
};

}  // namespace

std::unique_ptr<spi::AccessControl> permissive(std::unique_ptr<spi::AccessControl> real,
                                               std::string borrowed) {
  return std::make_unique<Permissive>(std::move(real), std::move(borrowed));
}

std::unique_ptr<spi::Cryptography> tampering(std::unique_ptr<spi::Cryptography> real,
                                             Malice& malice) {
  return std::make_unique<Tampering>(std::move(real), malice);
}

std::unique_ptr<spi::Authentication> under_false_name(std::unique_ptr<spi::Authentication> real,
                                                      const GuidPrefix& name) {
  return std::make_unique<FalseName>(std::move(real), name);
}

}  // namespace ddssec::rtps::sim
