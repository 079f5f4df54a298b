// What stands in the place of a document of a running participant and is none: the document in
// force stays, and one event says what is wrong.
#include <tuple>

#include <gmock/gmock.h>

#include "base/rate_limited_sink.hpp"
#include "tests/support/bad_file.hpp"
#include "tests/unit/authentication/listed.hpp"
#include "tests/unit/authentication/ocsp_responses.hpp"

namespace ddssec::authentication {
namespace {

using testing::AllOf;
using testing::Ge;
using testing::IsEmpty;
using testing::Le;
using testing::SizeIs;

constexpr std::array<std::string_view, 6> kDocuments = {"cert.pem", "key.pem",  "identity_ca.pem",
                                                        "crl.pem",  "ocsp.der", "renewed.pem"};

// Alice has a file for each document, and a session with Bob.
class DocumentsInFiles : public testing::Test {
 protected:
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
  std::vector<Event>& events() { return plugin().events.all; }
  // Polls after that time. The events pass the limit that both hosts have.
  void poll(std::chrono::milliseconds after) {
    const auto before = events().size();
    plugin().clock.advance(after);
    EXPECT_THAT(plugin()->poll(), IsEmpty()) << "a session ended";
    for (auto i = before; i < events().size(); ++i) limited_.raise(events()[i]);
  }

  const test::TemporaryFolder folder_;
  Pairing pairing_{with_files(), listed::bob_with({kNow - 24h, kNow + 100 * 24h})};
  test::RecordedEvents passed_;
  RateLimitedSink limited_{passed_, plugin().clock};
};

class BadDocuments
    : public DocumentsInFiles,
      public testing::WithParamInterface<std::tuple<std::string_view, std::string_view>> {
 protected:
  static std::string document() { return std::string(std::get<0>(GetParam())); }
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
                         testing::Combine(testing::ValuesIn(kDocuments),
                                          testing::ValuesIn(test::kBadFiles)),
                         [](const auto& info) {
                           std::string name(std::get<0>(info.param));
                           std::erase_if(name, [](char c) { return c == '.' || c == '_'; });
                           return name + std::string(std::get<1>(info.param));
                         });

class ChangingDocument : public DocumentsInFiles,
                         public testing::WithParamInterface<std::string_view> {};

// The files change ten times in each interval.
TEST_P(ChangingDocument, InItsPlace_CostsOneLookForEachIntervalAndIsOneEvent) {
  pairing_.expect_success();
  plugin().codes_after_looking();
  events().clear();
  for (int i = 0; i < 50; ++i) {
    folder_.replace(std::string(GetParam()), "nonsense " + std::to_string(i));
    poll(100ms);
  }
  // A key without its certificate is judged by the content of the certificate, which stays the
  // same.
  const auto least = GetParam() == "key.pem" ? 1u : 2u;
  EXPECT_THAT(events(), SizeIs(AllOf(Ge(least), Le(5u)))) << plugin().events.text();
  EXPECT_THAT(passed_.all, SizeIs(1)) << passed_.text();
  for (const auto& event : passed_.all)
    EXPECT_EQ(event.error.details().document, folder_.path() + "/" + std::string(GetParam()));
  pairing_.expect_success();
}

INSTANTIATE_TEST_SUITE_P(EachDocument, ChangingDocument, testing::ValuesIn(kDocuments),
                         [](const auto& info) {
                           std::string name(info.param);
                           std::erase_if(name, [](char c) { return c == '.' || c == '_'; });
                           return name;
                         });

TEST_F(DocumentsInFiles, InAFolderThatCloses_AreOneEventAndStay) {
  pairing_.expect_success();
  plugin().codes_after_looking();
  events().clear();
  {
    const test::ClosedFolder closed(folder_.path());
    for (int i = 0; i < 6; ++i) poll(5s);
  }
  ASSERT_THAT(passed_.codes(), testing::ElementsAre(Code::folder_unreadable)) << passed_.text();
  EXPECT_EQ(passed_.all.front().error.details().document, folder_.path());
  EXPECT_THAT(plugin().codes_after_looking(), IsEmpty()) << "after the folder was opened again";
  pairing_.expect_success();
}

}  // namespace
}  // namespace ddssec::authentication
