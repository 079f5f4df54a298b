#include "plugins/cyclonedds/shared_memory_guard.hpp"

#include <dlfcn.h>
#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include "plugins/cyclonedds/access_control_adapter.hpp"
#include "plugins/spi/process_properties.hpp"
#include "tests/support/expect_code.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/unit/cyclonedds/psmx_library.hpp"
#include "tests/unit/cyclonedds/support.hpp"

namespace ddssec::cyclonedds::psmx_library {
namespace {

using testing::HasSubstr;

constexpr const char* kAllow = "org.ddssec.access.allow_shared_memory";

// A file of that name that is mapped as a segment of shared memory is.
class Mapping {
 public:
  explicit Mapping(const std::string& file) {
    const int descriptor = open(file.c_str(), O_RDONLY | O_CLOEXEC);
    address_ = mmap(nullptr, 1, PROT_READ, MAP_SHARED, descriptor, 0);
    close(descriptor);
    EXPECT_NE(address_, MAP_FAILED);
  }
  ~Mapping() { munmap(address_, 1); }
  Mapping(const Mapping&) = delete;
  Mapping& operator=(const Mapping&) = delete;

 private:
  void* address_;
};

TEST(IceoryxSegment, NameOfTheMapping_TellsIt) {
  const std::string before =
      "7f00-7f01 r-xp 0000 08:01 11  /usr/lib/x86_64-linux-gnu/libiceoryx_posh.so.2.0.3\n"
      "7f02-7f03 rw-p 0000 00:00 0 \n";
  EXPECT_EQ(iceoryx_segment(before), std::nullopt);
  EXPECT_EQ(
      iceoryx_segment(before + "7f04-7f05 rw-s 0000 00:19 5  /dev/shm/iceoryx_mgmt\n" + before),
      "/dev/shm/iceoryx_mgmt");
  EXPECT_EQ(iceoryx_segment("7f04-7f05 rw-s 0000 00:19 5  /dev/shm/iceoryx_mgmt (deleted)"),
            "/dev/shm/iceoryx_mgmt (deleted)");
  // In another mount namespace, a segment appears without its folder.
  EXPECT_EQ(iceoryx_segment("7f04-7f05 rw-s 0000 00:19 5  /iceoryx_mgmt"), "/iceoryx_mgmt");
  EXPECT_EQ(iceoryx_segment("7f04-7f05 rw-s 0000 00:19 5  /dev/shm/iox1_0_i_mgmt"),
            "/dev/shm/iox1_0_i_mgmt");
  EXPECT_EQ(iceoryx_segment("7f04-7f05 rw-s 0000 00:19 5  /home/me/not_iceoryx_mgmt"),
            std::nullopt);
  EXPECT_EQ(iceoryx_segment(""), std::nullopt);
}

TEST(SharedMemoryBypass, OrdinaryProcess_HasNone) {
  const auto found = find_bypass();
  ASSERT_TRUE(found);
  EXPECT_FALSE(*found) << (*found)->seen;
}

TEST(SharedMemoryBypass, MappedSegment_IsFound) {
  const test::TemporaryFolder folder;
  const auto file = folder.write("iceoryx_mgmt", "x");
  const Mapping mapping(file);
  const auto found = find_bypass();
  ASSERT_TRUE(found);
  ASSERT_TRUE(*found);
  EXPECT_EQ((*found)->setting, "<SharedMemory><Enable>");
  EXPECT_EQ((*found)->seen, file + " is mapped");
}

TEST(SharedMemoryBypass, LoadedPsmxLibrary_IsFound) {
  const PsmxLibrary library;
  const auto found = find_bypass();
  ASSERT_TRUE(found);
  ASSERT_TRUE(*found);
  EXPECT_EQ((*found)->setting, "<PubSubMessageExchange>");
  EXPECT_EQ((*found)->seen, std::string("example_create_psmx in ") + DDSSEC_PSMX_LIKE);
}

TEST(SharedMemoryBypass, MappingsThatCannotBeRead_AreRefused) {
  const test::TemporaryFolder folder;
  EXPECT_CODE(find_bypass((folder.path() + "/none").c_str()), shared_memory_undecidable);
  EXPECT_CODE(find_bypass(folder.write("empty", "").c_str()), shared_memory_undecidable);
  EXPECT_CODE(find_bypass(folder.path().c_str()), shared_memory_undecidable);
}

TEST(PromiseForSamples, EachProtection_IsNamedIfSharedMemoryWouldBreakIt) {
  spi::ParticipantSecurityAttributes participant;
  // These protections promise nothing about samples.
  participant.discovery = participant.liveliness = ProtectionKind::encrypt;
  spi::EndpointSecurityAttributes endpoint;
  endpoint.topic.is_discovery_protected = endpoint.topic.is_liveliness_protected = true;
  const auto promise = [&](EndpointDirection direction) {
    return promise_for_samples(participant, endpoint, direction);
  };
  EXPECT_EQ(promise(EndpointDirection::writes), "");
  EXPECT_EQ(promise(EndpointDirection::reads), "");
  endpoint.topic.is_read_protected = true;
  EXPECT_EQ(promise(EndpointDirection::writes), "enable_read_access_control true");
  EXPECT_EQ(promise(EndpointDirection::reads), "");
  endpoint.topic.is_read_protected = false;
  endpoint.topic.is_write_protected = true;
  EXPECT_EQ(promise(EndpointDirection::writes), "");
  EXPECT_EQ(promise(EndpointDirection::reads), "enable_write_access_control true");
  participant.rtps = ProtectionKind::sign;
  EXPECT_EQ(promise(EndpointDirection::writes), "rtps_protection_kind SIGN");
  endpoint.submessage = ProtectionKind::sign_with_origin_authentication;
  EXPECT_EQ(promise(EndpointDirection::reads),
            "metadata_protection_kind SIGN_WITH_ORIGIN_AUTHENTICATION");
  endpoint.payload = ProtectionKind::encrypt;
  EXPECT_EQ(promise(EndpointDirection::reads), "data_protection_kind ENCRYPT");
}

TEST(SharedMemoryGuard, SeveralChecks_LookOnceUnlessTheLookFails) {
  int looks = 0;
  Result<std::optional<Bypass>> answer = fail(Code::out_of_memory);
  SharedMemoryGuard guard([&] {
    ++looks;
    return answer;
  });
  EXPECT_CODE(guard.check("Square", "data_protection_kind SIGN"), out_of_memory);
  answer = std::optional<Bypass>();
  EXPECT_TRUE(guard.check("Square", "data_protection_kind SIGN"));
  answer = Bypass{"setting", "seen"};
  EXPECT_TRUE(guard.check("Square", "data_protection_kind SIGN"));
  EXPECT_EQ(looks, 2);
}

TEST(SharedMemoryGuard, TheProperty_IsTrueOrFalse) {
  const auto allowed = [](spi::PropertyList properties) {
    return SharedMemoryGuard::is_allowed_by(properties);
  };
  EXPECT_FALSE(allowed({}).value());
  EXPECT_FALSE(allowed({{kAllow, "false", false}}).value());
  EXPECT_TRUE(allowed({{kAllow, "true", false}}).value());
  EXPECT_CODE(allowed({{kAllow, "yes", false}}), invalid_property);
  EXPECT_CODE(allowed({{kAllow, "", false}}), invalid_property);
}

// The adapter in a process whose samples bypass it, for a topic with encrypted data.
struct AdapterWithSharedMemory : testing::Test {
  AdapterWithSharedMemory() {
    ON_CALL(*plugin, validate_local_permissions).WillByDefault([this](auto&&...) {
      return spi::PermissionsHandle{++last_handle};
    });
    ON_CALL(*plugin, check_create_datawriter).WillByDefault([](auto&&...) { return Status{}; });
    ON_CALL(*plugin, check_create_datareader).WillByDefault([](auto&&...) { return Status{}; });
    ON_CALL(*plugin, return_permissions_handle).WillByDefault([](auto&&...) { return Status{}; });
    ON_CALL(*plugin, participant_sec_attributes).WillByDefault([this](auto&&...) {
      return participant;
    });
    ON_CALL(*plugin, datawriter_sec_attributes).WillByDefault([this](auto&&...) {
      return endpoint;
    });
    ON_CALL(*plugin, datareader_sec_attributes).WillByDefault([this](auto&&...) {
      return endpoint;
    });
    endpoint.payload = ProtectionKind::encrypt;
  }
  ~AdapterWithSharedMemory() override { unsetenv(spi::kPropertiesVariable); }

