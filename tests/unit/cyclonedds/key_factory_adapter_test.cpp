// Participants and endpoints that the host registers and unregisters.
#include <cstdlib>
#include <fstream>
#include <utility>

#include "plugins/cyclonedds/value_translation.hpp"
#include "plugins/spi/process_properties.hpp"
#include "tests/unit/cyclonedds/cryptography_adapters.hpp"
#include "tests/unit/cyclonedds/support.hpp"

namespace ddssec::cyclonedds::cryptography_adapters {
namespace {

using testing::_;
using testing::Return;

TEST_F(CryptographyAdapterTest, Registration_ReachesThePlugin) {
  EXPECT_CALL(plugin, register_local_participant(spi::IdentityHandle{1}, spi::PermissionsHandle{2},
                                                 spi::PropertyList{}, _))
      .WillOnce(Return(spi::ParticipantCryptoHandle{10}));
  EXPECT_EQ(factory->register_local_participant(factory, 1, 2, nullptr, &participant, nullptr), 10);

  EXPECT_CALL(plugin, register_matched_remote_participant(spi::ParticipantCryptoHandle{10},
                                                          spi::IdentityHandle{3},
                                                          spi::PermissionsHandle{4}, _))
      .WillOnce([](auto, auto, auto, const spi::SharedSecret& given) {
        EXPECT_EQ(given.secret.size(), 32u);
        EXPECT_EQ(given.challenge1[0], 1);
        EXPECT_EQ(given.challenge2[0], 2);
        return spi::ParticipantCryptoHandle{11};
      });
  EXPECT_EQ(factory->register_matched_remote_participant(factory, 10, 3, 4, secret_handle, nullptr),
            11);

  std::string name = "dds.sec.crypto.keysize", value = "128";
  DDS_Security_Property_t property{name.data(), value.data(), 1};
  const DDS_Security_PropertySeq properties{1, 1, &property};
  endpoint.is_payload_protected = 1;
  endpoint.plugin_endpoint_attributes =
      spi::kMaskIsValid | DDS_SECURITY_PLUGIN_ENDPOINT_ATTRIBUTES_FLAG_IS_PAYLOAD_ENCRYPTED;
  const spi::EndpointSecurityAttributes encrypted{.topic = {},
                                                  .payload = spi::ProtectionKind::encrypt};
  EXPECT_CALL(plugin, register_local_datawriter(spi::ParticipantCryptoHandle{10},
                                                spi::PropertyList{{name, value}}, encrypted))
      .WillOnce(Return(spi::DatawriterCryptoHandle{20}));
  EXPECT_EQ(factory->register_local_datawriter(factory, 10, &properties, &endpoint, nullptr), 20);
  EXPECT_CALL(plugin, register_local_datareader(spi::ParticipantCryptoHandle{10}, _, encrypted))
      .WillOnce(Return(spi::DatareaderCryptoHandle{21}));
  EXPECT_EQ(factory->register_local_datareader(factory, 10, &properties, &endpoint, nullptr), 21);
  EXPECT_CALL(plugin, register_matched_remote_datareader(spi::DatawriterCryptoHandle{20},
                                                         spi::ParticipantCryptoHandle{11}, _, true))
      .WillOnce(Return(spi::DatareaderCryptoHandle{30}));
  EXPECT_EQ(factory->register_matched_remote_datareader(factory, 20, 11, secret_handle, 1, nullptr),
            30);
  EXPECT_CALL(plugin, register_matched_remote_datawriter(spi::DatareaderCryptoHandle{21},
                                                         spi::ParticipantCryptoHandle{11}, _))
      .WillOnce(Return(spi::DatawriterCryptoHandle{31}));
  EXPECT_EQ(factory->register_matched_remote_datawriter(factory, 21, 11, secret_handle, nullptr),
            31);
}

// Sets an environment variable for one test.
struct Variable {
  Variable(const char* name, const std::string& value) : name(name) {
    setenv(name, value.c_str(), 1);
  }
  ~Variable() { unsetenv(name); }
  const char* name;
};

TEST_F(CryptographyAdapterTest, AParticipantsProperties_ComeFromTheEnvironment) {
  const auto file = testing::TempDir() + "ddssec-cyclonedds.properties";
  std::ofstream(file)
      << "dds.sec.crypto.symmetric_cipher_algorithm = AES128+GCM\ndds.sec.crypto.keysize = 128\n";
  const auto registers_with = [&](const spi::PropertyList& expected) {
    EXPECT_CALL(plugin, register_local_participant(_, _, expected, _))
        .WillOnce(Return(spi::ParticipantCryptoHandle{10}));
    EXPECT_EQ(factory->register_local_participant(factory, 1, 2, nullptr, &participant, nullptr),
              10);
  };
  const spi::Property other{"dds.sec.crypto.keysize", "128", false};
  const auto cipher = [](std::string name) {
    return spi::Property{"dds.sec.crypto.symmetric_cipher_algorithm", std::move(name), false};
  };
  {
    const Variable from(spi::kPropertiesVariable, file);
    registers_with({cipher("AES128+GCM"), other});
    const Variable over(spi::kCipherVariable, "org.ddssec.ChaCha20-Poly1305");
    registers_with({other, cipher("org.ddssec.ChaCha20-Poly1305")});
  }
  {
    const Variable over(spi::kCipherVariable, "AUTO");
    registers_with({cipher("AUTO")});
    const Variable nothing(spi::kPropertiesVariable, "");
    registers_with({cipher("AUTO")});
  }
  const Variable missing(spi::kPropertiesVariable, file + ".not-there");
  EXPECT_EQ(factory->register_local_participant(factory, 1, 2, nullptr, &participant, &refusal), 0);
  EXPECT_EQ(refusal.reason(), Code::file_not_found);
}

TEST_F(CryptographyAdapterTest, Registration_RefusesNullAndForeignSecrets) {
  EXPECT_EQ(factory->register_local_participant(factory, 1, 2, nullptr, nullptr, &refusal), 0);
  EXPECT_EQ(refusal.reason(), Code::null_argument);
  EXPECT_EQ(factory->register_local_datawriter(factory, 1, nullptr, nullptr, nullptr), 0);
  EXPECT_EQ(factory->register_local_datareader(factory, 1, nullptr, nullptr, nullptr), 0);
  Refusal foreign;
  EXPECT_EQ(factory->register_matched_remote_participant(factory, 1, 2, 3, 0, &foreign), 0);
  EXPECT_EQ(foreign.reason(), Code::foreign_shared_secret);
  EXPECT_EQ(factory->register_matched_remote_datareader(factory, 1, 2, 0, 0, nullptr), 0);
  EXPECT_EQ(factory->register_matched_remote_datawriter(factory, 1, 2, 0, nullptr), 0);
  EXPECT_EQ(factory->register_local_participant(nullptr, 1, 2, nullptr, &participant, nullptr), 0);
}

TEST_F(CryptographyAdapterTest, NilHandlesOfUnprotectedEndpoints_AreUnregistered) {
  EXPECT_CALL(plugin, unregister_participant(spi::ParticipantCryptoHandle{1}))
      .WillOnce(Return(Status{}));
  EXPECT_CALL(plugin, unregister_datawriter(spi::DatawriterCryptoHandle{1}))
      .WillOnce(Return(fail(Code::malformed)));
  EXPECT_CALL(plugin, unregister_datareader(spi::DatareaderCryptoHandle{1}))
      .WillOnce(Return(Status{}));
  for (const auto handle : {0, 1}) {
    EXPECT_EQ(factory->unregister_participant(factory, handle, nullptr), 1);
    EXPECT_EQ(factory->unregister_datawriter(factory, handle, nullptr), handle == 0);
    EXPECT_EQ(factory->unregister_datareader(factory, handle, nullptr), 1);
  }
}

// Cyclone DDS returns a handle twice when several participants end at once, and logs each refusal.
TEST_F(CryptographyAdapterTest, AHandleThatIsReturnedTwice_IsNoError) {
  EXPECT_CALL(plugin, unregister_datawriter)
      .WillOnce(Return(Status{}))
      .WillOnce(Return(fail(Code::crypto_handle_unknown)))
      .WillOnce(Return(fail(Code::crypto_handle_wrong_kind)));
  auto* const keys = factory;
  EXPECT_EQ(keys->unregister_datawriter(keys, 3, &refusal), 1);
  EXPECT_EQ(keys->unregister_datawriter(keys, 3, &refusal), 1);
  EXPECT_TRUE(harness.events.empty());
  EXPECT_EQ(keys->unregister_datawriter(keys, 3, &refusal), 0);
}

}  // namespace
}  // namespace ddssec::cyclonedds::cryptography_adapters
