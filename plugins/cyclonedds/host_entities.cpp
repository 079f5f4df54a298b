#include "plugins/cyclonedds/host_entities.hpp"

#include <dlfcn.h>
#include <memory>
#include <string>

#include <dds/dds.h>

#include "plugins/cyclonedds/own_readers.hpp"

namespace ddssec::cyclonedds {
namespace {

/// The functions of the host that are used.
struct Functions {
  decltype(&dds_get_children) get_children = nullptr;
  decltype(&dds_get_guid) get_guid = nullptr;
  decltype(&dds_create_qos) create_qos = nullptr;
  decltype(&dds_qset_userdata) set_user_data = nullptr;
  decltype(&dds_delete_qos) delete_qos = nullptr;
  decltype(&dds_create_topic) create_topic = nullptr;
  decltype(&dds_create_reader) create_reader = nullptr;
  decltype(&dds_delete) delete_entity = nullptr;
};

template <class Function>
bool find(Function& function, const void* code, const char* name) {
  function = reinterpret_cast<Function>(find_host_symbol(code, name));
  return function != nullptr;
}

bool find_all(Functions& host, const void* code) {
  return find(host.get_children, code, "dds_get_children") &&
         find(host.get_guid, code, "dds_get_guid") &&
         find(host.create_qos, code, "dds_create_qos") &&
         find(host.set_user_data, code, "dds_qset_userdata") &&
         find(host.delete_qos, code, "dds_delete_qos") &&
         find(host.create_topic, code, "dds_create_topic") &&
         find(host.create_reader, code, "dds_create_reader") &&
         find(host.delete_entity, code, "dds_delete");
}

/// A type of one octet, because a topic needs a type. No sample is ever written.
const dds_topic_descriptor_t& carrier_type() {
  static constexpr std::uint32_t kOperations[] = {
      static_cast<std::uint32_t>(DDS_OP_ADR) | static_cast<std::uint32_t>(DDS_OP_TYPE_1BY), 0,
      static_cast<std::uint32_t>(DDS_OP_RTS)};
  static const dds_topic_descriptor_t type = {.m_size = 1,
                                              .m_align = 1,
                                              .m_flagset = 0,
                                              .m_nkeys = 0,
                                              .m_typename = "ddssec::EndOfReader",
                                              .m_keys = nullptr,
                                              .m_nops = 2,
                                              .m_ops = kOperations,
                                              .m_meta = "",
                                              .type_information = {},
                                              .type_mapping = {},
                                              .restrict_data_representation = 0};
  return type;
}

class Entities final : public HostEntities {
 public:
  explicit Entities(const Functions& host) : host_(host) {}

  std::vector<Participant> participants() const override {
    std::vector<Participant> out;
    for (const auto domain : children(DDS_CYCLONEDDS_HANDLE)) {
      for (const auto handle : children(domain)) {
        const auto guid = guid_of(handle);
        if (!guid) continue;
        auto& participant = out.emplace_back(Participant{.handle = handle, .guid = *guid});
        add_below(handle, participant.entities);
      }
    }
    return out;
  }

  bool carry_end(const Participant& participant, const Guid& ended) const override {
    const std::string name(kCarrierTopic);
    const Owned topic(host_, host_.create_topic(participant.handle, &carrier_type(), name.c_str(),
                                                nullptr, nullptr));
    if (topic.handle < 0) return false;
    const std::unique_ptr<dds_qos_t, decltype(&dds_delete_qos)> qos(host_.create_qos(),
                                                                    host_.delete_qos);
    const auto octets = ended.octets();
    host_.set_user_data(qos.get(), octets.data(), octets.size());
    const Owned reader(host_,
                       host_.create_reader(participant.handle, topic.handle, qos.get(), nullptr));
    return reader.handle >= 0;
  }

 private:
  struct Owned {
    Owned(const Functions& functions, dds_entity_t entity) : host(functions), handle(entity) {}
    ~Owned() {
      if (handle >= 0) host.delete_entity(handle);
    }
    Owned(const Owned&) = delete;
    Owned& operator=(const Owned&) = delete;
    const Functions& host;
    const dds_entity_t handle;
  };

  std::vector<dds_entity_t> children(dds_entity_t entity) const {
    std::vector<dds_entity_t> out;
    for (;;) {
      const auto count = host_.get_children(entity, out.data(), out.size());
      if (count <= 0) return {};
      const auto size = static_cast<std::size_t>(count);
      const bool are_all = size <= out.size();
      out.resize(size);
      if (are_all) return out;
    }
  }

  std::optional<Guid> guid_of(dds_entity_t entity) const {
    dds_guid_t octets;
    if (host_.get_guid(entity, &octets) != DDS_RETCODE_OK) return std::nullopt;
    return Guid::from(octets.v);
  }

  /// Readers are below subscribers, and nothing is below them.
  void add_below(dds_entity_t entity, std::set<Guid>& out) const {
    for (const auto child : children(entity)) {
      if (const auto guid = guid_of(child)) out.insert(*guid);
      add_below(child, out);
    }
  }

  const Functions host_;
};

}  // namespace

void* find_host_symbol(const void* code, const char* name) noexcept {
  Dl_info host{};
  if (code != nullptr && dladdr(code, &host) != 0 && host.dli_fname != nullptr) {
    // The library is already loaded, so this only increases its reference count.
    if (void* library = dlopen(host.dli_fname, RTLD_LAZY | RTLD_NOLOAD)) {
      void* symbol = dlsym(library, name);
      dlclose(library);
      if (symbol != nullptr) return symbol;
    }
  }
  return dlsym(RTLD_DEFAULT, name);
}

std::unique_ptr<HostEntities> find_host_entities(const void* code) {
  Functions functions;
  if (!find_all(functions, code)) return nullptr;
  return std::make_unique<Entities>(functions);
}

}  // namespace ddssec::cyclonedds
