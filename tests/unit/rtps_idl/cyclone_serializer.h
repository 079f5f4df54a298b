// Cyclone DDS's own reading and writing of the types of rich.idl, in this process.
#ifndef DDSSEC_TEST_CYCLONE_SERIALIZER_H
#define DDSSEC_TEST_CYCLONE_SERIALIZER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

// Returns the type "rich::Everything" and so on. It is the same for each call, and lives as long as
// the process.
struct cyclone_type;
const struct cyclone_type* cyclone_type(const char* name, bool xcdr2);

// Reads a serialized sample, with its encapsulation, and writes it again. Returns the size, or 0 if
// Cyclone DDS refused it.
size_t cyclone_again(const struct cyclone_type* type, const uint8_t* octets, size_t size,
                     uint8_t* out, size_t most, uint8_t key_hash[16]);

#ifdef __cplusplus
}
#endif

#endif
