#include "pki/chain.hpp"

#include <algorithm>
#include <array>
#include <deque>
#include <map>
#include <mutex>
#include <set>

#include "pki/openssl.hpp"
#include "pki/pki_access.hpp"

namespace ddssec::pki {
namespace {

struct Refusal {
  int openssl;
  Code code;
};

constexpr std::array kRefusals = {
    Refusal{X509_V_ERR_CERT_HAS_EXPIRED, Code::certificate_expired},
    Refusal{X509_V_ERR_CERT_NOT_YET_VALID, Code::certificate_not_yet_valid},
    Refusal{X509_V_ERR_UNABLE_TO_GET_ISSUER_CERT, Code::issuer_unknown},
    Refusal{X509_V_ERR_UNABLE_TO_GET_ISSUER_CERT_LOCALLY, Code::issuer_unknown},
    Refusal{X509_V_ERR_UNABLE_TO_VERIFY_LEAF_SIGNATURE, Code::issuer_unknown},
    Refusal{X509_V_ERR_DEPTH_ZERO_SELF_SIGNED_CERT, Code::issuer_unknown},
    Refusal{X509_V_ERR_SELF_SIGNED_CERT_IN_CHAIN, Code::issuer_unknown},
    Refusal{X509_V_ERR_AKID_SKID_MISMATCH, Code::issuer_unknown},
    Refusal{X509_V_ERR_AKID_ISSUER_SERIAL_MISMATCH, Code::issuer_unknown},
    Refusal{X509_V_ERR_CERT_SIGNATURE_FAILURE, Code::certificate_signature_invalid},
    Refusal{X509_V_ERR_CERT_REVOKED, Code::certificate_revoked},
    Refusal{X509_V_ERR_UNABLE_TO_GET_CRL, Code::crl_missing},
    Refusal{X509_V_ERR_DIFFERENT_CRL_SCOPE, Code::crl_missing},
    Refusal{X509_V_ERR_CRL_HAS_EXPIRED, Code::crl_expired},
    Refusal{X509_V_ERR_CRL_NOT_YET_VALID, Code::crl_not_yet_valid},
    Refusal{X509_V_ERR_CRL_SIGNATURE_FAILURE, Code::crl_signature_invalid},
    Refusal{X509_V_ERR_UNABLE_TO_GET_CRL_ISSUER, Code::crl_signature_invalid},
    Refusal{X509_V_ERR_KEYUSAGE_NO_CRL_SIGN, Code::crl_signature_invalid},
    Refusal{X509_V_ERR_INVALID_CA, Code::not_a_ca},
    Refusal{X509_V_ERR_PATH_LENGTH_EXCEEDED, Code::path_too_long},
    Refusal{X509_V_ERR_KEYUSAGE_NO_CERTSIGN, Code::key_usage_forbids},
    Refusal{X509_V_ERR_CA_MD_TOO_WEAK, Code::digest_too_weak},
};

Code code_for(int openssl) {
  const auto row = std::ranges::find(kRefusals, openssl, &Refusal::openssl);
  return row != kRefusals.end() ? row->code : Code::chain_refused;
}

bool about_a_missing_or_old_crl(int error) {
  return error == X509_V_ERR_UNABLE_TO_GET_CRL || error == X509_V_ERR_DIFFERENT_CRL_SCOPE ||
         error == X509_V_ERR_CRL_HAS_EXPIRED || error == X509_V_ERR_CRL_NOT_YET_VALID;
}

// OpenSSL calls this for every error that it finds. The certificate is refused if it returns 0.
template <CrlPolicy policy>
int on_fault(int ok, X509_STORE_CTX* context) {
  if (ok == 1) return 1;
  const int error = X509_STORE_CTX_get_error(context);
  const bool tolerated =
      about_a_missing_or_old_crl(error) &&
      // CA certificates come from the configured file, and removing one from it revokes it. A list
      // of their issuer is therefore used if there is one, but not required.
      (policy == CrlPolicy::soft_fail ||
       (error == X509_V_ERR_UNABLE_TO_GET_CRL && X509_STORE_CTX_get_error_depth(context) > 0));
  if (!tolerated) return 0;
  X509_STORE_CTX_set_error(context, X509_V_OK);
  return 1;
}

// OpenSSL asks for the lists of a name, and uses one of them. If several CAs have that name, only
// lists that this certificate's issuer signed count. If the issuer signed none of them, all are
// returned: OpenSSL then picks one and refuses its signature.
STACK_OF(X509_CRL) * lists_of_issuer(const X509_STORE_CTX* context, const X509_NAME* name) {
  auto* lists = X509_STORE_CTX_get1_crls(context, name);
  const auto* chain = X509_STORE_CTX_get0_chain(context);
  if (lists == nullptr || sk_X509_CRL_num(lists) < 2 || sk_X509_num(chain) == 0) return lists;
  const int above = X509_STORE_CTX_get_error_depth(context) + 1;
  EVP_PKEY* key = X509_get0_pubkey(sk_X509_value(chain, std::min(above, sk_X509_num(chain) - 1)));
  const auto is_signed = [&](int i) {
    return X509_CRL_verify(sk_X509_CRL_value(lists, i), key) == 1;
  };
  std::vector<int> foreign;
  for (int i = sk_X509_CRL_num(lists) - 1; i >= 0; --i)
    if (!is_signed(i)) foreign.push_back(i);
  ERR_clear_error();
  if (static_cast<int>(foreign.size()) == sk_X509_CRL_num(lists)) return lists;
  for (const int i : foreign) X509_CRL_free(sk_X509_CRL_delete(lists, i));
  return lists;
}

// True if `issuer` signed the certificate. If several CAs have one name, for example while one is
// replaced by another, OpenSSL alone would take the first that the certificate's extensions do not
// exclude. The extensions need not name the issuer's key.
int is_issued_by(X509_STORE_CTX*, X509* certificate, X509* issuer) {
  const bool is_by = X509_check_issued(issuer, certificate) == X509_V_OK &&
                     X509_verify(certificate, X509_get0_pubkey(issuer)) == 1;
  if (!is_by) ERR_clear_error();
  return is_by ? 1 : 0;
}

bool share_a_name(const std::vector<Certificate>& anchors) {
  std::set<std::string_view> names;
  return !std::ranges::all_of(
      anchors, [&](const Certificate& ca) { return names.insert(ca.subject()).second; });
}

std::string subject_of(const X509* x509) {
  return x509 != nullptr ? name_rfc2253(X509_get_subject_name(x509)) : "";
}

// Explains a refusal if two CAs have one name, for example because a keystore was made twice.
// OpenSSL then finds no issuer, or one whose key does not match. Returns an empty text if no anchor
// has the issuer's name, or if the keys do not differ.
std::string same_name_other_key(const X509* x509, const std::vector<Certificate>& anchors) {
  const auto named = key_id_text(X509_get0_authority_key_id(const_cast<X509*>(x509)));
  const auto issuer = name_rfc2253(X509_get_issuer_name(x509));
  for (const auto& anchor : anchors) {
    if (anchor.subject() != issuer) continue;
    const auto held = key_id_text(X509_get0_subject_key_id(impl_of(anchor).x509.get()));
    if (named.empty() || held.empty() || named == held) continue;
    return "the CA of that name that is configured has another key: the certificate names the "
           "key " +
           named + ", configured is " + held + " (subject key identifiers)";
  }
  return {};
}

// Names the list that decided, such as "list 2 of CN=CA".
std::string list_words(X509_CRL* crl) {
  if (crl == nullptr) return {};
  const auto number = number_of(crl);
  return (number ? "list " + to_string(*number) : std::string("the list")) + " of " +
         name_rfc2253(X509_CRL_get_issuer(crl));
}

// Builds the error with the values that explain the refusal.
Error chain_error(X509_STORE_CTX* context, const std::vector<Certificate>& anchors, WallTime now) {
  const int error = X509_STORE_CTX_get_error(context);
  const X509* at = X509_STORE_CTX_get_current_cert(context);
  const Code code = code_for(error);
  ErrorDetails details{.field = subject_of(at)};
  const auto limit = [&](const ASN1_TIME* time) {
    const auto wall = to_wall_time(time);
    return wall ? ddssec::to_string(*wall) : std::string("unreadable");
  };
  if (at == nullptr) return Error(code, std::move(details));
  if (code == Code::certificate_expired) {
    details.expected = "not after " + limit(X509_get0_notAfter(at));
    details.found = ddssec::to_string(now);
  } else if (code == Code::certificate_not_yet_valid) {
    details.expected = "not before " + limit(X509_get0_notBefore(at));
    details.found = ddssec::to_string(now);
  } else if (code == Code::issuer_unknown) {
    details.found = "issuer " + name_rfc2253(X509_get_issuer_name(at));
    details.note = same_name_other_key(at, anchors);
  } else if (code == Code::certificate_revoked) {
    details.found = "serial number " + serial_text(X509_get0_serialNumber(at));
    details.note = list_words(X509_STORE_CTX_get0_current_crl(context));
  } else if (code == Code::crl_expired) {
    details.note = list_words(X509_STORE_CTX_get0_current_crl(context));
  } else {
    details.note = X509_verify_cert_error_string(error);
  }
  return Error(code, std::move(details));
}

// If there is a keyUsage extension, it must allow digitalSignature (RFC 5280 4.2.1.3). The S/MIME
// purpose check of peers demands the same.
Status check_key_usage(const Certificate& certificate) {
  const auto usage = X509_get_key_usage(impl_of(certificate).x509.get());
  if (usage == UINT32_MAX || (usage & KU_DIGITAL_SIGNATURE) != 0) return {};
  return fail(Code::key_usage_forbids, {.field = certificate.subject(),
                                        .expected = "keyUsage with digitalSignature",
                                        .found = "keyUsage without it"});
}

}  // namespace

struct ChainVerifier::Impl {
  std::vector<Certificate> anchors;
  std::vector<Crl> crls;
  StorePtr store;
  std::optional<WallTime> crls_from;   // the latest thisUpdate
  std::optional<WallTime> crls_until;  // the earliest nextUpdate