  // The QoS of a participant or an endpoint, with the property.
  struct Qos : DDS_Security_Qos {
    explicit Qos(std::string value) : DDS_Security_Qos{}, text(std::move(value)) {
      one.name = name.data();
      one.value = text.data();
      property.value._buffer = &one;
      property.value._length = property.value._maximum = 1;
    }
    std::string name = kAllow, text;
    DDS_Security_Property_t one{};
  };

  std::int64_t validate(const DDS_Security_Qos& with) {
    return c->validate_local_permissions(c, nullptr, 1, 0, &with, nullptr);
  }
  bool may_write(std::int64_t handle, const DDS_Security_Qos& with = {}) {
    Refusal refusal;
    const bool may =
        c->check_create_datawriter(c, handle, 0, "Square", &with, nullptr, nullptr, &refusal) != 0;
    sentence = refusal.text();
    return may;
  }
  bool may_read(std::int64_t handle, const DDS_Security_Qos& with = {}) {
    Refusal refusal;
    const bool may =
        c->check_create_datareader(c, handle, 0, "Square", &with, nullptr, nullptr, &refusal) != 0;
    sentence = refusal.text();
    return may;
  }

  std::vector<Event> events;
  testing::NiceMock<MockAccessControl>* plugin = new testing::NiceMock<MockAccessControl>;
  AccessControlAdapter adapter{
      std::make_unique<Host>(std::make_unique<Recorder>(events)),
      [this](const PluginServices&) { return std::unique_ptr<spi::AccessControl>(plugin); },
      nullptr,
      []() -> Result<std::optional<Bypass>> {
        return Bypass{"<SharedMemory><Enable>", "/dev/shm/iceoryx_mgmt is mapped"};
      }};
  dds_security_access_control* c = &adapter;
  std::int64_t last_handle = 7;
  spi::ParticipantSecurityAttributes participant;
  spi::EndpointSecurityAttributes endpoint;
  std::string sentence;
};

TEST_F(AdapterWithSharedMemory, ProtectedEndpoints_AreRefusedWithTheSettingsName) {
  const auto handle = validate({});
  EXPECT_FALSE(may_write(handle));
  ASSERT_FALSE(events.empty());
  EXPECT_EQ(events.back().error.code(), Code::shared_memory_bypasses_protection);
  for (const auto* part :
       {"Cyclone DDS's configuration, <SharedMemory><Enable>: ",
        "expected shared memory off, as governance promises data_protection_kind ENCRYPT for topic "
        "Square, found /dev/shm/iceoryx_mgmt is mapped",
        "org.ddssec.access.allow_shared_memory", "[shared_memory_bypasses_protection 1630]"})
    EXPECT_THAT(events.back().error.to_sentence(), HasSubstr(part));
  EXPECT_FALSE(may_read(handle));
}

TEST_F(AdapterWithSharedMemory, UnprotectedEndpoints_AreLeftAlone) {
  endpoint.payload = ProtectionKind::none;
  const auto handle = validate({});
  EXPECT_TRUE(may_write(handle)) << sentence;
  EXPECT_TRUE(may_read(handle)) << sentence;
  participant.rtps = ProtectionKind::encrypt;
  EXPECT_FALSE(may_write(handle));
  EXPECT_FALSE(may_read(handle));
}

TEST_F(AdapterWithSharedMemory, AWriter_AnswersForItsReadersAndAReaderForItsWriters) {
  endpoint.payload = ProtectionKind::none;
  endpoint.topic.is_read_protected = true;
  const auto handle = validate({});
  EXPECT_FALSE(may_write(handle));
  EXPECT_TRUE(may_read(handle)) << sentence;
  endpoint.topic = {.is_write_protected = true};
  EXPECT_TRUE(may_write(handle)) << sentence;
  EXPECT_FALSE(may_read(handle));
}

TEST_F(AdapterWithSharedMemory, TheParticipantsProperty_AllowsItForThatParticipant) {
  const auto accepts = validate(Qos("true"));
  const auto other = validate(Qos("false"));
  EXPECT_TRUE(may_write(accepts)) << sentence;
  EXPECT_TRUE(may_read(accepts)) << sentence;
  EXPECT_FALSE(may_write(other));
  EXPECT_EQ(validate(Qos("maybe")), DDS_SECURITY_HANDLE_NIL);
  c->return_permissions_handle(c, accepts, nullptr);
  EXPECT_FALSE(may_write(accepts)) << "the handle may be another participant's now";
}

TEST_F(AdapterWithSharedMemory, TheEndpointsProperty_AllowsItForThatEndpoint) {
  const auto handle = validate({});
  EXPECT_TRUE(may_write(handle, Qos("true"))) << sentence;
  EXPECT_TRUE(may_read(handle, Qos("true"))) << sentence;
  EXPECT_FALSE(may_write(handle, Qos("false")));
  EXPECT_FALSE(may_write(handle));
}

TEST_F(AdapterWithSharedMemory, TheFileOfProperties_AllowsItWhereTheHostSaysNothing) {
  const test::TemporaryFolder folder;
  setenv(spi::kPropertiesVariable,
         folder.write("properties", std::string(kAllow) + " = true\n").c_str(), 1);
  EXPECT_TRUE(may_write(validate({}))) << sentence;
  EXPECT_FALSE(may_write(validate(Qos("false")))) << "the host's word goes before";
  setenv(spi::kPropertiesVariable, (folder.path() + "/none").c_str(), 1);
  EXPECT_EQ(validate({}), DDS_SECURITY_HANDLE_NIL);
}

}  // namespace
}  // namespace ddssec::cyclonedds::psmx_library
