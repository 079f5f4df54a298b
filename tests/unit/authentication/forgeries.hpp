// Changes of a message, each with the code that refuses it.
#pragma once

#include "tests/support/hostile_pki.hpp"
#include "tests/unit/authentication/authentication_fixture.hpp"

namespace ddssec::authentication::forgeries {

/// A change of a message by an attacker, and the code that refuses it.
struct Forgery {
  std::string name;
  Code code;
  std::function<Token(Token)> change;
};

inline Token renamed(Token token, std::string class_id) {
  token.class_id = std::move(class_id);
  return token;
}

inline Token doubled(Token token, std::string_view name) {
  token.binary_properties.push_back({std::string(name), field(token, name)});
  return token;
}

inline Forgery lacks(std::string name) {
  return {"Lacks_" + name, Code::token_field_missing,
          [name](Token t) { return without(std::move(t), name); }};
}

inline Forgery repeats(std::string name) {
  return {"Repeats_" + name, Code::token_field_repeated,
          [name](Token t) { return doubled(std::move(t), name); }};
}

inline Forgery resizes(std::string name, std::size_t size) {
  return {"Resizes_" + name + "_" + std::to_string(size), Code::token_field_length,
          [name, size](Token t) { return with(std::move(t), name, Bytes(size)); }};
}

inline Forgery flips(std::string name, Code code) {
  return {"Flips_" + name, code, [name](Token t) {
            auto octets = field(t, name);
            octets.back() ^= 1;
            return with(std::move(t), name, std::move(octets));
          }};
}

inline Forgery sets(std::string label, std::string name, Bytes value, Code code) {
  return {std::move(label), code,
          [name, value](Token t) { return with(std::move(t), name, value); }};
}

/// Returns the same change without the hashes. They are optional, so an attacker can leave them out
/// to hide a change from them.
inline Forgery unhashed(Forgery forgery) {
  forgery.name += "_unhashed";
  forgery.change = [change = forgery.change](Token t) {
    return without(without(change(std::move(t)), "hash_c1"), "hash_c2");
  };
  return forgery;
}

inline const Identity& stranger() {
  static const pki::Authority ca = make_ca("CN=Other CA");
  static const Identity identity = make_identity(ca, "CN=stranger");
  return identity;
}

inline Bytes stranger_pem() { return bytes(stranger().certificate.pem()); }

/// Returns a certificate of 40 KB, for which some patch levels of OpenSSL take many times as much
/// memory.
inline Bytes memory_bomb_pem() {
  return bytes(test::with_distribution_points({stranger().certificate, stranger().key},
                                              test::PointName::relative, 1500, 200));
}

inline std::vector<Forgery> of_credentials() {
  std::vector<Forgery> all;
  for (const auto* name : {"c.id", "c.pdata", "c.dsign_algo", "c.kagree_algo"}) {
    all.push_back(lacks(name));
    all.push_back(repeats(name));
    all.push_back(resizes(name, 0));
  }
  all.push_back(repeats("c.perm"));
  all.push_back(resizes("c.id", 64 * 1024 + 1));
  all.push_back(resizes("c.perm", 1024 * 1024 + 1));
  all.push_back(resizes("c.pdata", 64 * 1024 + 1));
  all.push_back(resizes("c.dsign_algo", 129));
  all.push_back(resizes("c.kagree_algo", 129));
  all.push_back(flips("c.dsign_algo", Code::signature_algorithm_unknown));
  all.push_back(flips("c.kagree_algo", Code::key_agreement_algorithm_unknown));
  all.push_back(flips("c.id", Code::token_field_differs));
  all.push_back(flips("c.perm", Code::token_field_differs));
  all.push_back(flips("c.pdata", Code::token_field_differs));
  all.push_back(
      unhashed(sets("GarbageCertificate", "c.id", bytes("garbage"), Code::certificate_malformed)));
  all.push_back(unhashed(sets("CertificateOfManyDistributionPoints", "c.id", memory_bomb_pem(),
                              Code::certificate_distribution_points)));
  all.push_back(unhashed(
      sets("StrangersCertificate", "c.id", stranger_pem(), Code::guid_not_bound_to_subject)));
  all.push_back(unhashed(
      sets("ShortList", "c.pdata", Bytes{0, 0x50, 0, 16}, Code::participant_data_malformed)));
  all.push_back(unhashed(
      sets("ListWithoutGuid", "c.pdata", Bytes{0, 1, 0, 0}, Code::participant_guid_missing)));
  all.push_back(unhashed(sets("AnothersData", "c.pdata", participant_data(candidate(99)),
                              Code::participant_guid_differs)));
  return all;
}

inline const auto kName = [](const auto& info) {
  std::string name = info.param.name;
  std::ranges::replace(name, '.', '_');
  return name;
};

}  // namespace ddssec::authentication::forgeries
