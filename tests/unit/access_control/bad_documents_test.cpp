// What stands in the place of a document of a running participant and is none: the document in
// force stays, and one event says what is wrong.
#include <tuple>

#include <gmock/gmock.h>

#include "base/rate_limited_sink.hpp"
#include "pki/renewal_list.hpp"
#include "tests/support/bad_file.hpp"
#include "tests/unit/access_control/listed_peers.hpp"

namespace ddssec::access_control {
namespace {

using testing::AllOf;
using testing::Ge;
using testing::IsEmpty;
using testing::Le;
using testing::SizeIs;

// The talker has a file for each document. The listener's permissions end after 20 s, and the
// renewal list extends them.
class DocumentsInFiles : public ListedPeers {
 protected:
  void SetUp() override { begin(false); }
  // `with_identity_ca`: the file with the identity CAs is in the folder, too.
  void begin(bool with_identity_ca) {
    put({document({"t"}, 0s, 12h)});
    auto all = properties("", "");
    const auto put_file = [&](std::string_view name, const char* file, const std::string& text) {
      for (auto& one : all)
        if (one.name == name) one.value = "file:" + folder_.write(file, text);
    };
    put_file(spi::property::kPermissionsCa, "permissions_ca.pem",
             authorities().permissions_ca.certificate().pem());
    put_file(spi::property::kGovernance, "governance.p7s",
             signed_document(governance::to_xml(governance_document)));
    put_file(spi::property::kPermissions, "permissions.p7s", open_permissions(kTalker));
    if (with_identity_ca)
      put_file(spi::property::kIdentityCa, "identity_ca.pem",
               authorities().identity_ca.certificate().pem());
    all.push_back({std::string(spi::property::kRenewalList), "file:" + path_, false});
    (void)plugin->return_permissions_handle(peer_);
    (void)plugin->return_permissions_handle(own_);
    own_ = plugin->validate_local_permissions(kLocalIdentity, 0, all)
               .value_or(spi::PermissionsHandle{});
    ASSERT_TRUE(own_);
    meet(document({"t"}));
    poll();
    log.all.clear();
  }
  // Polls after that time. The events pass the limit that both hosts have.
  void poll_limited(std::chrono::milliseconds after) {
    const auto before = log.all.size();
    clock.advance(after);
    EXPECT_THAT(plugin->poll(), IsEmpty()) << "a peer ended";
    for (auto i = before; i < log.all.size(); ++i) limited_.raise(log.all[i]);
  }
  void expect_unharmed() {
    EXPECT_TRUE(may_publish("t"));
    EXPECT_TRUE(plugin->check_create_datawriter(own_, 0, {.topic_name = "t"}));
  }

  test::RecordedEvents passed_;
  RateLimitedSink limited_{passed_, clock};
};

class BadDocuments : public DocumentsInFiles,
                     public testing::WithParamInterface<std::tuple<const char*, std::string_view>> {
 protected:
  static const char* name() { return std::get<0>(GetParam()); }
};

TEST_P(BadDocuments, InItsPlace_IsOneEventAndChangesNothing) {
  const test::BadFile bad(std::get<1>(GetParam()), folder_.path() + "/" + name());
  for (int i = 0; i < 6; ++i) EXPECT_THAT(poll(), IsEmpty()) << "a peer ended";
  // Authentication reports a renewal list that cannot be read.
  EXPECT_THAT(log.all, SizeIs(std::string_view(name()) == "renewed.pem" ? 0 : 1));
  for (const auto& event : log.all)
    EXPECT_EQ(event.error.details().document, folder_.path() + "/" + name())
        << event.error.to_sentence();
  expect_unharmed();
}

INSTANTIATE_TEST_SUITE_P(EachDocument, BadDocuments,
                         testing::Combine(testing::Values("permissions_ca.pem", "governance.p7s",
                                                          "permissions.p7s", "renewed.pem"),
                                          testing::ValuesIn(test::kBadFiles)),
                         [](const auto& info) {
                           std::string name = std::get<0>(info.param);
                           std::erase_if(name, [](char c) { return c == '.' || c == '_'; });
                           return name + std::string(std::get<1>(info.param));
                         });

class ChangingDocument : public DocumentsInFiles,
                         public testing::WithParamInterface<const char*> {};

// The files change ten times in each interval. Authentication reports a renewal list that cannot be
// read.
TEST_P(ChangingDocument, InItsPlace_CostsOneLookForEachIntervalAndIsOneEvent) {
  for (int i = 0; i < 50; ++i) {
    folder_.replace(GetParam(), "nonsense " + std::to_string(i));
    poll_limited(100ms);
  }
  if (std::string_view(GetParam()) == "renewed.pem") {
    EXPECT_THAT(log.all, IsEmpty());
  } else {
    EXPECT_THAT(log.all, SizeIs(AllOf(Ge(2u), Le(5u)))) << log.text();
    EXPECT_THAT(passed_.all, SizeIs(1)) << passed_.text();
  }
  for (const auto& event : passed_.all)
    EXPECT_EQ(event.error.details().document, folder_.path() + "/" + GetParam());
  expect_unharmed();
}

INSTANTIATE_TEST_SUITE_P(EachDocument, ChangingDocument,
                         testing::Values("permissions_ca.pem", "governance.p7s", "permissions.p7s",
                                         "renewed.pem"),
                         [](const auto& info) {
                           std::string name = info.param;
                           std::erase_if(name, [](char c) { return c == '.' || c == '_'; });
                           return name;
                         });

TEST_F(DocumentsInFiles, InAFolderThatCloses_AreOneEventAndStay) {
  {
    const test::ClosedFolder closed(folder_.path());
    for (int i = 0; i < 6; ++i) poll_limited(1s);
    expect_unharmed();
  }
  ASSERT_THAT(passed_.codes(), testing::ElementsAre(Code::folder_unreadable)) << passed_.text();
  EXPECT_EQ(passed_.all.front().error.details().document, folder_.path());
  EXPECT_THAT(codes_after_looking(), IsEmpty()) << "after the folder was opened again";
  expect_unharmed();
}

// Authentication reports the folder of the identity CA.
TEST_F(DocumentsInFiles, BesideTheIdentityCaInAFolderThatCloses_AreNoEvent) {
  begin(true);
  {
    const test::ClosedFolder closed(folder_.path());
    for (int i = 0; i < 6; ++i) poll_limited(1s);
  }
  EXPECT_THAT(log.all, IsEmpty()) << log.text();
  expect_unharmed();
}

}  // namespace
}  // namespace ddssec::access_control
