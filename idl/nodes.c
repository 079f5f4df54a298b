#include "idl/nodes.h"

#include <idlc/generator.h>

static const idlc_generator_config_t* settings;

void tree_begin(const struct idlc_generator_config* config) { settings = config; }

static const struct {
  idl_type_t type;
  enum tree_kind kind;
} kinds[] = {
    {IDL_STRUCT, tree_struct},       {IDL_ENUM, tree_enum},     {IDL_UNION, tree_union},
    {IDL_BITMASK, tree_bitmask},     {IDL_STRING, tree_string}, {IDL_SEQUENCE, tree_sequence},
    {IDL_BOOL, tree_bool},           {IDL_CHAR, tree_char},     {IDL_OCTET, tree_octet},
    {IDL_INT8, tree_int8},           {IDL_UINT8, tree_uint8},   {IDL_SHORT, tree_int16},
    {IDL_INT16, tree_int16},         {IDL_USHORT, tree_uint16}, {IDL_UINT16, tree_uint16},
    {IDL_LONG, tree_int32},          {IDL_INT32, tree_int32},   {IDL_ULONG, tree_uint32},
    {IDL_UINT32, tree_uint32},       {IDL_LLONG, tree_int64},   {IDL_INT64, tree_int64},
    {IDL_ULLONG, tree_uint64},       {IDL_UINT64, tree_uint64}, {IDL_FLOAT, tree_float},
    {IDL_DOUBLE, tree_double},       {IDL_WCHAR, tree_wchar},   {IDL_WSTRING, tree_wstring},
    {IDL_LDOUBLE, tree_long_double}, {IDL_ANY, tree_any},       {IDL_FIXED_PT, tree_fixed}};

static enum tree_kind kind_of_type(idl_type_t type) {
  for (unsigned i = 0; i < sizeof kinds / sizeof kinds[0]; ++i)
    if (kinds[i].type == type) return kinds[i].kind;
  return tree_other;
}

const char* tree_file(const tree_state* state) { return state->sources->path->name; }

const char* tree_included_file(const tree_state* state, unsigned index) {
  const idl_source_t* at = state->sources->includes;
  while (at != NULL && index-- > 0) at = at->next;
  return at != NULL ? at->path->name : NULL;
}

const void* tree_root(const tree_state* state) { return state->root; }

bool tree_is_own(const tree_state* state, const void* node) {
  const idl_source_t* source = idl_location(node)->first.source;
  return source != NULL && source->path == state->sources->path;
}

void tree_error(const tree_state* state, const void* node, const char* text) {
  idl_error(state, node != NULL ? idl_location(node) : NULL, "%s", text);
}

enum tree_kind tree_kind_of(const void* node) {
  if (node == NULL) return tree_other;
  if (idl_is_module(node)) return tree_module;
  if (idl_is_forward(node)) return tree_forward;
  if (idl_is_enumerator(node)) return tree_enumerator;
  if (idl_is_typedef(node)) return tree_typedef;
  if (idl_is_declarator(node)) return tree_alias;
  if (idl_is_const(node)) return tree_const;
  return kind_of_type(idl_type(node));
}

const char* tree_name(const void* node) { return idl_identifier(node); }
const void* tree_next(const void* node) { return idl_next(node); }

const void* tree_module_of(const void* node) {
  const void* at = idl_parent(node);
  while (at != NULL && !idl_is_module(at)) at = idl_parent(at);
  return at;
}

const void* tree_first(const void* node) {
  if (idl_is_module(node)) return ((const idl_module_t*)node)->definitions;
  if (idl_is_struct(node)) return ((const idl_struct_t*)node)->members;
  if (idl_is_member(node)) return ((const idl_member_t*)node)->declarators;
  if (idl_is_enum(node)) return ((const idl_enum_t*)node)->enumerators;
  if (idl_is_typedef(node)) return ((const idl_typedef_t*)node)->declarators;
  return NULL;
}

