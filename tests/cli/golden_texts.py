"""The folders of golden_folders.py that differ in what their documents say."""

from workshop import FUTURE, GOVERNANCE, Folder, allow, grant, permissions

FOLDERS = {}


# ---- subjects

def subject(name, text, identity="/C=DE/O=Acme/CN=talker", label="acme"):
    def make(shop, path):
        made = Folder(shop, path, identity, label)
        made.sign("permissions", permissions(grant(text)))
    FOLDERS["subject-" + name] = make


subject("rfc2253", "CN=talker,O=Acme,C=DE")
subject("root-first", "C=DE,O=Acme,CN=talker")
subject("slashes", "/C=DE/O=Acme/CN=talker")
subject("blanks", "CN=talker, O=Acme, C=DE")
subject("mixed-order", "O=Acme,CN=talker,C=DE")
subject("openssl-default", "C = DE, O = Acme, CN = talker")
subject("blanks-at-equals", "CN = talker,O = Acme,C = DE")
subject("cn-only", "CN=talker")
subject("other-case", "cn=talker,o=Acme,c=DE")
subject("value-case", "CN=Talker,O=Acme,C=DE")
subject("misspelt", "CN=talkre", "/CN=talker", "talker")
subject("blank-around", " CN=talker ", "/CN=talker", "talker")
subject("single-blanks-at-equals", "CN = talker", "/CN=talker", "talker")
subject("single-slash", "/CN=talker", "/CN=talker", "talker")
subject("trailing-comma", "CN=talker,", "/CN=talker", "talker")
subject("line-break", "CN=talker\n", "/CN=talker", "talker")


# ---- grants and rules

def grants(which, *texts, **more):
    def make(shop, path):
        made = Folder(shop, path)
        made.sign("permissions", permissions(*(texts or [grant(made.subject, **more)])))
    FOLDERS[which] = make


grants("grant-expired", begin="2020-01-01T00:00:00Z", end="2021-01-01T00:00:00Z")
grants("grant-not-yet-valid", begin=FUTURE)
grants("grant-second", grant("CN=talker", end="2021-01-01T00:00:00Z"), grant("CN=talker"))
grants("grant-twice", grant("CN=talker"), grant("CN=talker", allow("Circle")))
grants("grant-other-domain", rules=allow(domain=7))
grants("grant-default-allow", rules=allow("Circle"), default="ALLOW")
grants("grant-other-topic", rules=allow("Circle"))
grants("grant-without-name", name="")
# The first rule decides about joining: without it ddssec would refuse that already.
JOIN = """<allow_rule>
        <domains><id>0</id></domains>
      </allow_rule>
      """
grants("grant-deny-one-way", rules=JOIN + """<deny_rule>
        <domains><id>0</id></domains>
        <subscribe><topics><topic>Square</topic></topics></subscribe>
      </deny_rule>
      """ + allow())
grants("grant-deny-other-way", rules=JOIN + """<deny_rule>
        <domains><id>0</id></domains>
        <publish><topics><topic>Square</topic></topics></publish>
      </deny_rule>
      """ + allow())
grants("grant-deny-first", rules="""<allow_rule>
        <domains><id>0</id></domains>
        <subscribe><topics><topic>Square</topic></topics></subscribe>
      </allow_rule>
      """ + allow())
grants("grant-bracket-caret", rules=allow("[^T]quare"))
grants("grant-xml-broken", '    <grant name="x">\n')
grants("grant-no-zone", begin="2020-01-01T00:00:00", end="2037-01-01T00:00:00")


def grant_without_default(shop, path):
    made = Folder(shop, path)
    xml = permissions(grant(made.subject)).replace("      <default>DENY</default>\n", "")
    made.sign("permissions", xml)


FOLDERS["grant-without-default"] = grant_without_default


def governance(name, old, new):
    def make(shop, path):
        assert old in GOVERNANCE, old
        Folder(shop, path).sign("governance", GOVERNANCE.replace(old, new))
    FOLDERS["governance-" + name] = make


