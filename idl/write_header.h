// The interface from idlc's C code to the generator.
#ifndef DDSSEC_IDL_WRITE_HEADER_H
#define DDSSEC_IDL_WRITE_HEADER_H

#include "idl/nodes.h"

#ifdef __cplusplus
extern "C" {
#endif

// Writes STEM.hpp into `folder` (NULL: the current folder). Returns false if it failed; the reason
// was reported to idlc.
bool write_header(const tree_state* state, const char* root, const char* folder);

#ifdef __cplusplus
}
#endif

#endif
