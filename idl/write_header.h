// The door from idlc's C into the generator.
#ifndef DDSSEC_IDL_WRITE_HEADER_H
#define DDSSEC_IDL_WRITE_HEADER_H

#include "idl/nodes.h"

#ifdef __cplusplus
extern "C" {
#endif

// Writes STEM.hpp into `folder` (NULL: the current one). False: idlc was told why not.
bool write_header(const tree_state* state, const char* root, const char* folder);

#ifdef __cplusplus
}
#endif

#endif
