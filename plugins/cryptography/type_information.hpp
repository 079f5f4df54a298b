// PID_TYPE_INFORMATION (DDS-XTypes 7.6.3.2.2) as Cyclone DDS may get it.
#pragma once

#include <cstdint>

namespace ddssec::cryptography {

/// Reads a TypeInformation (XCDR2, mutable) word by word. Cyclone DDS 0.10.2 ends its process at a
/// top-level type identifier of a kind that it does not expect, and follows nested ones as deep as
/// they go. So only what products announce passes: first `minimal`, then `complete`, each with its
/// hash and with hashes of the same kind that it depends on. Three more forms pass because Cyclone
/// DDS reads no further in them and refuses the announcement alone: either half without a type
/// (TK_NONE), and a size beyond the parameter (Fast DDS 2 writes another encoding, which begins
/// so). Small, to be copied.
class TypeInformationWalk {
 public:
  /// `length` is that of the parameter, a multiple of four.
  void begin(std::uint32_t length);
  /// The next four octets: their value in the order of the list, and the first of them. False: not
  /// a form that may pass.
  bool take(std::uint32_t word, std::uint8_t first);
  /// How many octets are still to come.
  std::uint32_t left() const { return left_; }
  /// After the last one: has all come that was announced?
  bool is_whole() const { return next_ == Next::anything || half_ == kHalves; }

 private:
  /// What the next word is.
  enum class Next : std::uint8_t {
    size,         ///< DHEADER of TypeInformation
    member,       ///< EMHEADER1
    member_size,  ///< NEXTINT, where the header of TypeIdentifierWithDependencies follows
    body_size,    ///< DHEADER of TypeIdentifierWithDependencies
    id_size,      ///< DHEADER of TypeIdentifierWithSize
    kind,         ///< discriminator of TypeIdentifier, and the beginning of its hash
    hash,
    object_size,  ///< typeobject_serialized_size
    count,        ///< dependent_typeid_count
    list_size,    ///< DHEADER of dependent_typeids
    list_length,
    anything,  ///< nothing of it is looked at
  };
  static constexpr std::uint8_t kHalves = 2;

  bool begin_all(std::uint32_t size);
  bool begin_member(std::uint32_t header);
  bool begin_body(std::uint32_t size);
  bool begin_id(std::uint32_t size);
  bool begin_kind(std::uint8_t kind);
  bool end_id();
  bool begin_list(std::uint32_t length);
  void end_half();
  bool step(bool is_right, Next next);

  std::uint32_t left_ = 0;
  std::uint32_t member_size_ = 0;  ///< announced by its header
  std::uint32_t body_left_ = 0;    ///< octets of TypeIdentifierWithDependencies
  std::uint32_t dependents_ = 0;   ///< still to come
  std::uint8_t half_ = 0;          ///< 0: minimal, 1: complete
  std::uint8_t hash_words_ = 0;
  bool is_sized_ = false;  ///< member_size_ came
  bool is_none_ = false;
  bool in_list_ = false;
  Next next_ = Next::size;
};

}  // namespace ddssec::cryptography
