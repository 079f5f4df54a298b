// The parsed IDL as C++ may see it: idlc's own headers are C alone. A node is whatever idlc made of
// a declaration, a type or a value; functions answer 0 or NULL where a node has no such thing.
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

// idlc's settings for the file; before anything else.
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

// Of a structure or a member.
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

// The file that is compiled, and those it includes.
const char* tree_file(const tree_state* state);
const char* tree_included_file(const tree_state* state, unsigned index);
const void* tree_root(const tree_state* state);
// True if the node stands in the file itself, not in an included one.
bool tree_is_own(const tree_state* state, const void* node);
// "FILE:LINE:COLUMN: error: TEXT"; without a node no place is named.
void tree_error(const tree_state* state, const void* node, const char* text);

enum tree_kind tree_kind_of(const void* node);
const char* tree_name(const void* node);
const void* tree_next(const void* node);
// The module around it.
const void* tree_module_of(const void* node);
// The first definition, member, enumerator or name within it.
const void* tree_first(const void* node);
// Of a member, a sequence, a typedef's name or a constant.
const void* tree_type(const void* node);
// Of a forward declaration; NULL if it has none.
const void* tree_definition(const void* node);
// Of a string or a sequence; 0: any number.
uint32_t tree_bound(const void* node);
// Of a member's or a typedef's name; 0: there are no more.
uint32_t tree_dimension(const void* name, unsigned index);
unsigned tree_flags(const void* node);
// Of an enumeration; 0: not said.
unsigned tree_bit_bound(const void* node);
// What a member, a constant or an enumeration is without being told.
const void* tree_value(const void* node);

// What XTypes says of a struct that may be a topic's type, as Cyclone DDS announces it: the
// serialized TypeInformation, and TypeMapping. False: idlc has none. The caller frees both.
bool tree_type_description(const tree_state* state, const void* node, uint8_t* octets[2],
                           size_t sizes[2]);

// Of an enumerator or an integer, a character, a boolean.
int64_t tree_integer(const void* value);
double tree_real(const void* value);
const char* tree_text(const void* value);

#ifdef __cplusplus
}
#endif

#endif
