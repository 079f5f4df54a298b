// Properties that Cyclone DDS cannot pass on: from the environment and from a file.
#include "plugins/spi/process_properties.hpp"

#include <cstdlib>

#include <gtest/gtest.h>

#include "plugins/spi/property_names.hpp"
#include "tests/support/expect_code.hpp"
#include "tests/support/temporary_folder.hpp"

namespace ddssec::spi {
namespace {

Property property_of(std::string_view name, std::string value) {
  return {std::string(name), std::move(value), false};
}

class ProcessProperties : public testing::Test {
 protected:
  ProcessProperties() {
    ::unsetenv(kPropertiesVariable);
    ::unsetenv(kCipherVariable);
  }
  ~ProcessProperties() override {
    ::unsetenv(kPropertiesVariable);
    ::unsetenv(kCipherVariable);
  }
  void file_says(const std::string& text) const {
    ::setenv(kPropertiesVariable, folder_.write("properties", text).c_str(), 1);
  }
  // Returns the value of a property together with those of the host.
  static std::string value(std::string_view name, PropertyList of_host = {}) {
    const auto all = with_process_properties(std::move(of_host));
    EXPECT_TRUE(all) << all.error().to_sentence();
    return all ? std::string(property_value(*all, name)) : "";
  }
  const test::TemporaryFolder folder_;
};

TEST_F(ProcessProperties, UnsetVariables_LeaveThePropertiesOfTheHost) {
  const PropertyList host = {property_of(property::kPassword, "a")};
  EXPECT_EQ(with_process_properties(host).value(), host);
  ::setenv(kPropertiesVariable, "", 1);
  ::setenv(kCipherVariable, "", 1);
  EXPECT_EQ(with_process_properties(host).value(), host);
}

TEST_F(ProcessProperties, ValueOfTheHost_TakesPrecedenceUnlessItIsEmpty) {
  file_says(std::string(property::kPassword) + " = of the file\n");
  EXPECT_EQ(value(property::kPassword), "of the file");
  EXPECT_EQ(value(property::kPassword, {property_of(property::kPassword, "of the host")}),
            "of the host");
  const auto all = with_process_properties({property_of(property::kPassword, "")});
  ASSERT_OK(all);
  EXPECT_EQ(all->size(), 1u) << "both the empty value and that of the file";
  EXPECT_EQ(property_value(*all, property::kPassword), "of the file");
}

TEST_F(ProcessProperties, CipherOfTheEnvironment_TakesPrecedenceOverTheFile) {
  file_says(std::string(property::kSymmetricCipher) + " = of the file\n");
  ::setenv(kCipherVariable, "of the environment", 1);
  EXPECT_EQ(value(property::kSymmetricCipher), "of the environment");
  ::unsetenv(kCipherVariable);
  EXPECT_EQ(value(property::kSymmetricCipher), "of the file");
}

TEST_F(ProcessProperties, FileThatIsMissingOrWrong_IsAnError) {
  ::setenv(kPropertiesVariable, (folder_.path() + "/none").c_str(), 1);
  EXPECT_CODE(with_process_properties({}), file_not_found);
  file_says("dds.sec.auth.Password = x\n");
  EXPECT_CODE(with_process_properties({}), property_unknown);
}

// Cyclone DDS cannot protect messages before authentication. Without an error they would be sent
// unprotected.
TEST_F(ProcessProperties, PreSharedKeys_AreRefusedByName) {
  for (const auto name :
       {property::kPskPassphrase, property::kPskExtraPassphrases, property::kPskCipher}) {
    const auto refused = with_process_properties({property_of(name, "x")});
    EXPECT_CODE(refused, property_without_effect);
    EXPECT_EQ(refused.error().details().document, name);
    EXPECT_TRUE(with_process_properties({property_of(name, "")}));
    file_says(std::string(name) + " = x\n");
    EXPECT_CODE(with_process_properties({}), property_without_effect);
    ::unsetenv(kPropertiesVariable);
  }
}

TEST_F(ProcessProperties, ValuesThatTheAdaptersRead_AreChecked) {
  EXPECT_TRUE(check_properties_of_adapters({}));
  for (const auto name :
       {property::kClockStepGrace, property::kAllowSharedMemory, property::kTrustTypeInformation}) {
    const auto refused = check_properties_of_adapters({property_of(name, "perhaps")});
    EXPECT_CODE(refused, invalid_property);
    EXPECT_EQ(refused.error().details().document, name);
  }
  EXPECT_TRUE(check_properties_of_adapters({property_of(property::kAllowSharedMemory, "true"),
                                            property_of(property::kClockStepGrace, "0")}));
}

}  // namespace
}  // namespace ddssec::spi
