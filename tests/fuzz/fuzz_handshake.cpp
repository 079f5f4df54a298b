// Any token as any handshake message, and any octets as participant data, are read or refused.
#include "plugins/authentication/auth_request.hpp"
#include "plugins/authentication/handshake_final.hpp"
#include "plugins/authentication/handshake_reply.hpp"
#include "plugins/authentication/handshake_request.hpp"
#include "plugins/authentication/identity_token.hpp"
#include "plugins/authentication/participant_data.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace ddssec;
  using namespace ddssec::authentication;
  const BytesView octets(data, size);
  (void)participant_guid_in(octets);
  Reader reader(octets, Endian::little);
  auto token = spi::read_token(reader);
  if (!token) return 0;
  for (const auto kind : {TokenClass::identity, TokenClass::auth_request, TokenClass::request,
                          TokenClass::reply, TokenClass::final}) {
    token->class_id = std::string(class_id_of(kind));
    (void)read_identity_token(*token);
    (void)read_auth_request(*token);
    if (const auto request = HandshakeRequest::read(*token)) (void)request->verify();
    if (const auto reply = HandshakeReply::read(*token)) (void)reply->verify({});
    if (const auto final = HandshakeFinal::read(*token)) (void) final->verify({});
  }
  return 0;
}
