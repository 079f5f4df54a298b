#include "wire/submessage.hpp"

namespace ddssec::rtps {

Result<EntityId> read_entity_id(Reader& reader) {
  DDSSEC_ASSIGN_OR_RETURN(const auto octets, reader.read_bytes(EntityId::size));
  return EntityId::from(octets);
}

Result<GuidPrefix> read_guid_prefix(Reader& reader) {
  DDSSEC_ASSIGN_OR_RETURN(const auto octets, reader.read_bytes(GuidPrefix::size));
  return GuidPrefix::from(octets);
}

Result<Guid> read_guid(Reader& reader) {
  DDSSEC_ASSIGN_OR_RETURN(const auto prefix, read_guid_prefix(reader));
  DDSSEC_ASSIGN_OR_RETURN(const auto entity_id, read_entity_id(reader));
  return Guid{prefix, entity_id};
}

}  // namespace ddssec::rtps
