// What stands in the place of a document of a running participant and is none: the document in
// force stays, and one event says what is wrong.
#include <tuple>

#include <gmock/gmock.h>

#include "pki/renewal_list.hpp"
#include "tests/support/bad_file.hpp"
#include "tests/unit/access_control/listed_peers.hpp"

namespace ddssec::access_control {
namespace {

using testing::IsEmpty;
using testing::SizeIs;

// The talker has a file for each document. The listener's permissions end after 20 s, and the
// renewal list extends them.
class BadDocuments : public ListedPeers,
                     public testing::WithParamInterface<std::tuple<const char*, std::string_view>> {
 protected:
  void SetUp() override {
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
  EXPECT_TRUE(may_publish("t"));
  EXPECT_TRUE(plugin->check_create_datawriter(own_, 0, {.topic_name = "t"}));
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

}  // namespace
}  // namespace ddssec::access_control