const void* tree_type(const void* node) {
  if (idl_is_const(node)) return ((const idl_const_t*)node)->type_spec;
  return idl_type_spec(node);
}

const void* tree_definition(const void* node) {
  return idl_is_forward(node) ? ((const idl_forward_t*)node)->type_spec : NULL;
}

uint32_t tree_bound(const void* node) { return idl_is_bounded(node) ? idl_bound(node) : 0; }

uint32_t tree_dimension(const void* name, unsigned index) {
  const idl_literal_t* at = ((const idl_declarator_t*)name)->const_expr;
  while (at != NULL && index-- > 0) at = idl_next(at);
  return at != NULL ? at->value.uint32 : 0;
}

static unsigned flags_of_struct(const idl_struct_t* node) {
  unsigned flags = 0;
  if (node->extensibility.value == IDL_APPENDABLE) flags |= tree_appendable;
  if (node->extensibility.value == IDL_MUTABLE) flags |= tree_mutable;
  if (node->inherit_spec != NULL) flags |= tree_inherits;
  if (node->keylist != NULL) flags |= tree_keylist;
  if (node->autoid.value == IDL_HASH) flags |= tree_hashed_ids;
  if (node->data_representation.annotation != NULL) flags |= tree_representation;
  return flags;
}

unsigned tree_flags(const void* node) {
  if (idl_is_struct(node)) return flags_of_struct(node);
  if (idl_is_declarator(node))
    return ((const idl_declarator_t*)node)->id.annotation != NULL ? tree_own_id : 0;
  if (!idl_is_member(node)) return 0;
  const idl_member_t* member = node;
  return (member->key.value ? tree_key : 0u) | (member->optional.value ? tree_optional : 0u) |
         (member->external.value ? tree_external : 0u);
}

unsigned tree_bit_bound(const void* node) {
  const idl_enum_t* which = node;
  return which->bit_bound.annotation != NULL ? which->bit_bound.value : 0;
}

const void* tree_value(const void* node) {
  if (idl_is_member(node)) return ((const idl_member_t*)node)->value.value;
  if (idl_is_const(node)) return ((const idl_const_t*)node)->const_expr;
  if (!idl_is_enum(node)) return NULL;
  const idl_enum_t* which = node;
  return which->default_enumerator != NULL ? which->default_enumerator : which->enumerators;
}

bool tree_type_description(const tree_state* state, const void* node, uint8_t* octets[2],
                           size_t sizes[2]) {
  idl_typeinfo_typemap_t out = {0};
  if (settings->generate_typeinfo_typemap == NULL || !idl_is_topic(node, state->keylists) ||
      settings->generate_typeinfo_typemap(state, node, &out) != IDL_RETCODE_OK)
    return false;
  octets[0] = out.typeinfo;
  sizes[0] = out.typeinfo_size;
  octets[1] = out.typemap;
  sizes[1] = out.typemap_size;
  return true;
}

int64_t tree_integer(const void* value) {
  if (idl_is_enumerator(value)) return (int32_t)((const idl_enumerator_t*)value)->value.value;
  const idl_literal_t* literal = value;
  switch (kind_of_type(idl_type(value))) {
    case tree_bool:
      return literal->value.bln;
    case tree_char:
      return literal->value.chr;
    case tree_int8:
      return literal->value.int8;
    case tree_octet:
    case tree_uint8:
      return literal->value.uint8;
    case tree_int16:
      return literal->value.int16;
    case tree_uint16:
      return literal->value.uint16;
    case tree_int32:
      return literal->value.int32;
    case tree_uint32:
      return literal->value.uint32;
    case tree_int64:
      return literal->value.int64;
    case tree_uint64:
      return (int64_t)literal->value.uint64;
    default:
      return 0;
  }
}

double tree_real(const void* value) {
  const idl_literal_t* literal = value;
  return idl_type(value) == IDL_FLOAT ? (double)literal->value.flt : literal->value.dbl;
}

const char* tree_text(const void* value) { return ((const idl_literal_t*)value)->value.str; }
