#include "tests/sim/cast.hpp"

#include "tests/sim/dice.hpp"
#include "tests/sim/repeatable_openssl.hpp"

namespace ddssec::rtps::sim {
namespace {

using testing::everything;
using testing::Rules;
constexpr auto kNone = ProtectionKind::none;
constexpr auto kSign = ProtectionKind::sign;
constexpr auto kEncrypt = ProtectionKind::encrypt;
constexpr auto kSignOa = ProtectionKind::sign_with_origin_authentication;
constexpr auto kEncryptOa = ProtectionKind::encrypt_with_origin_authentication;

constexpr Rules with(Rules rules, bool revises_keys, ProtectionKind pre_shared) {
  rules.revises_keys = revises_keys;
  rules.rtps_psk = pre_shared;
  return rules;
}

// The governance that `ddssec init` makes.
constexpr Rules kStrict{.rtps = kSign,
                        .discovery = kEncrypt,
                        .liveliness = kEncrypt,
                        .metadata = kEncrypt,
                        .data = kEncrypt};
constexpr Rules kTopicsOnly{
    .discovery = kEncrypt, .liveliness = kEncrypt, .metadata = kEncryptOa, .data = kNone};
constexpr Rules kDataOnly{.discovery = kEncrypt, .liveliness = kEncrypt, .data = kEncrypt};

constexpr std::array kProtections = {
    Protection{.name = "strict", .rules = kStrict, .covers_times = true},
    Protection{.name = "sign", .rules = everything(kSign), .hides = false, .covers_times = true},
    Protection{.name = "encrypt", .rules = everything(kEncrypt), .covers_times = true},
    Protection{.name = "sign-origin",
               .rules = everything(kSignOa),
               .hides = false,
               .covers_times = true,
               .tells_readers_from_writers = true},
    Protection{.name = "encrypt-origin",
               .rules = everything(kEncryptOa),
               .covers_times = true,
               .tells_readers_from_writers = true},
    Protection{.name = "topics", .rules = kTopicsOnly, .tells_readers_from_writers = true},
    Protection{.name = "messages",
               .rules = {.rtps = kEncrypt},
               .covers_times = true,
               .separates_topics = false,
               .dates_readers = false},
    Protection{.name = "messages-origin",
               .rules = {.rtps = kEncryptOa},
               .covers_times = true,
               .separates_topics = false,
               .dates_readers = false,
               .tells_readers_from_writers = true},
    Protection{.name = "data", .rules = kDataOnly, .covers_headers = false},
    Protection{.name = "revising", .rules = with(kStrict, true, kNone), .covers_times = true},
    Protection{.name = "pre-shared",
               .rules = with(kStrict, false, kEncrypt),
               .covers_times = true,
               .hides_strangers = true},
};

// The authorities of the domain, and others of the same names.
struct Trust {
  struct Authorities {
    pki::Authority identity_ca, permissions_ca;
  };
  Authorities real, fake;

  // Returns the authorities. They are made once, and before anything else of a run uses OpenSSL,
  // because they must not depend on the run.
  static const Trust& shared() {
    static const Trust trust = [] {
      make_openssl_repeatable(0);
      return Trust{made(1), made(2)};
    }();
    return trust;
  }

