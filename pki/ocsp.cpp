#include "pki/ocsp.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include <openssl/ocsp.h>

#include "pki/openssl.hpp"
#include "pki/pki_access.hpp"

namespace ddssec::pki {
using ddssec::to_string;

namespace {

using ResponsePtr = std::unique_ptr<OCSP_RESPONSE, Deleter<OCSP_RESPONSE_free>>;
using BasicPtr = std::unique_ptr<OCSP_BASICRESP, Deleter<OCSP_BASICRESP_free>>;
using CertificateIdPtr = std::unique_ptr<OCSP_CERTID, Deleter<OCSP_CERTID_free>>;

// The signer of a response. `until` is the end of its certificate chain if it is not the CA itself.
struct Signer {
  Certificate certificate;
  std::optional<WallTime> until = {};
};

// One answer of a response, about the certificate in question.
struct Answer {
  int status;
  int reason;
  std::optional<WallTime> revoked_at;
  WallTime this_update;
  std::optional<WallTime> next_update;
};

std::unexpected<Error> malformed_error(std::string note) {
  return fail(Code::ocsp_malformed, {.note = std::move(note)});
}

Result<BasicPtr> parse(BytesView octets) {
  if (octets.size() > kMaxOcspOctets)
    return fail(Code::ocsp_too_large,
                {.expected = "at most " + std::to_string(kMaxOcspOctets) + " octets",
                 .found = std::to_string(octets.size()) + " octets"});
  const auto* position = octets.data();
  const ResponsePtr response(
      d2i_OCSP_RESPONSE(nullptr, &position, static_cast<long>(octets.size())));
  if (!response) return openssl_error(Code::ocsp_malformed);
  if (position != octets.data() + octets.size())
    return malformed_error("octets follow the response");
  if (const int status = OCSP_response_status(response.get());
      status != OCSP_RESPONSE_STATUS_SUCCESSFUL)
    return fail(Code::ocsp_not_successful, {.found = OCSP_response_status_str(status)});
  BasicPtr basic(OCSP_response_get1_basic(response.get()));
  if (!basic) return openssl_error(Code::ocsp_malformed);
  return basic;
}

// Refuses a response with too many answers or certificates, or with a critical extension, because
// ddssec understands none (RFC 6960 4.4).
Status check_extent(OCSP_BASICRESP* basic) {
  const int answers = OCSP_resp_count(basic);
  if (answers > kMaxOcspAnswers || sk_X509_num(OCSP_resp_get0_certs(basic)) > kMaxOcspCertificates)
    return fail(Code::ocsp_too_large,
                {.expected = "at most " + std::to_string(kMaxOcspAnswers) + " answers and " +
                             std::to_string(kMaxOcspCertificates) + " certificates",
                 .found = "more"});
  constexpr auto kCritical = "it has a critical extension, which is not understood here";
  if (OCSP_BASICRESP_get_ext_by_critical(basic, 1, -1) >= 0) return malformed_error(kCritical);
  for (int i = 0; i < answers; ++i)
    if (OCSP_SINGLERESP_get_ext_by_critical(OCSP_resp_get0(basic, i), 1, -1) >= 0)
      return malformed_error(kCritical);
  return {};
}

bool is_strong(int digest) {
  constexpr std::array kStrong = {NID_sha256, NID_sha384, NID_sha512};
  return std::ranges::find(kStrong, digest) != kStrong.end();
}

Status check_digest(const OCSP_BASICRESP* basic) {
  const ASN1_OBJECT* algorithm = nullptr;
  X509_ALGOR_get0(&algorithm, nullptr, nullptr, OCSP_resp_get0_tbs_sigalg(basic));
  const int signature = OBJ_obj2nid(algorithm);
  int digest = NID_undef;
  OBJ_find_sigid_algs(signature, &digest, nullptr);
  if (is_strong(digest)) return {};
  const char* name = signature == NID_undef ? nullptr : OBJ_nid2sn(signature);
  return fail(Code::ocsp_digest_too_weak,
              {.field = "signatureAlgorithm",
               .expected = "ECDSA or RSA (PKCS #1 v1.5) with SHA-256, SHA-384 or SHA-512",
               .found = name != nullptr ? name : "an unknown algorithm"});
}

// True if the answer is about the certificate. It names one by two hashes of its issuer and by its
// serial number (RFC 6960 4.1.1).
bool is_about(const OCSP_SINGLERESP* answer, const Certificate& certificate,
              const Certificate& ca) {
  const OCSP_CERTID* id = OCSP_SINGLERESP_get0_id(answer);
  ASN1_OBJECT* algorithm = nullptr;
  OCSP_id_get0_info(nullptr, &algorithm, nullptr, nullptr, const_cast<OCSP_CERTID*>(id));
  const int digest = OBJ_obj2nid(algorithm);
  if (digest != NID_sha1 && !is_strong(digest)) return false;
  const CertificateIdPtr wanted(OCSP_cert_to_id(
      EVP_get_digestbynid(digest), impl_of(certificate).x509.get(), impl_of(ca).x509.get()));
  return wanted && OCSP_id_cmp(wanted.get(), id) == 0;
}

Result<Answer> read(OCSP_SINGLERESP* single) {
  Answer out{};
  ASN1_GENERALIZEDTIME *revoked = nullptr, *this_update = nullptr, *next_update = nullptr;
  out.status = OCSP_single_get0_status(single, &out.reason, &revoked, &this_update, &next_update);
  const auto read_time = to_wall_time(this_update);
  if (!read_time) return fail(Code::ocsp_malformed, {.field = "thisUpdate"});
  out.this_update = *read_time;
  if (next_update != nullptr) {
    const auto next = to_wall_time(next_update);
    if (!next) return fail(Code::ocsp_malformed, {.field = "nextUpdate"});
    out.next_update = *next;
  }
  if (revoked != nullptr)
    if (const auto time = to_wall_time(revoked)) out.revoked_at = *time;
  return out;
}

}  // namespace

Result<OcspDates> ocsp_dates(BytesView response) {
  DDSSEC_ASSIGN_OR_RETURN(const auto basic, parse(response));
  DDSSEC_RETURN_IF_ERROR(check_extent(basic.get()));
  std::optional<OcspDates> out;
  for (int i = 0; i < OCSP_resp_count(basic.get()); ++i) {
    DDSSEC_ASSIGN_OR_RETURN(const auto answer, read(OCSP_resp_get0(basic.get(), i)));
    const auto until = answer.next_update.value_or(answer.this_update + kOcspLifeWithoutEnd);
    if (!out) out = OcspDates{answer.this_update, until};
    out = OcspDates{std::max(out->this_update, answer.this_update), std::min(out->until, until)};
  }
  if (!out) return malformed_error("it has no answer");
  return *out;
}

struct OcspJudge {
  const Certificate& certificate;
  const ChainVerifier& trust;
  WallTime now;
  BasicPtr basic = nullptr;

