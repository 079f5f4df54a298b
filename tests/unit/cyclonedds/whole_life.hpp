// The whole life of two participants through the C ABI. A test may let each call fail.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "tests/unit/cyclonedds/failing_calls.hpp"
#include "tests/unit/cyclonedds/life_side.hpp"

namespace ddssec::driver {

class Life {
 public:
  explicit Life(std::optional<Plan> plan) : attempt_(plan) {
    for (auto* side : {&a_, &b_}) create(*side);
    authenticate();
    judge(a_, b_);
    judge(b_, a_);
    check_endpoints();
    register_endpoints();
    exchange_keys();
    send();
    leave();
  }
  ~Life();
  Life(const Life&) = delete;
  Life& operator=(const Life&) = delete;
  long failed() const { return attempt_.failed(); }

 private:
  using Transform = std::function<bool(Block&, Exception*)>;

  /// Attempts a call that fills `out`. A refused call must leave it nil.
  void attempt_token(const std::string& name, Token& out, const Caller::Call& call) {
    attempt_(
        name,
        [&](Exception* ex) {
          const bool succeeded = call(ex);
          EXPECT_TRUE(succeeded || out.class_id == nullptr);
          return succeeded;
        },
        [&] { clear(out); });
  }
  /// The same for a call that begins a handshake.
  void attempt_step(const std::string& name, Side& side, Token& out, const Caller::Call& call) {
    attempt_(
        name,
        [&](Exception* ex) {
          const bool succeeded = call(ex);
          EXPECT_TRUE(succeeded || (out.class_id == nullptr && side.peer.handshake == 0));
          return succeeded;
        },
        [&] {
          clear(out);
          side.auth()->return_handshake_handle(side.auth(), side.peer.handshake, nullptr);
        });
  }
  /// Attempts a call that returns a handle. `give_back` returns the handle to the plugin.
  void attempt_handle(const std::string& name, std::int64_t& handle,
                      const std::function<std::int64_t(Exception*)>& call,
                      const std::function<void(std::int64_t)>& give_back) {
    attempt_(
        name, [&](Exception* ex) { return (handle = call(ex)) != 0; }, [&] { give_back(handle); });
  }
  /// Attempts a call that may be repeated.
  void attempt_check(const std::string& name, const Caller::Call& call) {
    attempt_(name, call, [] {});
  }
  void attempt_transport(const std::string& name, const Transform& encode,
                         const std::function<bool(const Block&, Block&, Exception*)>& decode);

  void create(Side& side);
  void meet(Side& self, Side& remote, Token& request, const Token* answer);
  void authenticate();
  void judge(Side& self, Side& remote);
  void check_endpoints();
  void register_endpoints();
  void exchange_keys();
  template <class Create, class Set>
  void carry(Side& from, Create create, std::int64_t local, std::int64_t remote, Side& to, Set set,
             std::int64_t local_there, std::int64_t remote_there);
  void send();
  void leave();

