// Converts between Cyclone's DataHolder and spi::Token.
#pragma once

#include <span>
#include <vector>

#include "plugins/cyclonedds/abi.hpp"
#include "plugins/spi/token.hpp"

namespace ddssec::cyclonedds {

/// Fills `out` with a copy in which every string and buffer is a separate malloc block, as the
/// host's DataHolder_deinit expects. `out` is overwritten. A value without octets has no buffer.
/// Errors: out_of_memory, text_holds_nul; `out` is nil then.
Status copy_token(const spi::Token& token, DDS_Security_DataHolder& out);

/// Frees a copy of copy_token, wipes binary values (they may be keys), and makes it nil. Memory
/// that was freed before is left alone.
void free_token(DDS_Security_DataHolder& token) noexcept;

/// True for a nil token, which has no class id.
inline bool is_nil(const DDS_Security_DataHolder* token) {
  return token == nullptr || token->class_id == nullptr;
}

/// Copies a token from the host. Errors: null_argument, length_out_of_range
/// (kMaxPropertiesPerToken).
Result<spi::Token> token_from(const DDS_Security_DataHolder* token);

/// As copy_token, for sequences of crypto tokens.
Status copy_tokens(std::span<const spi::Token> tokens, DDS_Security_DataHolderSeq& out);
void free_tokens(DDS_Security_DataHolderSeq& tokens) noexcept;

/// Crypto tokens copied from the host; the keys in them are wiped at destruction.
class CryptoTokens {
 public:
  /// Copies the host's tokens. Errors: null_argument, length_out_of_range (kMaxTokensPerMessage).
  static Result<CryptoTokens> from(const DDS_Security_DataHolderSeq* tokens);
  /// Takes ownership of a plugin's tokens.
  explicit CryptoTokens(std::vector<spi::Token> tokens) : tokens_(std::move(tokens)) {}
  ~CryptoTokens();
  CryptoTokens(CryptoTokens&&) = default;
  CryptoTokens& operator=(CryptoTokens&&) = delete;

  std::span<const spi::Token> view() const { return tokens_; }

 private:
  std::vector<spi::Token> tokens_;
};

/// Returns the token with its binary properties converted to text properties, in their order:
/// Cyclone's access control looks for c.id and c.perm there. Errors: text_holds_nul,
/// length_out_of_range (more than token_from accepts).
Result<spi::Token> with_text_properties(spi::Token token);

/// Fills `out` with a copy in malloc blocks. Errors: out_of_memory, text_holds_nul; `out` is empty
/// then.
Status copy_properties(const spi::PropertyList& list, DDS_Security_PropertySeq& out);
/// Frees a copy of copy_properties and makes it empty.
void free_properties(DDS_Security_PropertySeq& properties) noexcept;

/// Returns the text properties of a QoS; a null QoS has none. Errors: null_argument,
/// length_out_of_range.
Result<spi::PropertyList> properties_from(const DDS_Security_PropertySeq& properties);
Result<spi::PropertyList> properties_from(const DDS_Security_Qos* qos);

}  // namespace ddssec::cyclonedds
