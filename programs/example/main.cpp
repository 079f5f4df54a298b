// ddssec-example: creates a complete example set from a folder of documents. It creates certificate
// authorities and an identity for each NAME.permissions.xml, and signs every governance*.xml and
// permissions document. The keys are for tests only: they are stored unencrypted next to their
// certificates. The `ddssec` command creates real ones.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <optional>
#include <string>
#include <unistd.h>

#include "base/clock.hpp"
#include "pki/authority.hpp"

namespace {

using namespace ddssec;
namespace fs = std::filesystem;

constexpr std::string_view kPermissionsSuffix = ".permissions.xml";

struct Options {
  fs::path documents;
  fs::path out;
  bool one_ca = false;
  std::string rogue;
  int days = 3650;
};

struct Authorities {
  pki::Authority identity;
  // If it is empty, the identity CA also signs documents.
  std::optional<pki::Authority> own_permissions;
  const pki::Authority& permissions() const {
    return own_permissions ? *own_permissions : identity;
  }
};

// Creates the file so that only its owner can ever read it.
Status write_file(const fs::path& path, BytesView octets) {
  std::error_code ignored;
  fs::create_directories(path.parent_path(), ignored);
  fs::remove(path, ignored);
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL, 0600);
  const bool written = file >= 0 && ::write(file, octets.data(), octets.size()) ==
                                        static_cast<ssize_t>(octets.size());
  if (file >= 0) ::close(file);
  if (!written) return fail(Code::file_unwritable, {.document = path});
  return {};
}

Result<Bytes> read_file(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) return fail(Code::file_unreadable, {.document = path});
  return Bytes{std::istreambuf_iterator<char>(in), {}};
}

class ExampleSet {
 public:
  explicit ExampleSet(const Options& options)
      : options_(options),
        validity_{clock_.calendar_seconds() - std::chrono::hours(24),
                  clock_.calendar_seconds() + std::chrono::days(options.days)} {}

  Status make() {
    DDSSEC_ASSIGN_OR_RETURN(const auto authorities, make_authorities());
    for (const auto& entry : fs::directory_iterator(options_.documents)) {
      const std::string name = entry.path().filename();
      if (name.ends_with(kPermissionsSuffix)) {
        DDSSEC_RETURN_IF_ERROR(make_participant(
            authorities, entry.path(), name.substr(0, name.size() - kPermissionsSuffix.size())));
      } else if (name.starts_with("governance") && name.ends_with(".xml")) {
        DDSSEC_RETURN_IF_ERROR(
            sign({authorities.permissions().certificate(), authorities.permissions().key()},
                 entry.path(), options_.out / entry.path().filename().replace_extension(".p7s")));
      }
    }
    return {};
  }

 private:
  Result<Authorities> make_authorities() {
    DDSSEC_ASSIGN_OR_RETURN(auto identity, make_authority("identity_ca"));
    std::optional<pki::Authority> permissions;
    if (!options_.one_ca) {
      DDSSEC_ASSIGN_OR_RETURN(permissions, make_authority("permissions_ca"));
    }
    Authorities authorities{std::move(identity), std::move(permissions)};
    DDSSEC_RETURN_IF_ERROR(write_file(options_.out / "permissions_ca.pem",
                                      as_bytes(authorities.permissions().certificate().pem())));
    return authorities;
  }

  Result<pki::Authority> make_authority(const std::string& name) {
    DDSSEC_ASSIGN_OR_RETURN(
        auto authority,
        pki::Authority::create("CN=" + name + ",O=ddssec example", {}, validity_, random_));
    DDSSEC_RETURN_IF_ERROR(
        write_credential(options_.out / name, authority.certificate(), authority.key()));
    return authority;
  }

  Status make_participant(const Authorities& authorities, const fs::path& permissions,
                          const std::string& name) {
    DDSSEC_ASSIGN_OR_RETURN(
        const pki::Credential self,
        authorities.identity.issue("CN=" + name + ",O=ddssec example", {}, validity_, random_));
    const auto folder = options_.out / name;
    DDSSEC_RETURN_IF_ERROR(write_credential(folder / "identity", self.certificate, self.key));
    // CVE-2023-24011: the rogue participant signs its permissions with its own identity.
    const auto& ca = authorities.permissions();
    return sign(name == options_.rogue ? self : pki::Credential{ca.certificate(), ca.key()},
                permissions, folder / "permissions.p7s");
  }

  static Status write_credential(const fs::path& stem, const pki::Certificate& certificate,
                                 const pki::PrivateKey& key) {
    DDSSEC_RETURN_IF_ERROR(write_file(fs::path(stem) += ".pem", as_bytes(certificate.pem())));
    DDSSEC_ASSIGN_OR_RETURN(const auto pem, key.to_pem());
    return pem.expose(
        [&](BytesView octets) { return write_file(fs::path(stem) += ".key", octets); });
  }

  Status sign(const pki::Credential& signer, const fs::path& document, const fs::path& to) {
    DDSSEC_ASSIGN_OR_RETURN(const auto octets, read_file(document));
    DDSSEC_ASSIGN_OR_RETURN(const auto signed_document,
                            pki::sign_document(signer, octets, clock_.calendar_seconds(), random_));
    return write_file(to, signed_document);
  }

  const Options& options_;
  SystemClock clock_;
  SystemRandom random_;
  pki::Validity validity_;
};

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app("Makes an example PKI with signed documents. Test keys, never to deploy.");
  app.add_option("documents", options.documents,
                 "folder with governance*.xml and NAME.permissions.xml")
      ->required()
      ->check(CLI::ExistingDirectory);
  app.add_option("out", options.out, "folder to write")->required();
  app.add_flag("--one-ca", options.one_ca,
               "one CA signs identities and documents, as many systems do");
  app.add_option("--rogue", options.rogue,
                 "this participant signs its permissions itself (CVE-2023-24011)");
  app.add_option("--days", options.days, "how long everything is valid")
      ->check(CLI::Range(1, 36500));
  CLI11_PARSE(app, argc, argv);

  const Status made = ExampleSet(options).make();
  if (!made) std::cerr << "ddssec-example: " << made.error().to_sentence() << "\n";
  return made ? 0 : 1;
}
