#include "cli/explain/explain_examples.hpp"

namespace ddssec::cli {
namespace {

constexpr ExplainExample kExamples[] = {
    // Examples about files and their places.
    {"openssl_known_unsafe", "ddssec version"},
    {"openssl_known_unsafe", "sudo apt install --only-upgrade libssl3"},
    {"DOC001 DOC002 file_not_found file_unreadable DOC090", "ddssec doctor demo/talker"},
    {"DOC001 file_not_found would_overwrite",
     "ddssec identity issue talker --ca demo -o demo/talker --governance demo/governance.p7s"},
    {"would_overwrite", "ddssec identity issue talker --ca demo -o demo/talker --replace"},
    {"DOC003 key_readable_by_others", "chmod 600 demo/talker/key.pem"},
    {"DOC004", "rm demo/talker/ca.key.pem"},
    {"usage", "ddssec identity issue --help"},
    {"outlives_ca", "ddssec identity issue talker --ca demo -o demo/talker --days 5000 --clamp"},
    {"passphrase_needed", "ddssec crl new --ca demo --passphrase-file passphrase.txt"},
    {"passphrase_readable_by_others", "chmod 600 passphrase.txt"},
    {"name_unusable",
     "ddssec identity issue talker --ca demo -o demo/talker --subject 'CN=Talker of hall 2'"},
    {"confirmation_needed", "ddssec identity sign-csr device/request.pem --ca demo --yes"},
    // Examples about keys and certificates.
    {"DOC012 key_mismatch", "ddssec identity issue talker --ca demo -o demo/talker --replace"},
    {"DOC013 passphrase_missing passphrase_wrong",
     "openssl pkey -in demo/talker/key.pem -out plain.pem"},
    {"passphrase_missing passphrase_wrong",
     "<PrivateKey>file:demo/talker/key.pem</PrivateKey><Password>PASSPHRASE</Password>"},
    {"DOC021 certificate_expired grant_expired DOC040",
     "ddssec identity renew demo/talker --ca demo --permissions"},
    {"certificate_expired certificate_not_yet_valid DOC041 DOC022",
     "ddssec expiry demo --within 30d"},
    {"certificate_not_yet_valid", "date --utc"},
    {"DOC022", "ddssec ca renew demo --role identity"},
    {"DOC020 DOC080 issuer_unknown", "ddssec identity show demo/talker"},
    {"DOC080 issuer_unknown", "ddssec ca show demo"},
    {"DOC024 certificate_revoked", "ddssec crl show demo/talker"},
    {"DOC024 certificate_revoked DOC080",
     "ddssec identity issue talker --ca demo -o demo/talker2 --publish rt/chatter "
     "--governance demo/governance.p7s"},
    {"DOC023 crl_expired crl_missing no_revocation_list crl_incomplete",
     "ddssec crl new --ca demo"},
    {"DOC023 crl_expired crl_missing no_revocation_list", "ddssec crl distribute --ca demo"},
    {"ocsp_no_responder DOC112 DOC113 ocsp_status_missing ocsp_expired ocsp_other_certificate "
     "ocsp_response_ended ocsp_response_refused ocsp_fetch_failed",
     "ddssec identity ocsp demo/talker --url http://ca.example:2560/"},
    {"ocsp_malformed ocsp_signer_wrong ocsp_unknown ocsp_not_yet_valid",
     "openssl ocsp -respin demo/talker/ocsp.der -noverify -resp_text"},
    {"pkcs11_pin_missing",
     "ddssec identity csr talker -o talker --key "
     "'pkcs11:token=robot;object=talker?pin-source=file:/etc/robot/pin'"},
    // Examples about documents.
    {"DOC030 smime_not_multipart DOC031 smime_signature_invalid smime_message_digest DOC032 DOC082 "
     "DOC084",
     "ddssec governance sign demo/governance.xml --ca demo -o governance.p7s"},
    {"DOC030 smime_not_multipart DOC031 smime_signature_invalid smime_message_digest DOC032 DOC081 "
     "smime_signer_not_permissions_ca",
     "ddssec permissions sign permissions.xml --ca demo -o permissions.p7s"},
    {"DOC032 smime_signer_not_permissions_ca",
     "ddssec permissions verify demo/talker/permissions.p7s --ca demo/talker/permissions_ca.pem"},
    {"DOC036 DOC037 xml_not_well_formed element_missing element_unknown",
     "ddssec governance lint demo/governance.xml"},
    {"DOC036 DOC037 xml_not_well_formed element_missing element_unknown",
     "ddssec permissions lint demo/talker/permissions.p7s"},
    {"DOC010 DOC011 no_grant_for_subject subject_name_malformed PERM011",
     "ddssec identity show demo/talker"},
    {"DOC010 DOC011 no_grant_for_subject PERM011", "<subject_name>CN=talker</subject_name>"},
    {"publish_not_allowed topic_not_allowed subscribe_not_allowed DOC086",
     "ddssec permissions show demo/talker   # all of its topics"},
    {"DOC010 no_grant_for_subject DOC040 grant_expired publish_not_allowed topic_not_allowed "
     "DOC086",
     "ddssec permissions new --cert demo/talker/cert.pem --publish rt/chatter --subscribe rt/clock "
     "--partition '*' --sign --ca demo -o demo/talker/permissions.xml --replace   # name all of "
     "its "
     "topics: the rest is denied"},
    {"subscribe_not_allowed",
     "ddssec permissions new --cert demo/talker/cert.pem --publish rt/clock --subscribe rt/chatter "
     "--partition '*' --sign --ca demo -o demo/talker/permissions.xml --replace   # name all of "
     "its "
     "topics: the rest is denied"},
    {"publish_not_allowed topic_not_allowed DOC086",
     "ddssec can demo/talker publish rt/chatter --domain 0"},
    {"subscribe_not_allowed", "ddssec can demo/talker subscribe rt/chatter --domain 0"},
    {"subscribe_not_allowed",
     "<subscribe><topics><topic>rt/chatter</topic></topics>"
     "<partitions><partition>*</partition></partitions></subscribe>"},
    {"publish_not_allowed DOC086",
     "<publish><topics><topic>rt/chatter</topic></topics>"
     "<partitions><partition>*</partition></partitions></publish>"},
    {"DOC050 domain_not_covered GOV003", "<domains><id>0</id></domains>"},
    {"DOC050 domain_not_covered GOV003 DOC088 participant_not_allowed DOC051",
     "ddssec init other --domain 7"},
    {"DOC054 topic_not_covered GOV011",
     "ddssec governance show demo/governance.xml --topic rt/chatter"},
    {"GOV006 PERM006", "ddssec governance new --profile strict --sign --ca demo -o governance.xml"},
    {"DOC082 DOC084", "ddssec governance diff demo/talker/governance.p7s governance.xml"},
    {"DOC082 DOC084 CAP004", "cp demo/talker/governance.p7s demo/listener/governance.p7s"},
    {"DOC085 GOV031", "<metadata_protection_kind>ENCRYPT</metadata_protection_kind>"},
    // Examples about two participants that should communicate.
    {"DOC080 DOC081 DOC082 DOC084 DOC085 DOC086 DOC087 DOC088 CAP001 CAP002 CAP003 CAP004 CAP011 "
     "CAP013",
     "ddssec check demo/talker demo/listener --topics rt/chatter"},
    {"DOC083 DOC094 CAP014",
     "ddssec check demo/talker demo/listener --vendor A=cyclonedds --vendor B=fastdds"},
    {"DOC083 DOC089",
     "ddssec identity issue talker2 --ca demo -o demo/talker2 --publish rt/chatter "
     "--governance demo/governance.p7s"},
    {"DOC087 CAP001", "export CYCLONEDDS_URI=file://$PWD/demo/talker/cyclonedds.xml"},
    {"DOC091 DOC092", "dds.sec.crypto.rtps_psk_secret_passphrase = file:demo/domain.psk"},
    {"DOC098 DOC095", "ddssec doctor demo/talker --vendor cyclonedds@0.10.5 --domain 7"},
    {"capture_unreadable", "ddssec inspect --listen lo --for 8"},
    {"rtps_qos_incompatible", "qos.deadline = Duration::from(std::chrono::milliseconds(100));"},
    // Examples about ROS 2.
    {"DOC060", "export ROS_SECURITY_ENABLE=true"},
    {"DOC061", "export ROS_SECURITY_STRATEGY=Enforce"},
    {"DOC062 DOC063", "ddssec keystore list keystore"},
    {"DOC063 keystore_incomplete", "ddssec keystore create keystore --no-passphrase"},
    {"DOC064 DOC066 PERM032 PERM033 PERM040 topic_not_allowed publish_not_allowed "
     "subscribe_not_allowed DOC086 DOC010 DOC031",
     "ddssec keystore permission keystore /talker --policy policy.xml --node-defaults"},
    {"DOC065 GOV013 PERM034 PERM035", "rt/chatter is the topic /chatter of ROS 2"},
    {"DOC006", "ddssec keystore enclave keystore /talker --policy policy.xml --node-defaults"},
    {"CAP005", "export ROS_DOMAIN_ID=0"},
    {"DOC067", "export RMW_IMPLEMENTATION=rmw_cyclonedds_cpp"},
    {"DOC096", "export ROS_DOMAIN_ID=7"},
    {"enclave_name_unusable", "ddssec keystore enclave keystore /robot/camera"},
};

}  // namespace

std::span<const ExplainExample> explain_examples() { return kExamples; }

}  // namespace ddssec::cli
