// Handles of access control: handles of another plugin, returned handles, and the limit of their
// number.
#include "plugins/access_control/access_control.hpp"

#include "tests/unit/access_control/access_control_fixture.hpp"

namespace ddssec::access_control {
namespace {

using PermissionsHandles = AccessControlTest;

TEST_F(PermissionsHandles, UnknownHandle_IsRefusedEverywhere) {
  const spi::PermissionsHandle unknown{42};
  EXPECT_REFUSED(plugin->check_create_participant(unknown, 0), unknown_permissions_handle);
  EXPECT_REFUSED(plugin->check_remote_datawriter({}, 0, {}), unknown_permissions_handle);
  EXPECT_REFUSED(plugin->permissions_token(unknown), unknown_permissions_handle);
  EXPECT_REFUSED(plugin->participant_sec_attributes(unknown), unknown_permissions_handle);
  EXPECT_CODE(plugin->return_permissions_handle(unknown), unknown_permissions_handle);
}

TEST_F(PermissionsHandles, SecondReturn_IsRefused) {
  const auto handle = local(open_permissions(kTalker));
  ASSERT_TRUE(handle);
  EXPECT_TRUE(plugin->return_permissions_handle(*handle));
  EXPECT_CODE(plugin->return_permissions_handle(*handle), unknown_permissions_handle);
  EXPECT_REFUSED(remote(open_permissions(kListener)), unknown_local_identity);
}

TEST_F(PermissionsHandles, TooManyHandles_AreRefused) {
  make({.max_handles = 2});
  ASSERT_TRUE(local(open_permissions(kTalker)));
  const auto document = open_permissions(kListener);
  const auto peer = remote(document);
  ASSERT_TRUE(peer);
  EXPECT_REFUSED(remote(document), too_many_permissions_handles);
  EXPECT_TRUE(plugin->return_permissions_handle(*peer));
  EXPECT_TRUE(remote(document));
}

TEST_F(PermissionsHandles, HandleInAnotherDomain_IsRefused) {
  const auto handle = local(open_permissions(kTalker));
  ASSERT_TRUE(handle);
  EXPECT_REFUSED(plugin->check_create_participant(*handle, 1), other_domain);
}

TEST_F(PermissionsHandles, HandleOfAPeer_OutlivesTheLocalOne) {
  const auto handle = local(open_permissions(kTalker));
  const auto peer = remote(open_permissions(kListener));
  ASSERT_TRUE(handle && peer);
  EXPECT_TRUE(plugin->return_permissions_handle(*handle));
  EXPECT_TRUE(plugin->check_remote_participant(*peer, 0));
  EXPECT_TRUE(plugin->return_permissions_handle(*peer));
}

}  // namespace
}  // namespace ddssec::access_control
