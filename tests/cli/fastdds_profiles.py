"""Files of Fast DDS profiles, each made from the one that `ddssec init` writes. SECURED says what Fast DDS 2.9.1 takes
from the file (measured): True if the security properties are those of the folder."""

import re

PLAIN = '<participant profile_name="{}" is_default_profile="true"><rtps><name>x</name></rtps></participant>'
TRANSPORT = ("<transport_descriptors><transport_descriptor><transport_id>a</transport_id><type>{}</type>"
             "</transport_descriptor></transport_descriptors>")
LAST = '<property><name>{}</name><value>{}</value></property></properties>'
USE = "<userTransports><transport_id>a</transport_id></userTransports><propertiesPolicy>"


def _row(name, old, new, secured=False, count=0):
    return name, (old, new, count), secured


# What doctor must not call ok; some of them Fast DDS reads as they are meant.
DOUBTFUL = [
    _row("value of a boolean", "<propertiesPolicy>", "<useBuiltinTransports>yes</useBuiltinTransports><propertiesPolicy>"),
    _row("unknown element in rtps", "<propertiesPolicy>", "<bogus/><propertiesPolicy>"),
    _row("domain", "<rtps>", "<domainId>abc</domainId><rtps>"),
    _row("port", "<propertiesPolicy>", "<port><portBase>x</portBase></port><propertiesPolicy>"),
    _row("two policies", "</propertiesPolicy>", "</propertiesPolicy><propertiesPolicy><properties><property><name>a</name>"
                                                "<value>b</value></property></properties></propertiesPolicy>"),
    _row("binary properties", "</properties>", "</properties><binary_properties><bogus/></binary_properties>"),
    _row("binary properties before", "<properties>", "<binary_properties></binary_properties><properties>"),
    _row("user data", "<propertiesPolicy>", "<userData><value>zz</value></userData><propertiesPolicy>"),
    _row("writer", "</profiles>", '<data_writer profile_name="w"><bogus/></data_writer></profiles>'),
    _row("writer before", "<participant ", '<data_writer profile_name="w"><bogus/></data_writer><participant ', count=1),
    _row("kind of a transport", "<participant ", TRANSPORT.format("NOPE") + "<participant ", count=1),
    _row("transport that is not described", "<propertiesPolicy>", USE),
    _row("unknown element in profiles", "<participant ", "<bogus/><participant ", count=1),
    _row("empty value", "</properties>", LAST.format("dds.sec.auth.plugin", "")),
    _row("another plugin last", "</properties>", LAST.format("dds.sec.auth.plugin", "x")),
    _row("other access control last", "</properties>", LAST.format("dds.sec.access.plugin", "x")),
    _row("no name of a profile", ' profile_name="secured"', ""),
    _row("empty name of a profile", ' profile_name="secured"', ' profile_name=""'),
    _row("two profiles of a name", "<participant ", PLAIN.format("secured") + "<participant ", count=1),
    _row("second default profile", "</profiles>", PLAIN.format("b") + "</profiles>"),
    _row("participant without rtps", "</profiles>", '<participant profile_name="b"></participant></profiles>'),
    _row("two rtps", "<rtps>", "<rtps><name>x</name></rtps><rtps>", count=1),
    _row("capital letter", 'is_default_profile="true"', 'is_default_profile="True"'),
    _row("root", r"(</?)profiles", r"\1Profiles"),
    _row("unknown element in dds", r"(<profiles.*</profiles>)", r"<dds><bogus/>\1</dds>"),
    _row("log", r"(<profiles.*</profiles>)", r"<dds><log><bogus/></log>\1</dds>"),
    _row("types", r"(<profiles.*</profiles>)", r"<dds><types><type><bogus/></type></types>\1</dds>"),
    _row("library settings", r"(<profiles.*</profiles>)",
         r"<dds><library_settings><intraprocess_delivery>NOPE</intraprocess_delivery></library_settings>\1</dds>"),
    _row("second rtps after", "</rtps>", "</rtps><rtps><name>x</name></rtps>", secured=True),
    _row("unknown element in participant", "<rtps>", "<bogus/><rtps>", secured=True),
    _row("unknown attribute", "<participant ", '<participant foo="x" ', secured=True),
    _row("the same plugin twice", "</properties>", LAST.format("dds.sec.auth.plugin", "builtin.PKI-DH"), secured=True),
    _row("comment in a value", "<value>builtin.PKI-DH", "<value><!-- x -->builtin.PKI-DH", secured=True),
    _row("unknown element in a property", "<property>", "<property><bogus/>", secured=True, count=1),
]
# What doctor says ok to.
CLEAN = [
    _row("as it was written", "^", ""),
    _row("value before name", r"<name>([^<]*)</name><value>([^<]*)</value>", r"<value>\2</value><name>\1</name>", secured=True),
    _row("other settings", "<propertiesPolicy>", "<useBuiltinTransports>false</useBuiltinTransports>"
                                                 "<port><portBase>7400</portBase></port>" + USE, count=1),
    _row("another participant", "</profiles>", PLAIN.format("b").replace("true", "false") + "</profiles>"),
    _row("qos", "</profiles>", '<data_writer profile_name="w" is_default_profile="true"><qos><reliability><kind>RELIABLE'
                               "</kind></reliability></qos></data_writer></profiles>"),
    _row("below dds", r"(<profiles.*</profiles>)", r"<dds>\1</dds>"),
    _row("comment", "<properties>", "<!-- x --><properties>"),
]


def changed(correct, row):
    name, (old, new, count), _ = row
    text = re.sub(old, new, correct, count=count, flags=re.S)
    if name == "other settings":
        text = text.replace("<participant ", TRANSPORT.format("UDPv4") + "<participant ", 1)
    return text
