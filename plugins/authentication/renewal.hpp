// Takes the documents of local identities that were renewed while they run.
#pragma once

#include "base/documents_in_use.hpp"
#include "base/plugin_services.hpp"
#include "plugins/authentication/identity_table.hpp"

namespace ddssec::authentication {

/// Takes other identity CAs and a renewed certificate of one local identity, or of all (nil), and
/// moves its end. Raises an event for each file that was taken or cannot be used. Call it before
/// the documents in force are used to judge anything.
void renew_identities(IdentityTable& table, spi::IdentityHandle local, TrustStores& stores,
                      const PluginServices& services);

/// Reads the renewal list of one local identity, if it may have changed, and raises the events
/// about it.
void poll_renewal_list(const OwnIdentity& identity, const PluginServices& services);

/// Notes the documents that one local identity uses, or all of them (nil), if the services include
/// a record.
void note_documents(const IdentityTable& table, spi::IdentityHandle local,
                    const PluginServices& services);
/// Removes a local identity that has left from the record.
void forget_documents(spi::IdentityHandle local, const PluginServices& services);

}  // namespace ddssec::authentication
