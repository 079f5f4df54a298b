// The wire form of every message, cut anywhere, is refused by the token reader.
#include "tests/unit/authentication/fixture.hpp"

namespace ddssec::authentication {
namespace {

class Truncation : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Messages, Truncation, testing::Values("Req", "Reply", "Final", "AuthReq"));

TEST_P(Truncation, AtEveryOctetIsRefused) {
  Pairing pairing;
  const auto req = pairing.two.request();
  const auto rep = pairing.two.reply(*req->message);
  const auto fin = pairing.two.at_low(req->handle, *rep->message);
  ASSERT_OK(fin);
  const std::map<std::string, Token> tokens = {{"Req", *req->message},
                                               {"Reply", *rep->message},
                                               {"Final", *fin->message},
                                               {"AuthReq", sample()}};
  for (const auto endian : {Endian::little, Endian::big}) {
    Writer writer(endian);
    spi::write_token(writer, tokens.at(GetParam()));
    for (std::size_t size = 0; size < writer.size(); ++size) {
      Reader reader(writer.view().first(size), endian);
      EXPECT_FALSE(spi::read_token(reader)) << size;
    }
    Reader reader(writer.view(), endian);
    EXPECT_EQ(*spi::read_token(reader), tokens.at(GetParam()));
  }
}

}  // namespace
}  // namespace ddssec::authentication
