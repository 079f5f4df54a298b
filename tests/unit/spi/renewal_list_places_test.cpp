// The places where a renewal list is looked for.
#include "plugins/spi/renewal_list_places.hpp"

#include <gmock/gmock.h>

#include "plugins/spi/property_names.hpp"
#include "tests/support/expect_code.hpp"

namespace ddssec::spi {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

PropertyList files(std::string certificate, std::string ca) {
  return {{std::string(property::kIdentityCertificate), std::move(certificate), false},
          {std::string(property::kIdentityCa), std::move(ca), false}};
}

TEST(RenewalListPlaces, UnsetProperty_GivesThePlacesBesideTheCertificateAndTheCa) {
  const auto places = renewal_list_places(files("file:/own/cert.pem", "file:/ca/ca.pem"));
  ASSERT_OK(places);
  EXPECT_THAT(*places, ElementsAre("file:/own/renewed.pem", "file:/ca/renewed.pem"));
}

TEST(RenewalListPlaces, PastedDocuments_HaveNone) {
  const auto places = renewal_list_places(files("data:,certificate", "data:,ca"));
  ASSERT_OK(places);
  EXPECT_THAT(*places, IsEmpty());
}

TEST(RenewalListPlaces, PlaceInTheProperty_IsTheOnlyOne) {
  auto all = files("file:/own/cert.pem", "file:/ca/ca.pem");
  all.push_back({std::string(property::kRenewalList), "file:/lists/all.pem", false});
  const auto places = renewal_list_places(all);
  ASSERT_OK(places);
  EXPECT_THAT(*places, ElementsAre("file:/lists/all.pem"));
}

TEST(RenewalListPlaces, PropertyThatNamesNoFile_IsRefused) {
  auto all = files("file:/own/cert.pem", "file:/ca/ca.pem");
  all.push_back({std::string(property::kRenewalList), "data:,list", false});
  EXPECT_CODE(renewal_list_places(all), invalid_property);
}

}  // namespace
}  // namespace ddssec::spi
