#include "tests/unit/cyclonedds/mocks.hpp"

namespace ddssec::cyclonedds {

MockAuthentication::MockAuthentication() = default;
MockAuthentication::~MockAuthentication() = default;
MockAccessControl::MockAccessControl() = default;
MockAccessControl::~MockAccessControl() = default;
MockCryptography::MockCryptography() = default;
MockCryptography::~MockCryptography() = default;

}  // namespace ddssec::cyclonedds

template class testing::NiceMock<ddssec::cyclonedds::MockAuthentication>;
template class testing::NiceMock<ddssec::cyclonedds::MockAccessControl>;
template class testing::NiceMock<ddssec::cyclonedds::MockCryptography>;
