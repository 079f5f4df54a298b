// What stands in the place of a document of a running participant and is none: the document in
// force stays, and one event says what is wrong.
#include <tuple>

#include <gmock/gmock.h>

#include "tests/support/bad_file.hpp"
#include "tests/unit/authentication/listed.hpp"
#include "tests/unit/authentication/ocsp_responses.hpp"

namespace ddssec::authentication {
namespace {

using testing::IsEmpty;
using testing::SizeIs;

// Alice has a file for each document, and a session with Bob.
class BadDocuments : public testing::TestWithParam<std::tuple<std::string_view, std::string_view>> {
 protected:
  static std::string document() { return std::string(std::get<0>(GetParam())); }

  Identity with_files() const {
    auto identity = make_identity(test_ca(), listed::kAlice);
    const auto in = [&](const char* name, const std::string& text) {
      return "file:" + folder_.write(name, text);
    };
    set(identity.properties, property::kIdentityCertificate,
        in("cert.pem", identity.certificate.pem()));
    set(identity.properties, property::kPrivateKey, in("key.pem", pem_text(identity.key)));
    set(identity.properties, property::kIdentityCa,
        in("identity_ca.pem", test_ca().certificate().pem()));
    in("crl.pem", pem({.number = 4}));
    in("ocsp.der", std::string(as_text(response_about(identity.certificate))));
    in("renewed.pem", listed::list_of({listed::renewed_bob()}));
    return identity;
  }
  TestPlugin& plugin() { return pairing_.first_plugin; }

  const test::TemporaryFolder folder_;
  Pairing pairing_{with_files(), listed::bob_with({kNow - 24h, kNow + 100 * 24h})};
};

TEST_P(BadDocuments, InItsPlace_IsOneEventAndChangesNothing) {
  pairing_.expect_success();
  plugin().codes_after_looking();
  {
    const test::BadFile bad(std::get<1>(GetParam()), folder_.path() + "/" + document());
    plugin().events.all.clear();
    for (int i = 0; i < 6; ++i) EXPECT_THAT(plugin().poll(), IsEmpty()) << "a session ended";
    EXPECT_THAT(plugin().events.all, SizeIs(1));
    for (const auto& event : plugin().events.all)
      EXPECT_EQ(event.error.details().document, folder_.path() + "/" + document())
          << event.error.to_sentence();
  }
  pairing_.expect_success();
}

INSTANTIATE_TEST_SUITE_P(EachDocument, BadDocuments,
                         testing::Combine(testing::Values("cert.pem", "identity_ca.pem", "crl.pem",
                                                          "ocsp.der", "renewed.pem"),
                                          testing::ValuesIn(test::kBadFiles)),
                         [](const auto& info) {
                           std::string name(std::get<0>(info.param));
                           std::erase_if(name, [](char c) { return c == '.' || c == '_'; });
                           return name + std::string(std::get<1>(info.param));
                         });

}  // namespace
}  // namespace ddssec::authentication
