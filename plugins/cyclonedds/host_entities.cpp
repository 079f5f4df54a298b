#include "plugins/cyclonedds/host_entities.hpp"

#include <array>
#include <dlfcn.h>
#include <memory>
#include <string>
#include <sys/random.h>

#include <dds/dds.h>

#include "plugins/cyclonedds/own_readers.hpp"

namespace ddssec::cyclonedds {
namespace {

// The functions of the host that this file uses.
struct Functions {
  decltype(&dds_get_children) get_children = nullptr;
  decltype(&dds_get_guid) get_guid = nullptr;
  decltype(&dds_create_qos) create_qos = nullptr;
  decltype(&dds_qset_userdata) set_user_data = nullptr;
  decltype(&dds_qset_partition1) set_partition = nullptr;
  decltype(&dds_delete_qos) delete_qos = nullptr;
  decltype(&dds_create_listener) create_listener = nullptr;
  decltype(&dds_delete_listener) delete_listener = nullptr;
  decltype(&dds_lset_data_available) set_data_available = nullptr;
  decltype(&dds_lset_data_on_readers) set_data_on_readers = nullptr;
  decltype(&dds_lset_inconsistent_topic) set_inconsistent_topic = nullptr;
  decltype(&dds_lset_liveliness_changed) set_liveliness_changed = nullptr;
  decltype(&dds_lset_requested_deadline_missed) set_requested_deadline_missed = nullptr;
  decltype(&dds_lset_requested_incompatible_qos) set_requested_incompatible_qos = nullptr;
  decltype(&dds_lset_sample_lost) set_sample_lost = nullptr;
  decltype(&dds_lset_sample_rejected) set_sample_rejected = nullptr;
  decltype(&dds_lset_subscription_matched) set_subscription_matched = nullptr;
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
         find(host.set_partition, code, "dds_qset_partition1") &&
         find(host.delete_qos, code, "dds_delete_qos") &&
         find(host.create_listener, code, "dds_create_listener") &&
         find(host.delete_listener, code, "dds_delete_listener") &&
         find(host.set_data_available, code, "dds_lset_data_available") &&
         find(host.set_data_on_readers, code, "dds_lset_data_on_readers") &&
         find(host.set_inconsistent_topic, code, "dds_lset_inconsistent_topic") &&
         find(host.set_liveliness_changed, code, "dds_lset_liveliness_changed") &&
         find(host.set_requested_deadline_missed, code, "dds_lset_requested_deadline_missed") &&
         find(host.set_requested_incompatible_qos, code, "dds_lset_requested_incompatible_qos") &&
         find(host.set_sample_lost, code, "dds_lset_sample_lost") &&
         find(host.set_sample_rejected, code, "dds_lset_sample_rejected") &&
         find(host.set_subscription_matched, code, "dds_lset_subscription_matched") &&
         find(host.create_topic, code, "dds_create_topic") &&
         find(host.create_reader, code, "dds_create_reader") &&
         find(host.delete_entity, code, "dds_delete");
}

// Returns a type of one octet, because a topic needs a type. No sample is ever written.
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

// Returns the partition's name. It contains a wildcard, so it matches only names without one, and
// no peer can guess it.
std::string partition_of_carrier() {
  std::array<std::uint8_t, 16> random{};
  if (::getrandom(random.data(), random.size(), 0) != static_cast<ssize_t>(random.size()))
    return "*";
  return to_hex(random) + "*";
}

template <class Callback>
struct Nothing;
template <class... Arguments>
struct Nothing<void (*)(Arguments...)> {
  static void call(Arguments...) {}
};
template <class Callback>
void ignore(void (*set)(dds_listener_t*, Callback), dds_listener_t* listener) {
  set(listener, &Nothing<Callback>::call);
}

// Sets listeners that do nothing. Without them, an entity inherits the listener of its participant,
// which knows nothing about carriers.
void ignore_all(const Functions& host, dds_listener_t* listener) {
  ignore(host.set_data_available, listener);
  ignore(host.set_data_on_readers, listener);
  ignore(host.set_inconsistent_topic, listener);
  ignore(host.set_liveliness_changed, listener);
  ignore(host.set_requested_deadline_missed, listener);
  ignore(host.set_requested_incompatible_qos, listener);
  ignore(host.set_sample_lost, listener);
  ignore(host.set_sample_rejected, listener);
  ignore(host.set_subscription_matched, listener);
}

std::vector<dds_entity_t> children_of(decltype(&dds_get_children) get_children,
                                      dds_entity_t entity) {
  std::vector<dds_entity_t> out;
  for (;;) {
    const auto count = get_children(entity, out.data(), out.size());
    if (count <= 0) return {};
    const auto size = static_cast<std::size_t>(count);
    const bool are_all = size <= out.size();
    out.resize(size);
    if (are_all) return out;
  }
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
    const std::string name(kCarrierTopic), partition = partition_of_carrier();
    const std::unique_ptr<dds_listener_t, decltype(&dds_delete_listener)> listener(
        host_.create_listener(nullptr), host_.delete_listener);
    ignore_all(host_, listener.get());
    const OwnedEntity topic(host_, host_.create_topic(participant.handle, &carrier_type(),
                                                      name.c_str(), nullptr, listener.get()));
    if (topic.handle < 0) return false;
    const std::unique_ptr<dds_qos_t, decltype(&dds_delete_qos)> qos(host_.create_qos(),
                                                                    host_.delete_qos);
    const auto octets = ended.octets();
    host_.set_user_data(qos.get(), octets.data(), octets.size());
    host_.set_partition(qos.get(), partition.c_str());
    const OwnedEntity reader(
        host_, host_.create_reader(participant.handle, topic.handle, qos.get(), listener.get()));
    return reader.handle >= 0;
  }

 private:
  struct OwnedEntity {
    OwnedEntity(const Functions& functions, dds_entity_t entity)
        : host(functions), handle(entity) {}
    ~OwnedEntity() {
      if (handle >= 0) host.delete_entity(handle);
    }
    OwnedEntity(const OwnedEntity&) = delete;
    OwnedEntity& operator=(const OwnedEntity&) = delete;
    const Functions& host;
    const dds_entity_t handle;
  };

  std::vector<dds_entity_t> children(dds_entity_t entity) const {
    return children_of(host_.get_children, entity);
  }

  std::optional<Guid> guid_of(dds_entity_t entity) const {
    dds_guid_t octets;
    if (host_.get_guid(entity, &octets) != DDS_RETCODE_OK) return std::nullopt;
    return Guid::from(octets.v);
  }

  // Readers are below subscribers, and nothing is below them.
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

bool may_have_participants(const void* code, std::uint32_t domain_id) noexcept try {
  decltype(&dds_get_children) get_children = nullptr;
  decltype(&dds_get_domainid) get_domain_id = nullptr;
  if (!find(get_children, code, "dds_get_children") ||
      !find(get_domain_id, code, "dds_get_domainid"))
    return true;
  for (const auto domain : children_of(get_children, DDS_CYCLONEDDS_HANDLE)) {
    dds_domainid_t id = 0;
    if (get_domain_id(domain, &id) == DDS_RETCODE_OK && id == domain_id)
      return !children_of(get_children, domain).empty();
  }
  return true;
} catch (...) {
  return true;
}

std::unique_ptr<HostEntities> find_host_entities(const void* code) {
  Functions functions;
  if (!find_all(functions, code)) return nullptr;
  return std::make_unique<Entities>(functions);
}

}  // namespace ddssec::cyclonedds