governance("other-domain", "<id>0</id>", "<id>1</id>")
governance("other-topics", "<topic_expression>*<", "<topic_expression>Circle<")
governance("capitals", "<enable_join_access_control>true<", "<enable_join_access_control>TRUE<")
governance("one-for-true", "<enable_join_access_control>true<", "<enable_join_access_control>1<")
governance("small-letters", "<rtps_protection_kind>SIGN<", "<rtps_protection_kind>sign<")
governance("unknown-kind", "<rtps_protection_kind>SIGN<", "<rtps_protection_kind>SIGNED<")
governance("unauthenticated", "<allow_unauthenticated_participants>false<",
           "<allow_unauthenticated_participants>true<")
# The standard demands this if unauthenticated participants are allowed: nothing protects what everyone may send.
governance("unauthenticated-open", """<allow_unauthenticated_participants>false</allow_unauthenticated_participants>
      <enable_join_access_control>true</enable_join_access_control>
      <discovery_protection_kind>ENCRYPT</discovery_protection_kind>
      <liveliness_protection_kind>ENCRYPT</liveliness_protection_kind>
      <rtps_protection_kind>SIGN""", """<allow_unauthenticated_participants>true</allow_unauthenticated_participants>
      <enable_join_access_control>true</enable_join_access_control>
      <discovery_protection_kind>ENCRYPT</discovery_protection_kind>
      <liveliness_protection_kind>ENCRYPT</liveliness_protection_kind>
      <rtps_protection_kind>NONE""")
governance("no-max", "<id>0</id>", "<id_range><min>0</min></id_range>")
governance("no-min", "<id>0</id>", "<id_range><max>0</max></id_range>")
governance("order", """<enable_read_access_control>true</enable_read_access_control>
          <enable_write_access_control>true</enable_write_access_control>""",
           """<enable_write_access_control>true</enable_write_access_control>
          <enable_read_access_control>true</enable_read_access_control>""")
governance("pre-shared-key", "</rtps_protection_kind>",
           "</rtps_protection_kind>\n      <rtps_psk_protection_kind>ENCRYPT</rtps_psk_protection_kind>")
governance("key-revision", "</enable_join_access_control>",
           "</enable_join_access_control>\n      <enable_key_revision>true</enable_key_revision>")
governance("payload-only", "<metadata_protection_kind>ENCRYPT<", "<metadata_protection_kind>NONE<")


DECLARATION = '<?xml version="1.0" encoding="UTF-8"?>'
governance("escaped-quotes", DECLARATION, DECLARATION.replace('"', '\\"'))
governance("bom", DECLARATION, "\ufeff" + DECLARATION)
governance("default-namespace", "<dds>", '<dds xmlns="http://www.omg.org/spec/DDS-SECURITY">')
governance("doctype", DECLARATION, DECLARATION + '\n<!DOCTYPE dds SYSTEM "governance.dtd">')
governance("processing-instruction", DECLARATION, DECLARATION + '\n<?xml-stylesheet href="governance.xsl"?>')
governance("comment-dashes", "<dds>", "<dds><!-- a -- b -->")
governance("unknown-attribute", "<domain_rule>", '<domain_rule id="lab">')
governance("unknown-element", "<topic_access_rules>", "<remark>lab</remark><topic_access_rules>")
governance("must-interpret", "<domain_rule>", '<domain_rule must_interpret="true">')
governance("end-tag-blank", "</domain_rule>", "</domain_rule >")


def governance_latin_1(shop, path):
    xml = GOVERNANCE.replace(DECLARATION, DECLARATION.replace("UTF-8", "ISO-8859-1"))
    Folder(shop, path).sign("governance", xml.replace("<dds>", "<dds><!-- f\u00fcr alle -->").encode("latin-1"))


FOLDERS["governance-latin-1"] = governance_latin_1


def permissions_text(name, old, new):
    def make(shop, path):
        made = Folder(shop, path)
        xml = permissions(grant(made.subject))
        assert old in xml, old
        made.sign("permissions", xml.replace(old, new))
    FOLDERS["permissions-" + name] = make


permissions_text("bom", DECLARATION, "\ufeff" + DECLARATION)
permissions_text("default-namespace", "<dds>", '<dds xmlns="http://www.omg.org/spec/DDS-SECURITY">')
permissions_text("unknown-attribute", "<permissions>", '<permissions id="lab">')
permissions_text("doctype", DECLARATION, DECLARATION + '\n<!DOCTYPE dds SYSTEM "permissions.dtd">')
permissions_text("end-tag-blank", "</grant>", "</grant\n    >")
permissions_text("domain-tag", "<id>0</id>", "<id>0</id><tag>lab</tag>")