 private:
  static Authorities made(std::uint64_t seed) {
    SeededRandom random(seed);
    const auto one = [&](std::string_view name) {
      return pki::Authority::create(name, {}, pki::kYear, random).value();
    };
    return {one("CN=Identity CA,O=Example"), one("CN=Permissions CA,O=Example")};
  }
};

std::string both(const pki::Authority& one, const pki::Authority& other) {
  return testing::data_uri(one.certificate().pem() + other.certificate().pem());
}

governance::Criteria criteria(const std::vector<std::string>& topics) {
  governance::Criteria out;
  for (const auto& topic : topics) out.topics.push_back({topic, 0});
  return out;
}

governance::Permissions permissions_of(const Subject& subject, const std::string& name) {
  governance::GrantRule rule;
  rule.allow = true;
  rule.domains = testing::any_domain();
  if (!subject.publishes.empty()) rule.publish = {criteria(subject.publishes)};
  if (!subject.subscribes.empty()) rule.subscribe = {criteria(subject.subscribes)};
  governance::Grant grant;
  grant.name = "simulation";
  grant.subject_name = name;
  grant.validity = {pki::kNow - std::chrono::days(2), pki::kNow + std::chrono::days(2)};
  if (!rule.publish.empty() || !rule.subscribe.empty()) grant.rules = {rule};
  return {.grants = {grant}};
}

std::string signed_by(const pki::Authority& authority, const std::string& xml) {
  SeededRandom random(3);
  return testing::data_uri(
      as_text(authority.sign_document(as_bytes(xml), pki::kNow, random).value()));
}

// Hostile participants trust both authorities, so that only the honest side can refuse.
spi::PropertyList made_properties_of(const Subject& subject, const Protection& protection) {
  const auto& [real, fake] = Trust::shared();
  const auto name = "CN=" + subject.name + ",O=Example";
  const auto& identity_ca = subject.role == Role::foreign ? fake.identity_ca : real.identity_ca;
  const auto& permissions_ca =
      subject.role == Role::forger ? fake.permissions_ca : real.permissions_ca;
  const bool honest = subject.role == Role::honest || subject.role == Role::elsewhere;
  SeededRandom random(Dice(static_cast<std::uint64_t>(subject.role)).fork(subject.name).next());
  const auto leaf = identity_ca.issue(name, {}, pki::kYear, random).value();
  const auto key =
      leaf.key.to_pem()->expose([](BytesView pem) { return testing::data_uri(as_text(pem)); });
  const auto trusted = [&](const pki::Authority& one, const pki::Authority& other) {
    return honest ? testing::data_uri(one.certificate().pem()) : both(one, other);
  };
  namespace property = spi::property;
  spi::PropertyList out = {
      {std::string(property::kIdentityCa), trusted(real.identity_ca, fake.identity_ca), false},
      {std::string(property::kIdentityCertificate), testing::data_uri(leaf.certificate.pem()),
       false},
      {std::string(property::kPrivateKey), key, false},
      {std::string(property::kPermissionsCa), trusted(real.permissions_ca, fake.permissions_ca),
       false},
      {std::string(property::kGovernance),
       signed_by(real.permissions_ca, governance::to_xml(protection.rules.document())), false},
      {std::string(property::kPermissions),
       signed_by(permissions_ca, governance::to_xml(permissions_of(subject, name))), false}};
  if (protection.hides_strangers)
    out.push_back({std::string(property::kPskPassphrase),
                   testing::data_uri("5632:castle super radar denial"), false});
  return out;
}

}  // namespace

std::span<const Protection> protections() { return kProtections; }

spi::PropertyList properties_of(const Subject& subject, const Protection& protection) {
  static std::map<std::pair<std::string, std::string_view>, spi::PropertyList> made;
  const auto key =
      std::pair(subject.name + std::to_string(static_cast<int>(subject.role)), protection.name);
  const auto at = made.find(key);
  if (at != made.end()) return at->second;
  static_cast<void>(Trust::shared());
  make_openssl_repeatable(Dice(0).fork(key.first + std::string(key.second)).next());
  return made[key] = made_properties_of(subject, protection);
}

std::string honest_permissions(const Protection& protection) {
  const Subject alice{
      "alice", Role::honest, {kTopics.begin(), kTopics.end()}, {kTopics.begin(), kTopics.end()}};
  const auto properties = properties_of(alice, protection);
  return spi::find_property(properties, spi::property::kPermissions)
      ->substr(testing::data_uri("").size());
}

}  // namespace ddssec::rtps::sim