  std::mutex mutex;
  std::map<Sha256Digest, ValidChain> remembered;
  std::deque<Sha256Digest> order;  // the oldest comes first

  void drop_superseded();
  Status fill_store(CrlPolicy policy);
  bool is_listed(const Certificate& certificate) const;
  bool is_in_force(const Crl& crl, const X509* issuer, WallTime now) const;
  Status check_every_list(X509_STORE_CTX* context, WallTime now) const;
  Result<ValidChain> judge(const Certificate& certificate, WallTime now) const;
  Result<ValidChain> judge_path(const Certificate& certificate, WallTime now,
                                unsigned long flags) const;
  ValidChain prove(const Certificate& certificate, X509_STORE_CTX* context) const;
  std::optional<ValidChain> recall(const Certificate& certificate, WallTime now);
  void remember(const ValidChain& proof);
};

// Drops lists that a newer one supersedes. OpenSSL uses any list that is valid at the time. If an
// older list stayed beside the newest, it would count again after the newest has expired, and a
// certificate that was revoked meanwhile would be accepted. A list that the authority did not sign
// supersedes nothing, and neither does a list of another key with the same name.
void ChainVerifier::Impl::drop_superseded() {
  const auto is_genuine = [&](const Crl& crl) {
    return std::ranges::any_of(anchors, [&](const auto& ca) { return crl.is_signed_by(ca); });
  };
  const auto takes_place_of = [&](const Crl& crl, const Crl& former) {
    return !crl.is_copy_of(former) && crl.is_not_older_than(former) &&
           !former.is_not_older_than(crl) && is_genuine(crl) &&
           (have_common_signer(crl, former, anchors) || !is_genuine(former));
  };
  const auto all = crls;
  std::erase_if(crls, [&](const Crl& former) {
    return std::ranges::any_of(all, [&](const Crl& crl) { return takes_place_of(crl, former); });
  });
  ERR_clear_error();
}

Status ChainVerifier::Impl::fill_store(CrlPolicy policy) {
  store.reset(X509_STORE_new());
  if (!store) return openssl_error(Code::internal);
  for (const auto& anchor : anchors) {
    if (!anchor.can_be_anchor())
      return fail(Code::not_a_ca,
                  {.field = anchor.subject(), .expected = "basicConstraints CA:TRUE"});
    if (X509_STORE_add_cert(store.get(), impl_of(anchor).x509.get()) != 1)
      return openssl_error(Code::internal);
  }
  for (const auto& crl : crls) {
    if (X509_STORE_add_crl(store.get(), impl_of(crl).crl.get()) != 1)
      return openssl_error(Code::internal);
    crls_from = std::max(crls_from.value_or(crl.this_update()), crl.this_update());
    if (const auto next = crl.next_update())
      crls_until = std::min(crls_until.value_or(*next), *next);
  }
  X509_STORE_set_lookup_crls(store.get(), lists_of_issuer);
  // Set only if two anchors share a name, because is_issued_by verifies one more signature per
  // certificate.
  if (share_a_name(anchors)) X509_STORE_set_check_issued(store.get(), is_issued_by);
  X509_STORE_set_verify_cb(store.get(), policy == CrlPolicy::hard_fail
                                            ? on_fault<CrlPolicy::hard_fail>
                                            : on_fault<CrlPolicy::soft_fail>);
  return {};
}

// True if a list names the certificate by serial number and issuer name. `verify` checks the rest.
bool ChainVerifier::Impl::is_listed(const Certificate& certificate) const {
  return std::ranges::any_of(crls, [&](const Crl& crl) {
    X509_REVOKED* entry = nullptr;
    return X509_CRL_get0_by_cert(impl_of(crl).crl.get(), &entry, impl_of(certificate).x509.get()) !=
           0;
  });
}

// True if `issuer` signed the list and the list is valid at `now`. Every issuer of the path comes
// from the store and is therefore an anchor.
bool ChainVerifier::Impl::is_in_force(const Crl& crl, const X509* issuer, WallTime now) const {
  const bool is_of_this_time =
      crl.this_update() <= now && (!crl.next_update() || now < *crl.next_update());
  return is_of_this_time && std::ranges::any_of(anchors, [&](const Certificate& anchor) {
           return X509_cmp(impl_of(anchor).x509.get(), issuer) == 0 && crl.is_signed_by(anchor);
         });
}

// Refuses a certificate that any list in force revokes. OpenSSL uses only one list of each issuer,
// the one with the best scope and time, although another one may be equally genuine and in force.
Status ChainVerifier::Impl::check_every_list(X509_STORE_CTX* context, WallTime now) const {
  const auto* chain = X509_STORE_CTX_get0_chain(context);
  for (int i = 0; i < sk_X509_num(chain); ++i) {
    X509* const x509 = sk_X509_value(chain, i);
    const X509* const issuer = sk_X509_value(chain, std::min(i + 1, sk_X509_num(chain) - 1));
    for (const auto& crl : crls) {
      X509_REVOKED* entry = nullptr;
      auto* const list = impl_of(crl).crl.get();
      if (X509_CRL_get0_by_cert(list, &entry, x509) == 0 || !is_in_force(crl, issuer, now))
        continue;
      return fail(Code::certificate_revoked,
                  {.field = subject_of(x509),
                   .found = "serial number " + serial_text(X509_get0_serialNumber(x509)),
                   .note = list_words(list)});
    }
  }
  ERR_clear_error();
  return {};
}

ValidChain ChainVerifier::Impl::prove(const Certificate& certificate,
                                      X509_STORE_CTX* context) const {
  ValidChain proof(certificate);
  proof.not_before_ = certificate.not_before();
  proof.not_after_ = certificate.not_after();
  proof.first_to_expire_ = certificate.subject();
  proof.crl_next_update_ = crls_until;
  const auto* chain = X509_STORE_CTX_get0_chain(context);
  for (int i = 1; i < sk_X509_num(chain); ++i) {
    const X509* x509 = sk_X509_value(chain, i);
    const auto until = to_wall_time(X509_get0_notAfter(x509)).value_or(WallTime{});
    const auto from = to_wall_time(X509_get0_notBefore(x509)).value_or(WallTime::max());
    proof.not_before_ = std::max(proof.not_before_, from);
    if (until >= proof.not_after_) continue;
    proof.not_after_ = until;
    proof.first_to_expire_ = subject_of(x509);
  }
  return proof;
}

Result<ValidChain> ChainVerifier::Impl::judge_path(const Certificate& certificate, WallTime now,
                                                   unsigned long flags) const {
  const StoreContextPtr context(X509_STORE_CTX_new());
  if (!context || X509_STORE_CTX_init(context.get(), store.get(), impl_of(certificate).x509.get(),
                                      nullptr) != 1)
    return openssl_error(Code::internal);
  auto* parameters = X509_STORE_CTX_get0_param(context.get());
  // X509_V_FLAG_USE_DELTAS is not set, because Crl reads complete lists only.
  if (!crls.empty()) flags |= X509_V_FLAG_CRL_CHECK | X509_V_FLAG_CRL_CHECK_ALL;
  X509_VERIFY_PARAM_set_flags(parameters, flags);
  X509_VERIFY_PARAM_set_time(parameters, to_time_t(now));
  // Level 2 demands 112 bits: it refuses SHA-1 everywhere but in an anchor's signature on itself.
  X509_VERIFY_PARAM_set_auth_level(parameters, 2);
  if (X509_verify_cert(context.get()) != 1) {
    take_openssl_reason();
    return std::unexpected(chain_error(context.get(), anchors, now));
  }
  DDSSEC_RETURN_IF_ERROR(check_every_list(context.get(), now));
  return prove(certificate, context.get());
}

Result<ValidChain> ChainVerifier::Impl::judge(const Certificate& certificate, WallTime now) const {
  DDSSEC_RETURN_IF_ERROR(check_key_usage(certificate));
  // The first attempt verifies up to a root, so that an expired root in the file counts. Only if
  // the file has no root for the certificate may a subordinate CA end the path. (If the first
  // attempt had the flag, OpenSSL would stop at the subordinate CA even if its issuer were in the
  // file.)
  auto proof = judge_path(certificate, now, 0);
  if (proof || proof.error().code() != Code::issuer_unknown) return proof;
  return judge_path(certificate, now, X509_V_FLAG_PARTIAL_CHAIN);
}

std::optional<ValidChain> ChainVerifier::Impl::recall(const Certificate& certificate,
                                                      WallTime now) {
  const std::lock_guard lock(mutex);
  const auto known = remembered.find(certificate.fingerprint());
  if (known == remembered.end()) return std::nullopt;
  const auto& proof = known->second;
  const bool holds = now >= proof.not_before_ && now < proof.not_after_ &&
                     (!crls_from || now >= *crls_from) && (!crls_until || now < *crls_until);
  return holds ? std::optional(proof) : std::nullopt;
}

void ChainVerifier::Impl::remember(const ValidChain& proof) {
  const std::lock_guard lock(mutex);
  const auto& key = proof.certificate().fingerprint();
  if (!remembered.insert_or_assign(key, proof).second) return;
  order.push_back(key);
  if (order.size() <= kMaxRemembered) return;
  remembered.erase(order.front());
  order.pop_front();
}

ChainVerifier::ChainVerifier(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
ChainVerifier::~ChainVerifier() = default;
ChainVerifier::ChainVerifier(ChainVerifier&&) noexcept = default;
ChainVerifier& ChainVerifier::operator=(ChainVerifier&&) noexcept = default;

Result<ChainVerifier> ChainVerifier::make(std::vector<Certificate> anchors, std::vector<Crl> crls,
                                          CrlPolicy policy) {
  auto impl = std::make_unique<Impl>();
  impl->anchors = std::move(anchors);
  impl->crls = std::move(crls);
  impl->drop_superseded();
  DDSSEC_RETURN_IF_ERROR(impl->fill_store(policy));
  return ChainVerifier(std::move(impl));
}

Result<ValidChain> ChainVerifier::verify(const Certificate& certificate, WallTime now) const {
  if (auto known = impl_->recall(certificate, now)) return *std::move(known);
  DDSSEC_ASSIGN_OR_RETURN(auto proof, impl_->judge(certificate, now));
  impl_->remember(proof);
  return proof;
}

bool ChainVerifier::is_on_any_list(const Certificate& certificate) const {
  return impl_->is_listed(certificate) ||
         std::ranges::any_of(anchors(), [&](const auto& ca) { return impl_->is_listed(ca); });
}

const std::vector<Certificate>& ChainVerifier::anchors() const { return impl_->anchors; }

}  // namespace ddssec::pki
