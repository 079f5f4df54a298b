#include "wire/submessage.hpp"

namespace ddssec::rtps {

Result<EntityId> read_entity_id(Reader& reader) {
  return EntityId::from(DDSSEC_TRY(reader.read_bytes(EntityId::size)));
}

Result<GuidPrefix> read_guid_prefix(Reader& reader) {
  return GuidPrefix::from(DDSSEC_TRY(reader.read_bytes(GuidPrefix::size)));
}

Result<Guid> read_guid(Reader& reader) {
  const auto prefix = DDSSEC_TRY(read_guid_prefix(reader));
  return Guid{prefix, DDSSEC_TRY(read_entity_id(reader))};
}

}  // namespace ddssec::rtps
