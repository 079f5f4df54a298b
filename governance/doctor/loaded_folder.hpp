// A participant's folder, loaded part by part, so that a broken part does not hide others.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "base/clock.hpp"
#include "base/result.hpp"
#include "governance/doctor/measured_outcomes.hpp"
#include "governance/model.hpp"
#include "pki/certificate.hpp"
#include "pki/crl.hpp"
#include "pki/participant_folder.hpp"
#include "pki/private_key.hpp"
#include "pki/smime.hpp"
#include "pki/smime_diagnosis.hpp"

namespace ddssec::governance::doctor {

/// A signed document of a folder. `Model` is Governance or Permissions.
template <class Model>
struct LoadedDocument {
  /// Success if the file can be read.
  Status readable = {};
  Bytes file = {};
  pki::DocumentForm form = {};
  /// Success for each product that accepts the signature; see verify_signature_as().
  Status cyclonedds_verdict = {};
  Status fastdds_verdict = {};
  Status our_verdict = {};
  /// The content of the document, even if its signature is wrong; null if it cannot be parsed.
  std::shared_ptr<const Model> model = {};
  /// The reason why ddssec does not parse it.
  Status parsed = {};
  /// The parts that were removed from the text so that it could be parsed, because stock products
  /// may skip them.
  std::vector<Variant> left_out = {};
  /// The reason why it does not parse without these parts either. Stock products have the same
  /// fault.
  Status parsed_without = {};
  /// True if a comment or CDATA in a value was removed too.
  bool has_joined_values = false;
  /// True if Cyclone DDS reads the text and Fast DDS does not; see LenientText.
  bool is_refused_by_fastdds = false;

  /// Returns the reason why no model could be read.
  const Error& unread() const { return parsed_without ? parsed.error() : parsed_without.error(); }
  /// Success if the product can parse it; its parser may be more lenient than ddssec's. Otherwise
  /// the error is ddssec's.
  Status read_by(Product product) const {
    return product != Product::ddssec && model ? Status() : parsed;
  }
};

/// The products to which files give the password of an encrypted key.
struct PasswordGiven {
  bool has_cyclonedds = false, has_fastdds = false, has_ddssec = false;

  bool is_given_to(Product product) const {
    return product == Product::cyclonedds ? has_cyclonedds
           : product == Product::fastdds  ? has_fastdds
                                          : has_ddssec;
  }
};

/// The loaded parts of a folder. Each Result is independent of the others.
struct LoadedFolder {
  pki::ParticipantFolder paths;
  Result<std::vector<pki::Certificate>> identity_cas;
  Result<pki::Certificate> certificate;
  Result<pki::PrivateKey> key;
  /// The products that are given the password of the encrypted key. Set if the caller of
  /// load_folder() has found it and it opened the key.
  std::optional<PasswordGiven> password = {};
  Result<std::vector<pki::Certificate>> permissions_cas;
  Bytes permissions_ca_file;  ///< the content of that file; empty if it cannot be read
  /// The revocation lists; empty if there is no such file.
  Result<std::vector<pki::Crl>> crls;
  /// The file of revocation lists as stock products read it, if ddssec refuses it because of a
  /// delta list; otherwise empty.
  std::vector<pki::Crl> crls_with_deltas = {};
  bool has_crl_file;
  /// True if the file contains one list in DER instead of PEM.
  bool is_crl_der = false;
  LoadedDocument<Governance> governance;
  LoadedDocument<Permissions> permissions;

  /// True if none of the files exists: a participant without security.
  bool is_empty() const;
  /// True if the product can read the file with revocation lists, or if there is none.
  bool has_usable_lists(Product judge) const {
    return crls || (judge != Product::ddssec && !crls_with_deltas.empty());
  }
  /// Returns the chain verifier with which this participant judges certificates. If its file has
  /// several revocation lists, stock products read the first one (measured). Errors: those of the
  /// needed parts, or of ChainVerifier::make.
  Result<pki::ChainVerifier> chain(Product judge = Product::ddssec) const;
};

/// Success if a product accepts the signed file with a permissions CA file, whose content is
/// `ca_file`. Cyclone DDS reads only the first certificate of that file. Stock products take keys
/// that ddssec refuses. Errors: the reason why `cas` cannot be read; those of
/// pki::verify_as_stock_products or DocumentVerifier::verify.
Status verify_signature_as(Product judge, BytesView file,
                           const Result<std::vector<pki::Certificate>>& cas, BytesView ca_file,
                           WallTime now);

/// Returns the number of octets of the certificate and the signed permissions, which a handshake
/// message holds.
std::size_t handshake_octets(const LoadedFolder& folder);

/// True for the error about a key on another 256-bit curve, such as secp256k1. Cyclone DDS checks
/// only the size of an EC key: 0.10.2 accepts it (measured).
bool is_key_of_another_curve(const Error& error);

/// Loads every part; documents are verified at `now`. Never fails.
LoadedFolder load_folder(const pki::ParticipantFolder& paths, WallTime now);

}  // namespace ddssec::governance::doctor
