# The headers that are installed. Other headers are internal, and an installation does not have them.
# tests/lint/public_headers.py checks both lists and the comments of the first one.

# The API: what an application or the author of a plugin may include. Changes of it stand in CHANGELOG.md.
set(DDSSEC_PUBLIC_HEADERS
  # a secured participant in one call, and the three plugins for a participant made by hand
  secured/security_plugin_set.hpp
  secured/participant.hpp
  # the entities of DDS 1.4, and what their calls take and return
  rtps/dcps/builtin_topics.hpp
  rtps/dcps/condition.hpp
  rtps/dcps/content_filtered_topic.hpp
  rtps/dcps/data_reader.hpp
  rtps/dcps/data_writer.hpp
  rtps/dcps/domain_participant.hpp
  rtps/dcps/domain_participant_factory.hpp
  rtps/dcps/entity.hpp
  rtps/dcps/group.hpp
  rtps/dcps/listener.hpp
  rtps/dcps/loans.hpp
  rtps/dcps/publisher.hpp
  rtps/dcps/sample_access.hpp
  rtps/dcps/states.hpp
  rtps/dcps/status.hpp
  rtps/dcps/subscriber.hpp
  rtps/dcps/topic.hpp
  rtps/dcps/type_support.hpp
  rtps/dcps/wait_set.hpp
  rtps/cdr/type.hpp
  rtps/participant/participant_counters.hpp
  rtps/qos/presets.hpp
  rtps/qos/qos.hpp
  rtps/security/security_counters.hpp
  rtps/security/security_options.hpp
  # the three plugins for another host
  plugins/access_control/access_control.hpp
  plugins/authentication/authentication.hpp
  plugins/cryptography/cryptography.hpp
  # the interfaces that a plugin of another author implements
  plugins/spi/access_control.hpp
  plugins/spi/attributes.hpp
  plugins/spi/authentication.hpp
  plugins/spi/cryptography.hpp
  plugins/spi/handles.hpp
  plugins/spi/match_gate.hpp
  plugins/spi/message_class.hpp
  plugins/spi/pre_shared_key.hpp
  plugins/spi/property_file.hpp
  plugins/spi/property_names.hpp
  plugins/spi/session_facts.hpp
  plugins/spi/shared_secret.hpp
  plugins/spi/symmetric_cipher.hpp
  plugins/spi/token.hpp
  plugins/spi/udp_address.hpp
  # keys, certificates, revocation lists, signed documents
  pki/authority.hpp
  pki/certificate.hpp
  pki/chain.hpp
  pki/crl.hpp
  pki/key_agreement.hpp
  pki/participant_folder.hpp
  pki/private_key.hpp
  pki/signature.hpp
  pki/smime.hpp
  pki/subject_name.hpp
  # results, errors, clocks, events and secrets, which all of them use
  base/bytes.hpp
  base/clock.hpp
  base/code.hpp
  base/plugin_services.hpp
  base/event.hpp
  base/event_log.hpp
  base/hash.hpp
  base/ids.hpp
  base/property.hpp
  base/result.hpp
  base/secret.hpp)

# Internal: installed only because a header above includes them. They change without notice.
set(DDSSEC_CARRIED_HEADERS
  # the codes, of which base/code.hpp makes its enumeration
  base/codes/access_control.def
  base/codes/all.def
  base/codes/authentication.def
  base/codes/base.def
  base/codes/cli.def
  base/codes/cryptography.def
  base/codes/governance.def
  base/codes/host.def
  base/codes/pki.def
  base/codes/rtps.def
  # cursors, and values of documents, that types above have as members or parameters
  base/line_file.hpp
  base/submessage_ids.hpp
  base/protection_kind.hpp
  base/reader.hpp
  base/uri_source.hpp
  base/writer.hpp
  pki/crl_number.hpp
  pki/certificate_source.hpp
  # writers and readers are made for each type where the application is compiled: serialization
  rtps/cdr/cdr_reader.hpp
  rtps/cdr/cdr_writer.hpp
  rtps/cdr/encapsulation.hpp
  rtps/cdr/key_hash.hpp
  rtps/filter/bound_filter.hpp
  rtps/filter/filter.hpp
  rtps/filter/sample_view.hpp
  rtps/reliability/key_payload.hpp
  rtps/types/type_consistency.hpp
  # the members of entities, so that a sample costs no further indirection
  rtps/dcps/arrival_order.hpp
  rtps/dcps/callback_lock.hpp
  rtps/dcps/data_reader_listeners.hpp
  rtps/dcps/data_writer_listeners.hpp
  rtps/dcps/ended_instances.hpp
  rtps/dcps/endpoint.hpp
  rtps/dcps/held_instance.hpp
  rtps/dcps/held_instances.hpp
  rtps/dcps/held_shares.hpp
  rtps/dcps/instance_writers.hpp
  rtps/dcps/key_protection.hpp
  rtps/dcps/link.hpp
  rtps/dcps/liveliness.hpp
  rtps/dcps/offered_liveliness.hpp
  rtps/dcps/participant_context.hpp
  rtps/dcps/presenter.hpp
  rtps/dcps/query_matches.hpp
  rtps/dcps/read_conditions.hpp
  rtps/dcps/reader_cache.hpp
  rtps/dcps/reader_filter.hpp
  rtps/dcps/reader_presentation.hpp
  rtps/dcps/received_samples.hpp
  rtps/dcps/requested_liveliness.hpp
  rtps/dcps/sample_reception.hpp
  rtps/dcps/sample_selection.hpp
  rtps/dcps/seen_originals.hpp
  rtps/dcps/serving_turn.hpp
  rtps/dcps/source_timestamps.hpp
  rtps/dcps/state_counts.hpp
  rtps/dcps/status_changes.hpp
  rtps/dcps/writer_durability.hpp
  rtps/dcps/writer_instances.hpp
  rtps/dcps/writer_lifespan.hpp
  rtps/durability/stored_change.hpp
  rtps/participant/endpoint_listener.hpp
  rtps/participant/liveliness_signal.hpp
  rtps/participant/process_peers.hpp
  rtps/reliability/change.hpp
  rtps/reliability/held_octets.hpp
  rtps/reliability/moment.hpp
  rtps/reliability/payload.hpp
  rtps/reliability/payload_buffer.hpp
  rtps/reliability/timer_queue.hpp
  rtps/reliability/writer_group.hpp
  base/file_descriptor.hpp
  # what discovery announces, which the builtin topics deliver
  rtps/discovery/content_filter_property.hpp
  rtps/discovery/discovery_listener.hpp
  rtps/discovery/endpoint_data.hpp
  rtps/discovery/participant_data.hpp
  rtps/qos/matching.hpp
  # numbers, times and parameters of RTPS, of which changes and announcements consist
  wire/content_filter_info.hpp
  wire/entity_ids.hpp
  wire/inline_qos.hpp
  wire/locator.hpp
  wire/memory_reference.hpp
  wire/numbers.hpp
  wire/time.hpp
  wire/vendor.hpp)
