// Adapts spi::Cryptography to Cyclone's dds_security_cryptography.
#pragma once

#include "plugins/cyclonedds/adapter_calls.hpp"
#include "plugins/cyclonedds/opened_message.hpp"
#include "plugins/cyclonedds/reader_ends.hpp"
#include "plugins/spi/cryptography.hpp"

namespace ddssec::cyclonedds {

/// The C struct is the base class. The host sees only that and its three sub-tables, which point
/// back to the adapter. There is one adapter for each domain. Every call of the host comes in
/// through `of`. That function clears the thread's OpenedMessage, because the host no longer works
/// on that message.
class CryptographyAdapter final : public dds_security_cryptography {
 public:
  CryptographyAdapter(std::unique_ptr<Host> host, const MakePlugin<spi::Cryptography>& make,
                      ddsi_domaingv* domain);
  ~CryptographyAdapter();
  CryptographyAdapter(const CryptographyAdapter&) = delete;
  CryptographyAdapter& operator=(const CryptographyAdapter&) = delete;

  static CryptographyAdapter& of(dds_security_crypto_key_factory& instance) {
    return entered(*static_cast<Table<dds_security_crypto_key_factory>&>(instance).owner);
  }
  static CryptographyAdapter& of(dds_security_crypto_key_exchange& instance) {
    return entered(*static_cast<Table<dds_security_crypto_key_exchange>&>(instance).owner);
  }
  static CryptographyAdapter& of(dds_security_crypto_transform& instance) {
    return entered(*static_cast<Table<dds_security_crypto_transform>&>(instance).owner);
  }

  /// Calls spi::CryptoKeyFactory::poll_stranded_keys for all domains of the process.
  static bool poll_stranded_keys(spi::IdentityHandle remote);

  /// Cuts off a local participant of any domain (process_questions.hpp).
  static void cut_off(spi::IdentityHandle local);

  /// Looks for ended readers in all domains of the process (reader_ends.hpp).
  static void look_for_ended_readers() noexcept;

  Host& host() { return *host_; }
  spi::CryptoKeyFactory& key_factory() { return key_factory_; }
  spi::CryptoKeyExchange& key_exchange() { return key_exchange_; }
  spi::CryptoTransform& transform() { return transform_; }
  /// Remembers the identity of a local participant until the host unregisters it.
  void note_local(spi::ParticipantCryptoHandle local, spi::IdentityHandle identity);
  void forget_local(spi::ParticipantCryptoHandle local);
  OwnReaders& own_readers() { return reader_ends_.readers(); }

 private:
  static CryptographyAdapter& entered(CryptographyAdapter& adapter) {
    OpenedMessage::of_this_thread().forget();
    return adapter;
  }

  template <class CTable>
  struct Table : CTable {
    Table(const CTable& functions, CryptographyAdapter* adapter)
        : CTable(functions), owner(adapter) {}
    CryptographyAdapter* owner;
  };

  std::unique_ptr<Host> host_;
  std::unique_ptr<spi::Cryptography> plugin_;
  spi::CryptoKeyFactory& key_factory_;
  spi::CryptoKeyExchange& key_exchange_;
  spi::CryptoTransform& transform_;
  Table<dds_security_crypto_transform> transform_table_;
  Table<dds_security_crypto_key_factory> key_factory_table_;
  Table<dds_security_crypto_key_exchange> key_exchange_table_;
  std::mutex locals_mutex_;
  std::map<spi::ParticipantCryptoHandle, spi::IdentityHandle> locals_ = {};
  ReaderEnds reader_ends_;
};

/// The functions of each sub-table.
extern const dds_security_crypto_key_factory kKeyFactoryFunctions;
extern const dds_security_crypto_key_exchange kKeyExchangeFunctions;
extern const dds_security_crypto_transform kTransformFunctions;

}  // namespace ddssec::cyclonedds