  Caller attempt_;
  Side a_{"a"}, b_{"b"};
};

inline void Life::create(Side& side) {
  auto* auth = side.auth();
  auto* access = side.access();
  const auto* qos = &side.properties.qos;
  DDS_Security_GUID_t candidate{};
  candidate.prefix[11] = static_cast<std::uint8_t>(side.name[0]);
  candidate.entityId = {{0, 0, 1}, 0xc1};
  attempt_(
      "validate_local_identity",
      [&](Exception* ex) {
        return auth->validate_local_identity(auth, &side.identity, &side.guid, 0, qos, &candidate,
                                             ex) == DDS_SECURITY_VALIDATION_OK;
      },
      [&] { auth->return_identity_handle(auth, side.identity, nullptr); });
  attempt_token("get_identity_token", side.identity_token, [&](Exception* ex) {
    return auth->get_identity_token(auth, &side.identity_token, side.identity, ex);
  });
  attempt_handle(
      "validate_local_permissions", side.permissions,
      [&](Exception* ex) {
        // Without authentication, the identity is not given up after a refusal.
        return access->validate_local_permissions(access, nullptr, side.identity, 0, qos, ex);
      },
      [&](auto handle) { access->return_permissions_handle(access, handle, nullptr); });
  attempt_check("check_create_participant", [&](Exception* ex) {
    return access->check_create_participant(access, side.permissions, 0, qos, ex);
  });
  Token credential;
  attempt_token("get_permissions_credential_token", credential, [&](Exception* ex) {
    return access->get_permissions_credential_token(access, &credential, side.permissions, ex);
  });
  attempt_token("get_permissions_token", side.permissions_token, [&](Exception* ex) {
    return access->get_permissions_token(access, &side.permissions_token, side.permissions, ex);
  });
  attempt_check("set_permissions_credential_and_token", [&](Exception* ex) {
    return auth->set_permissions_credential_and_token(auth, side.identity, &credential,
                                                      &side.permissions_token, ex);
  });
  attempt_check("get_participant_sec_attributes", [&](Exception* ex) {
    return access->get_participant_sec_attributes(access, side.permissions, &side.attributes, ex);
  });
  attempt_handle(
      "register_local_participant", side.crypto,
      [&](Exception* ex) {
        return side.factory()->register_local_participant(
            side.factory(), side.identity, side.permissions, nullptr, &side.attributes, ex);
      },
      [&](auto handle) {
        side.factory()->unregister_participant(side.factory(), handle, nullptr);
      });

  // PID_PARTICIPANT_GUID and PID_SENTINEL, big endian.
  side.data = {0x00, 0x50, 0x00, 0x10};
  side.data.insert(side.data.end(), side.guid.prefix, side.guid.prefix + 12);
  for (const std::uint8_t octet : {0x00, 0x00, 0x01, 0xc1, 0x00, 0x01, 0x00, 0x00})
    side.data.push_back(octet);
}

inline void Life::meet(Side& self, Side& remote, Token& request, const Token* answer) {
  auto* auth = self.auth();
  attempt_(
      "validate_remote_identity",
      [&](Exception* ex) {
        clear(request);
        self.role =
            auth->validate_remote_identity(auth, &self.peer.identity, &request, answer,
                                           self.identity, &remote.identity_token, &remote.guid, ex);
        return self.role != DDS_SECURITY_VALIDATION_FAILED;
      },
      [&] { auth->return_identity_handle(auth, self.peer.identity, nullptr); });
}

inline void Life::authenticate() {
  Token request_of_a, request_of_b, request, reply, final_message, nothing;
  meet(a_, b_, request_of_a, nullptr);
  meet(b_, a_, request_of_b, &request_of_a);
  const bool a_begins = a_.role == DDS_SECURITY_VALIDATION_PENDING_HANDSHAKE_REQUEST;
  Side& first = a_begins ? a_ : b_;
  Side& second = a_begins ? b_ : a_;
  auto* begins = first.auth();
  auto* answers = second.auth();
  const auto data_of_first = view(first.data), data_of_second = view(second.data);
  constexpr auto kWait = DDS_SECURITY_VALIDATION_PENDING_HANDSHAKE_MESSAGE;
  attempt_step("begin_handshake_request", first, request, [&](Exception* ex) {
    return begins->begin_handshake_request(begins, &first.peer.handshake, &request, first.identity,
                                           first.peer.identity, &data_of_first, ex) == kWait;
  });
  attempt_step("begin_handshake_reply", second, reply, [&](Exception* ex) {
    return answers->begin_handshake_reply(answers, &second.peer.handshake, &reply, &request,
                                          second.peer.identity, second.identity, &data_of_second,
                                          ex) == kWait;
  });
  attempt_token("process_handshake, reply", final_message, [&](Exception* ex) {
    return begins->process_handshake(begins, &final_message, &reply, first.peer.handshake, ex) ==
           DDS_SECURITY_VALIDATION_OK_FINAL_MESSAGE;
  });
  attempt_token("process_handshake, final", nothing, [&](Exception* ex) {
    return answers->process_handshake(answers, &nothing, &final_message, second.peer.handshake,
                                      ex) == DDS_SECURITY_VALIDATION_OK;
  });
}

inline void Life::judge(Side& self, Side& remote) {
  auto* auth = self.auth();
  auto* access = self.access();
  auto& peer = self.peer;
  attempt_handle(
      "get_shared_secret", peer.secret,
      [&](Exception* ex) { return auth->get_shared_secret(auth, peer.handshake, ex); },
      [](auto) {});
  Token credential;
  attempt_token("get_authenticated_peer_credential_token", credential, [&](Exception* ex) {
    return auth->get_authenticated_peer_credential_token(auth, &credential, peer.handshake, ex);
  });
  attempt_handle(
      "validate_remote_permissions", peer.permissions,
      [&](Exception* ex) {
        return access->validate_remote_permissions(access, auth, self.identity, peer.identity,
                                                   &remote.permissions_token, &credential, ex);
      },
      [&](auto handle) { access->return_permissions_handle(access, handle, nullptr); });
  const DDS_Security_ParticipantBuiltinTopicDataSecure announced{};
  attempt_check("check_remote_participant", [&](Exception* ex) {
    return access->check_remote_participant(access, peer.permissions, 0, &announced, ex);
  });
  auto* factory = self.factory();
  attempt_handle(
      "register_matched_remote_participant", peer.crypto,
      [&](Exception* ex) {
        return factory->register_matched_remote_participant(factory, self.crypto, peer.identity,
                                                            peer.permissions, peer.secret, ex);
      },
      [&](auto handle) { factory->unregister_participant(factory, handle, nullptr); });
}

/// Checks a writer at a and a reader at b.
inline void Life::check_endpoints() {
  std::string topic = "Square", partition_name = "part", tag = "tag";
  char* partitions[] = {partition_name.data()};
  const DDS_Security_PartitionQosPolicy partition{{1, 1, partitions}};
  DDS_Security_Tag tag_of{tag.data(), tag.data()};
  const DDS_Security_DataTags tags{{1, 1, &tag_of}};
  const DDS_Security_DataTags no_tags{};
  const DDS_Security_Qos qos{};
  DDS_Security_PublicationBuiltinTopicDataSecure publication{};
  DDS_Security_SubscriptionBuiltinTopicDataSecure subscription{};
  publication.topic_name = subscription.topic_name = topic.data();
  publication.partition = subscription.partition = partition;
  DDS_Security_TopicBuiltinTopicData topic_data{};
  topic_data.name = topic.data();
  for (auto* side : {&a_, &b_}) {
    auto* access = side->access();
    const auto local = side->permissions, remote = side->peer.permissions;
    attempt_check("check_create_topic", [&](Exception* ex) {
      return access->check_create_topic(access, local, 0, topic.c_str(), &qos, ex);
    });
    attempt_check("check_create_datawriter", [&](Exception* ex) {
      return access->check_create_datawriter(access, local, 0, topic.c_str(), &qos, &partition,
                                             &no_tags, ex);
    });
    attempt_check("check_create_datareader", [&](Exception* ex) {
      return access->check_create_datareader(access, local, 0, topic.c_str(), &qos, &partition,
                                             &no_tags, ex);
    });
    attempt_check("get_datawriter_sec_attributes", [&](Exception* ex) {
      return access->get_datawriter_sec_attributes(access, local, topic.c_str(), &partition, &tags,
                                                   &side->endpoint_attributes, ex);
    });
    access->return_datawriter_sec_attributes(access, &side->endpoint_attributes, nullptr);
    attempt_check("get_datareader_sec_attributes", [&](Exception* ex) {
      return access->get_datareader_sec_attributes(access, local, topic.c_str(), &partition, &tags,
                                                   &side->endpoint_attributes, ex);
    });
    attempt_check("check_remote_topic", [&](Exception* ex) {
      return access->check_remote_topic(access, remote, 0, &topic_data, ex);
    });
    attempt_check("check_remote_datawriter", [&](Exception* ex) {
      return access->check_remote_datawriter(access, remote, 0, &publication, ex);
    });
    DDS_Security_boolean is_relay_only = 1;
    attempt_check("check_remote_datareader", [&](Exception* ex) {
      return access->check_remote_datareader(access, remote, 0, &subscription, &is_relay_only, ex);
    });
  }
}

inline void Life::register_endpoints() {
  auto* ours = a_.factory();
  auto* theirs = b_.factory();
  std::string name = "n", value = "v";
  DDS_Security_Property_t property{name.data(), value.data(), 0};
  const DDS_Security_PropertySeq properties{1, 1, &property};
  const auto drop_writer = [](auto* factory) {
    return [=](auto handle) { factory->unregister_datawriter(factory, handle, nullptr); };
  };
  const auto drop_reader = [](auto* factory) {
    return [=](auto handle) { factory->unregister_datareader(factory, handle, nullptr); };
  };
  attempt_handle(
      "register_local_datawriter", a_.endpoint,
      [&](Exception* ex) {
        return ours->register_local_datawriter(ours, a_.crypto, &properties,
                                               &a_.endpoint_attributes, ex);
      },
      drop_writer(ours));
  attempt_handle(
      "register_local_datareader", b_.endpoint,
      [&](Exception* ex) {
        return theirs->register_local_datareader(theirs, b_.crypto, &properties,
                                                 &b_.endpoint_attributes, ex);
      },
      drop_reader(theirs));
  attempt_handle(
      "register_matched_remote_datareader", a_.remote_endpoint,
      [&](Exception* ex) {
        return ours->register_matched_remote_datareader(ours, a_.endpoint, a_.peer.crypto,
                                                        a_.peer.secret, 0, ex);
      },
      drop_reader(ours));
  attempt_handle(
      "register_matched_remote_datawriter", b_.remote_endpoint,
      [&](Exception* ex) {
        return theirs->register_matched_remote_datawriter(theirs, b_.endpoint, b_.peer.crypto,
                                                          b_.peer.secret, ex);
      },
      drop_writer(theirs));
}

template <class Create, class Set>
inline void Life::carry(Side& from, Create create, std::int64_t local, std::int64_t remote,
                        Side& to, Set set, std::int64_t local_there, std::int64_t remote_there) {
  auto* maker = from.exchange();
  auto* taker = to.exchange();
  DDS_Security_CryptoTokenSeq tokens{};
  const auto give_back = [&] { maker->return_crypto_tokens(maker, &tokens, nullptr); };
  attempt_(
      "create crypto tokens",
      [&](Exception* ex) {
        const bool succeeded = (maker->*create)(maker, &tokens, local, remote, ex);
        EXPECT_EQ(succeeded, tokens._buffer != nullptr);
        return succeeded;
      },
      give_back);
  attempt_check("set crypto tokens", [&](Exception* ex) {
    return (taker->*set)(taker, local_there, remote_there, &tokens, ex);
  });
  give_back();
}

inline void Life::exchange_keys() {
  using Exchange = dds_security_crypto_key_exchange;
  carry(a_, &Exchange::create_local_participant_crypto_tokens, a_.crypto, a_.peer.crypto, b_,
        &Exchange::set_remote_participant_crypto_tokens, b_.crypto, b_.peer.crypto);
  carry(b_, &Exchange::create_local_participant_crypto_tokens, b_.crypto, b_.peer.crypto, a_,
        &Exchange::set_remote_participant_crypto_tokens, a_.crypto, a_.peer.crypto);
  carry(a_, &Exchange::create_local_datawriter_crypto_tokens, a_.endpoint, a_.remote_endpoint, b_,
        &Exchange::set_remote_datawriter_crypto_tokens, b_.endpoint, b_.remote_endpoint);
  carry(b_, &Exchange::create_local_datareader_crypto_tokens, b_.endpoint, b_.remote_endpoint, a_,
        &Exchange::set_remote_datareader_crypto_tokens, a_.endpoint, a_.remote_endpoint);
}

/// Attempts `encode(out, ex)`, and then `decode(in, out, ex)`. A refused call leaves no block.
void Life::attempt_transport(const std::string& name, const Transform& encode,
                             const std::function<bool(const Block&, Block&, Exception*)>& decode) {
  const auto attempt_block = [&](const std::string& what, Block& out, const Caller::Call& call) {
    attempt_(
        what,
        [&](Exception* ex) {
          const bool succeeded = call(ex);
          EXPECT_EQ(succeeded, out._buffer != nullptr);
          return succeeded;
        },
        [&] { Block(std::move(out)); });
  };
  Block encoded, decoded;
  attempt_block("encode " + name, encoded, [&](Exception* ex) { return encode(encoded, ex); });
  attempt_block("decode " + name, decoded,
                [&](Exception* ex) { return decode(encoded, decoded, ex); });
}

inline void Life::send() {
  auto* ours = a_.transform();
  auto* theirs = b_.transform();
  // DATA of an application's writer, without payload.
  const Octets plain_octets = {0x15, 0x01, 0x14, 0x00, 0, 0, 16, 0, 0, 0, 0, 0,
                               0,    0,    1,    3,    0, 0, 0,  0, 1, 0, 0, 0};
  Octets message_octets = {'R', 'T', 'P', 'S', 2, 1, 1, 0x10};
  message_octets.insert(message_octets.end(), a_.guid.prefix, a_.guid.prefix + 12);
  message_octets.insert(message_octets.end(), plain_octets.begin(), plain_octets.end());
  const auto plain = view(plain_octets), message = view(message_octets);
  const DDS_Security_OctetSeq none{};
  DDS_Security_LongLongSeq readers{1, 1, &a_.remote_endpoint};
  DDS_Security_LongLongSeq participants{1, 1, &a_.peer.crypto};
  attempt_transport(
      "payload",
      [&](Block& out, Exception* ex) {
        return ours->encode_serialized_payload(ours, &out, nullptr, &plain, a_.endpoint, ex);
      },
      [&](const Block& in, Block& out, Exception* ex) {
        return theirs->decode_serialized_payload(theirs, &out, &in, &none, b_.endpoint,
                                                 b_.remote_endpoint, ex);
      });
  attempt_transport(
      "submessage",
      [&](Block& out, Exception* ex) {
        DDS_Security_long index = 0;
        return ours->encode_datawriter_submessage(ours, &out, &plain, a_.endpoint, &readers, &index,
                                                  ex);
      },
      [&](const Block& in, Block& out, Exception* ex) {
        return theirs->decode_datawriter_submessage(theirs, &out, &in, b_.endpoint,
                                                    b_.remote_endpoint, ex);
      });
  attempt_transport(
      "message",
      [&](Block& out, Exception* ex) {
        DDS_Security_long index = 0;
        const bool encoded =
            ours->encode_rtps_message(ours, &out, &message, a_.crypto, &participants, &index, ex);
        if (encoded) to_machine_order(out);
        return encoded;
      },
      [&](const Block& in, Block& out, Exception* ex) {
        return theirs->decode_rtps_message(theirs, &out, &in, b_.crypto, b_.peer.crypto, ex);
      });
}

/// At a, the entities are unregistered one after the other. At b, each takes with it what depends
/// on it.
inline void Life::leave() {
  using Factory = dds_security_crypto_key_factory;
  const auto attempt_unregister = [&](Side& side, auto unregister, std::int64_t handle) {
    auto* factory = side.factory();
    attempt_check("unregister",
                  [=](Exception* ex) { return (factory->*unregister)(factory, handle, ex); });
  };
  attempt_unregister(a_, &Factory::unregister_datareader, a_.remote_endpoint);
  attempt_unregister(a_, &Factory::unregister_datawriter, a_.endpoint);
  attempt_unregister(a_, &Factory::unregister_participant, a_.peer.crypto);
  attempt_unregister(a_, &Factory::unregister_participant, a_.crypto);
  attempt_unregister(b_, &Factory::unregister_datareader, b_.endpoint);
  attempt_unregister(b_, &Factory::unregister_participant, b_.crypto);
  attempt_unregister(b_, &Factory::unregister_participant, b_.peer.crypto);
}

Life::~Life() {
  for (auto* side : {&a_, &b_}) {
    auto* access = side->access();
    access->return_permissions_handle(access, side->peer.permissions, nullptr);
    access->return_permissions_handle(access, side->permissions, nullptr);
    access->return_datareader_sec_attributes(access, &side->endpoint_attributes, nullptr);
    auto* auth = side->auth();
    auth->return_identity_handle(auth, side->peer.identity, nullptr);
    auth->return_identity_handle(auth, side->identity, nullptr);
  }
}

}  // namespace ddssec::driver