  Result<std::vector<Answer>> answers_with(const Certificate& ca) const;
  Result<Signer> signer(const Certificate& ca) const;
  bool names_as_signer(const Certificate& candidate) const;
  Result<Signer> delegate(const Certificate& candidate, const Certificate& ca) const;
  Status check_signature(const Signer& signer) const;
  Result<GoodOcspStatus> judge(const Answer& answer, const Signer& signer) const;
  Result<GoodOcspStatus> judge_all(const std::vector<Answer>& answers, const Signer& signer) const;
  Result<GoodOcspStatus> judge(BytesView response);
  Status revoked(const Answer& answer) const;
  std::string serial() const { return "serial number " + certificate.serial(); }
};

// Returns the answers about the certificate, if `ca` issued it.
Result<std::vector<Answer>> OcspJudge::answers_with(const Certificate& ca) const {
  std::vector<Answer> out;
  for (int i = 0; i < OCSP_resp_count(basic.get()); ++i) {
    auto* const single = OCSP_resp_get0(basic.get(), i);
    if (!is_about(single, certificate, ca)) continue;
    DDSSEC_ASSIGN_OR_RETURN(auto answer, read(single));
    out.push_back(std::move(answer));
  }
  return out;
}

// True if the response names `candidate` as its signer, by its name or by the SHA-1 of its key.
bool OcspJudge::names_as_signer(const Certificate& candidate) const {
  const ASN1_OCTET_STRING* key = nullptr;
  const X509_NAME* name = nullptr;
  auto* const x509 = impl_of(candidate).x509.get();
  if (OCSP_resp_get0_id(basic.get(), &key, &name) != 1) return false;
  if (name != nullptr) return X509_NAME_cmp(name, X509_get_subject_name(x509)) == 0;
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned size = 0;
  return key != nullptr && X509_pubkey_digest(x509, EVP_sha1(), digest.data(), &size) == 1 &&
         std::ranges::equal(BytesView(digest).first(size),
                            BytesView(ASN1_STRING_get0_data(key),
                                      static_cast<std::size_t>(ASN1_STRING_length(key))));
}

// Accepts a responder other than the CA if the CA itself has certified it (RFC 6960 4.2.2.2).
Result<Signer> OcspJudge::delegate(const Certificate& candidate, const Certificate& ca) const {
  auto* const x509 = impl_of(candidate).x509.get();
  const bool may_sign = (X509_get_extension_flags(x509) & EXFLAG_XKUSAGE) != 0 &&
                        (X509_get_extended_key_usage(x509) & XKU_OCSP_SIGN) != 0;
  if (!may_sign)
    return fail(Code::ocsp_signer_wrong, {.field = candidate.subject(),
                                          .expected = "extendedKeyUsage OCSPSigning",
                                          .found = "a certificate without it"});
  if (!candidate.is_issued_by(ca))
    return fail(Code::ocsp_signer_wrong, {.field = candidate.subject(),
                                          .expected = "a certificate of " + ca.subject(),
                                          .found = "issuer " + candidate.issuer()});
  const auto chain = trust.verify(candidate, now);
  if (!chain)
    return fail(Code::ocsp_signer_wrong,
                {.field = candidate.subject(), .note = chain.error().to_sentence()});
  return Signer{candidate, chain->not_after()};
}

Result<Signer> OcspJudge::signer(const Certificate& ca) const {
  if (names_as_signer(ca)) return Signer{ca};
  std::optional<Error> why;
  const auto* const sent = OCSP_resp_get0_certs(basic.get());
  for (int i = 0; i < sk_X509_num(sent); ++i) {
    unsigned char* octets = nullptr;
    const int size = i2d_X509(sk_X509_value(sent, i), &octets);
    const OpensslMemoryPtr owner(octets);
    if (size <= 0) return openssl_error(Code::ocsp_malformed);
    // Certificate::from_der limits the extensions, names and keys that OpenSSL then processes.
    const auto candidate = Certificate::from_der({octets, static_cast<std::size_t>(size)});
    if (!candidate || !names_as_signer(*candidate)) continue;
    auto found = delegate(*candidate, ca);
    if (found) return found;
    why = found.error();
  }
  if (why) return std::unexpected(*std::move(why));
  return fail(Code::ocsp_signer_wrong, {.expected = ca.subject() + ", or a responder of it",
                                        .found = "another signer, without its certificate"});
}

Status OcspJudge::check_signature(const Signer& signer) const {
  const CertificateStackPtr signers(sk_X509_new_null());
  auto* const x509 = impl_of(signer.certificate).x509.get();
  if (!signers || sk_X509_push(signers.get(), x509) == 0) return fail(Code::out_of_memory);
  // The signer was judged above, so OpenSSL is to look at no other certificate.
  if (OCSP_basic_verify(basic.get(), signers.get(), nullptr, OCSP_NOINTERN | OCSP_TRUSTOTHER) == 1)
    return {};
  return openssl_error(Code::ocsp_signature_invalid, {.field = signer.certificate.subject()});
}

Status OcspJudge::revoked(const Answer& answer) const {
  const char* reason =
      answer.reason == OCSP_REVOKED_STATUS_NOSTATUS ? nullptr : OCSP_crl_reason_str(answer.reason);
  return fail(
      Code::ocsp_revoked,
      {.field = certificate.subject(),
       .found = serial(),
       .note = (answer.revoked_at ? "since " + to_string(*answer.revoked_at) : std::string()) +
               (reason != nullptr ? (answer.revoked_at ? ", " : "") + std::string(reason) : "")});
}

Result<GoodOcspStatus> OcspJudge::judge(const Answer& answer, const Signer& signer) const {
  if (answer.status != V_OCSP_CERTSTATUS_GOOD)
    return fail(Code::ocsp_unknown, {.field = certificate.subject(), .found = serial()});
  const auto next = answer.next_update.value_or(answer.this_update + kOcspLifeWithoutEnd);
  if (next < answer.this_update) return malformed_error("nextUpdate is before thisUpdate");
  const GoodOcspStatus good(answer.this_update, std::min(next, signer.until.value_or(next)));
  if (good.holds_at(now)) return good;
  if (answer.this_update > now)
    return fail(Code::ocsp_not_yet_valid, {.field = "thisUpdate",
                                           .expected = "at most " + to_string(now + kOcspClockSkew),
                                           .found = to_string(answer.this_update)});
  return fail(Code::ocsp_expired,
              {.field = answer.next_update ? "nextUpdate" : "thisUpdate",
               .expected = answer.next_update ? "a time after " + to_string(now)
                                              : "a time within 24 hours before " + to_string(now),
               .found = to_string(answer.next_update.value_or(answer.this_update))});
}

// If there are several answers, each must be good: a certificate that one of them revokes is
// revoked.
Result<GoodOcspStatus> OcspJudge::judge_all(const std::vector<Answer>& answers,
                                            const Signer& signer) const {
  for (const auto& answer : answers)
    if (answer.status == V_OCSP_CERTSTATUS_REVOKED) DDSSEC_RETURN_IF_ERROR(revoked(answer));
  DDSSEC_ASSIGN_OR_RETURN(auto good, judge(answers.front(), signer));
  for (const auto& answer : answers) {
    DDSSEC_ASSIGN_OR_RETURN(const auto other, judge(answer, signer));
    good = {std::max(good.this_update(), other.this_update()),
            std::min(good.until(), other.until())};
  }
  return good;
}

// Compares hashes before it does public-key operations, which take longer.
Result<GoodOcspStatus> OcspJudge::judge(BytesView response) {
  DDSSEC_ASSIGN_OR_RETURN(basic, parse(response));
  DDSSEC_RETURN_IF_ERROR(check_extent(basic.get()));
  DDSSEC_RETURN_IF_ERROR(check_digest(basic.get()));
  for (const auto& ca : trust.anchors()) {
    if (ca.subject() != certificate.issuer()) continue;
    DDSSEC_ASSIGN_OR_RETURN(const auto answers, answers_with(ca));
    if (answers.empty() || !certificate.is_issued_by(ca)) continue;
    DDSSEC_ASSIGN_OR_RETURN(const auto by, signer(ca));
    DDSSEC_RETURN_IF_ERROR(check_signature(by));
    return judge_all(answers, by);
  }
  return fail(Code::ocsp_other_certificate,
              {.expected = serial() + " of " + certificate.issuer(),
               .found = "answers about others: " + std::to_string(OCSP_resp_count(basic.get()))});
}

Result<GoodOcspStatus> judge_ocsp(BytesView response, const Certificate& certificate,
                                  const ChainVerifier& trust, WallTime now) {
  auto out = OcspJudge{certificate, trust, now}.judge(response);
  take_openssl_reason();
  return out;
}

}  // namespace ddssec::pki
