// The parsed IDL, for use from C++: idlc's own headers are C only. A node is what idlc created for
// a declaration, a type or a value. Functions return 0 or NULL if a node does not have the
// requested property.
#ifndef DDSSEC_IDL_NODES_H
#define DDSSEC_IDL_NODES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

struct idl_pstate;
typedef struct idl_pstate tree_state;

// Sets idlc's settings for the file. Must be called before all others.
struct idlc_generator_config;
void tree_begin(const struct idlc_generator_config* config);

enum tree_kind {
  tree_other,
  tree_module,
  tree_forward,
  tree_struct,
  tree_enum,
  tree_enumerator,
  tree_typedef,
  tree_alias,  // one name of a typedef
  tree_const,
  tree_union,
  tree_bitmask,
  tree_string,
  tree_sequence,
  tree_bool,
  tree_char,
  tree_octet,
  tree_int8,
  tree_uint8,
  tree_int16,
  tree_uint16,
  tree_int32,
  tree_uint32,
  tree_int64,
  tree_uint64,
  tree_float,
  tree_double,
  tree_wchar,
  tree_wstring,
  tree_long_double,
  tree_any,
  tree_fixed
};

// Flags of a structure or a member.
enum tree_flag {
  tree_appendable = 1,
  tree_mutable = 2,
  tree_inherits = 4,
  tree_keylist = 8,
  tree_hashed_ids = 16,
  tree_key = 32,
  tree_optional = 64,
  tree_external = 128,
  tree_own_id = 256,
  tree_representation = 512
};

// The file that is compiled, and the files that it includes.
const char* tree_file(const tree_state* state);
const char* tree_included_file(const tree_state* state, unsigned index);
const void* tree_root(const tree_state* state);
// True if the node is in the file itself, not in an included one.
bool tree_is_own(const tree_state* state, const void* node);
// Prints "FILE:LINE:COLUMN: error: TEXT"; without a node no position is given.
void tree_error(const tree_state* state, const void* node, const char* text);

enum tree_kind tree_kind_of(const void* node);
const char* tree_name(const void* node);
const void* tree_next(const void* node);
// The module that contains the node.
const void* tree_module_of(const void* node);
// The first definition, member, enumerator or name in the node.
const void* tree_first(const void* node);
// The type of a member, a sequence, a typedef's name or a constant.
const void* tree_type(const void* node);
// The definition of a forward declaration; NULL if there is none.
const void* tree_definition(const void* node);
// The bound of a string or a sequence; 0: unlimited.
uint32_t tree_bound(const void* node);
// The array dimension of a member's or a typedef's name; 0: there are no more.
uint32_t tree_dimension(const void* name, unsigned index);
unsigned tree_flags(const void* node);
// The bit bound of an enumeration; 0: not specified.
unsigned tree_bit_bound(const void* node);
// The default value of a member or an enumeration, or the value of a constant.
const void* tree_value(const void* node);

// The XTypes description of a struct that may be a topic's type, as Cyclone DDS announces it: the
// serialized TypeInformation, and TypeMapping. Returns false if idlc has none. The caller must free
// both.
bool tree_type_description(const tree_state* state, const void* node, uint8_t* octets[2],
                           size_t sizes[2]);

// The value of an enumerator, an integer, a character or a boolean.
int64_t tree_integer(const void* value);
double tree_real(const void* value);
const char* tree_text(const void* value);

#ifdef __cplusplus
}
#endif

#endif
