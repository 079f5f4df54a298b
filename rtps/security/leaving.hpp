// A participant that leaves says so on the volatile secure channel, which the keys of its pair of
// participants protect under every governance. DCPSParticipantsSecure is protected only where
// discovery or messages are. DDS-Security defines no such message: participants of other vendors
// ignore it.
#pragma once

#include "rtps/security/crypto_token_exchange.hpp"

namespace ddssec::rtps {

/// Reports to all joined ddssec peers that the local participant leaves. The messages are collected
/// in the sender.
void announce_leaving(SecurityCore& core, CryptoTokenExchange& exchange);

/// From now on, reports peers that leave to the host (SecurityHost::on_ended).
void listen_for_leaving(SecurityCore& core, CryptoTokenExchange& exchange);

}  // namespace ddssec::rtps
