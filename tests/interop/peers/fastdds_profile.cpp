// Prints what Fast DDS reads from the default profiles of this environment and working directory:
// the properties of its default participant, as one NAME=VALUE on each line.
#include <cstdio>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/log/Log.hpp>

int main() {
  using namespace eprosima::fastdds::dds;
  Log::ClearConsumers();
  auto* const factory = DomainParticipantFactory::get_instance();
  factory->load_profiles();
  const auto qos = factory->get_default_participant_qos();
  for (const auto& property : qos.properties().properties())
    std::printf("%s=%s\n", property.name().c_str(), property.value().c_str());
  return 0;
}
