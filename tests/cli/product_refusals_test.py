#!/usr/bin/env python3
"""Folders of which doctor and check must say what Cyclone DDS 0.10.2 and Fast DDS 2.9.1 make of them, where these differ
from ddssec. Each was measured with pairs of the products themselves."""

import os
import shutil
import subprocess

from transcript import WithoutLists, main
from workshop import GOVERNANCE, Folder, Workshop, allow, grant, openssl, permissions

ALL = {"cyclonedds@0.10.2": "ok", "fastdds@2.9.1": "ok", "ddssec": "ok"}


class ProductRefusals(WithoutLists):
    def setUp(self):
        super().setUp()
        self.shop = Workshop(self.at / "shop")
        self.folders = [Folder(self.shop, self.at / name, f"/CN={name}", name) for name in ("talker", "partner")]
        self.talker = self.folders[0]

    def doctor(self, rule=None, folder="talker"):
        """The verdicts, and the messages of a rule."""
        out = self.json("doctor", folder, exit=None)
        return out["result"]["verdicts"], [one["message"] for one in out["diagnostics"] if one["id"] == rule]

    def talk(self, product, exit=0):
        """How check ends for both on the product."""
        self.run_program("check", "talker", "partner", "--topics", "Square", "--vendor", product, exit=exit)


class EmptyDocuments(ProductRefusals):
    # Cyclone DDS says that it cannot parse it; Fast DDS ends the process.
    def test_signed_document_without_content_every_product_fails(self):
        for name in ("permissions", "governance"):
            folder = Folder(self.shop, self.at / f"empty-{name}", f"/CN={name}", name)
            for form in (("-text",), ("-text", "-nodetach")):
                folder.sign(name, "", form=form)
                verdicts, told = self.doctor("DOC036", f"empty-{name}")
                self.assertEqual(verdicts, dict.fromkeys(ALL, "fail"), form)
                self.assertIn(f"{name}.p7s: the signed document is empty", told[0])


class Names(ProductRefusals):
    # openssl takes the command line for ISO 8859-1.
    LATIN_1 = os.fsdecode("/O=Müller/CN=café".encode("latin-1"))

    def with_name(self, *spellings):
        shutil.rmtree(self.at / "cafe", ignore_errors=True)
        folder = Folder(self.shop, self.at / "cafe", self.LATIN_1, "cafe")
        folder.sign("permissions", permissions(*(grant(one) for one in spellings)))
        return self.doctor("DOC011", "cafe")

    def test_letters_beyond_ascii_each_product_reads_a_text_of_its_own(self):
        escaped, plain = "CN=caf\\C3\\A9,O=M\\C3\\BCller", "CN=café,O=Müller"
        verdicts, told = self.with_name(escaped)
        self.assertEqual(verdicts, {**ALL, "fastdds@2.9.1": "fail"})
        self.assertIn(f'it must say "{escaped}" for Cyclone DDS 0.10.2 and "{plain}" for Fast DDS 2.9.1', told[0])
        self.assertEqual(self.with_name(plain)[0], {**ALL, "cyclonedds@0.10.2": "fail"})
        self.assertEqual(self.with_name(escaped, plain), (ALL, []))


class PermissionsCas(ProductRefusals):
    def test_another_first_ca_fast_dds_refuses_the_peer(self):
        own, foreign = ((self.shop.ca(one) / "cert.pem").read_bytes() for one in ("permissions", "foreign"))
        for content, exit in ((own + foreign, 0), (foreign + own, 1)):
            (self.talker.path / "permissions_ca.pem").write_bytes(content)
            self.talk("fastdds", exit)
        told = self.json("check", "talker", "partner", "--vendor", "fastdds", exit=1)["diagnostics"]
        told = [one["message"] for one in told if one["id"] == "DOC081"]
        self.assertEqual(len(told), 2)
        self.assertIn('"/CN=foreign CA" (ECDSA)', told[0])
        (self.folders[1].path / "permissions_ca.pem").write_bytes(foreign + own)
        self.talk("fastdds")

    def test_another_kind_of_signature_fast_dds_refuses_the_peer(self):
        own = (self.shop.ca("permissions") / "cert.pem").read_bytes()
        same_name = (self.shop.ca("rsa", subject="/CN=permissions CA", kind="rsa") / "cert.pem").read_bytes()
        (self.talker.path / "permissions_ca.pem").write_bytes(same_name + own)
        self.talk("fastdds", 1)


class AllowRules(ProductRefusals):
    NEVER_ASKED = (GOVERNANCE.replace("join_access_control>true", "join_access_control>false")
                   .replace("read_access_control>true", "read_access_control>false")
                   .replace("write_access_control>true", "write_access_control>false"))
    ONLY_DENIED = allow("Circle").replace("allow_rule", "deny_rule")

    def permit(self, governance, rules):
        for folder in self.folders:
            folder.sign("governance", governance)
            folder.sign("permissions", permissions(grant(folder.subject, rules=rules)))

    def test_grant_without_allow_rule_fast_dds_does_not_start(self):
        self.permit(self.NEVER_ASKED, self.ONLY_DENIED)
        verdicts, told = self.doctor("DOC051")
        self.assertEqual(verdicts, {**ALL, "fastdds@2.9.1": "fail"})
        self.assertIn("has no allow_rule", told[0])
        self.talk("fastdds", 1)
        self.talk("cyclonedds")
        self.permit(self.NEVER_ASKED, self.ONLY_DENIED + allow("Circle", 7))
        self.assertEqual(self.doctor("DOC051"), (ALL, []))
        self.talk("fastdds")
        self.permit(GOVERNANCE, self.ONLY_DENIED)
        self.assertEqual(self.doctor()[0], dict.fromkeys(ALL, "fail"))


class OwnEndpoints(ProductRefusals):
    DENIED_ELSEWHERE = allow("*", 7).replace("allow_rule", "deny_rule")

    def compare(self, before, after):
        for name, rules in (("old", before), ("new", after)):
            (self.at / f"{name}.xml").write_text(permissions(grant("CN=talker", rules=rules)))
        done = self.run_program("permissions", "diff", "old.xml", "new.xml", "--fail-on", "wider", exit=None)
        return done.returncode, " ".join((done.stdout + done.stderr).split())

    def test_rule_of_another_domain_leaves_is_wider_to_fast_dds(self):
        exit, told = self.compare(self.DENIED_ELSEWHERE + allow("a"), allow("a"))
        self.assertEqual(exit, 1)
        self.assertIn("with Fast DDS, which applies rules for every domain to its own writers and readers: rule publish "
                      "of topics such as \"a\" denied -> allowed in domain 0", told)

    def test_other_changes_with_rules_of_several_domains_are_told_once(self):
        for before, after, expected in ((allow("a"), self.DENIED_ELSEWHERE + allow("a"), 0),
                                        (allow("a") + allow("b", 5), allow("b", 5) + allow("a"), 0),
                                        (allow("a") + allow("b", 5), allow("a"), 0),
                                        (allow("a") + allow("b", 5), allow("*") + allow("b", 5), 1)):
            exit, told = self.compare(before, after)
            self.assertEqual(exit, expected, told)
            self.assertEqual("with Fast DDS" in told, before == allow("a"), told)


class Elements(ProductRefusals):
    VALIDITY = "<validity><not_before>2020-01-01T00:00:00Z</not_before><not_after>2037-01-01T00:00:00Z</not_after></validity>"
    ORDERS = ("{validity}{name}{rule}", "{name}{rule}{validity}", "{rule}{name}{validity}")

    def sign(self, parts, rule=None):
        for folder in self.folders:
            rest = parts.format(name=f"<subject_name>{folder.subject}</subject_name>", validity=self.VALIDITY,
                                rule=rule or allow())
            folder.sign("permissions", permissions(f'<grant name="g">{rest}<default>DENY</default></grant>'))

    def test_grant_in_another_order_fast_dds_refuses(self):
        self.sign("{name}{validity}{rule}")
        self.assertEqual(self.doctor("DOC037"), (ALL, []))
        for parts in self.ORDERS:
            self.sign(parts)
            verdicts, told = self.doctor("DOC037")
            self.assertEqual(verdicts, {**ALL, "fastdds@2.9.1": "fail"}, parts)
            self.assertIn("does not begin with <subject_name> and <validity>", told[0])
            self.talk("fastdds", 1)
            self.talk("cyclonedds")

    def test_end_before_begin_fast_dds_refuses(self):
        dates = "<not_before>2020-01-01T00:00:00Z</not_before>", "<not_after>2037-01-01T00:00:00Z</not_after>"
        self.sign("{name}<validity>" + dates[1] + dates[0] + "</validity>{rule}")
        verdicts, told = self.doctor("DOC037")
        self.assertEqual(verdicts, {**ALL, "fastdds@2.9.1": "fail"})
        self.assertIn("<not_after> before its <not_before>", told[0])

    def test_subscribe_before_publish_every_product_takes(self):
        domains, publish, subscribe = (part for part in allow().splitlines()[1:4])
        self.sign("{name}{validity}{rule}", f"<allow_rule>{domains}{subscribe}{publish}</allow_rule>")
        verdicts, told = self.doctor("DOC037")
        self.assertEqual(verdicts, ALL)
        self.assertIn("Fast DDS takes it", told[0])
        self.talk("fastdds")
        self.sign("{name}{validity}{rule}", f"<allow_rule>{publish}{subscribe}{domains}</allow_rule>")
        self.assertEqual(self.doctor()[0], {**ALL, "fastdds@2.9.1": "fail"})

    def judge(self, document, *replaced):
        texts = {"governance": GOVERNANCE, "permissions": permissions(grant("CN=talker"))}
        for old, new in replaced:
            self.assertIn(old, texts[document])
            texts[document] = texts[document].replace(old, new)
        self.talker.sign(document, texts[document])
        verdict = self.doctor()[0]["fastdds@2.9.1"]
        self.talker.sign(document, {"governance": GOVERNANCE, "permissions": permissions(grant("CN=talker"))}[document])
        return verdict

    # Fast DDS ignores the attribute; ddssec and Cyclone DDS refuse it.
    def test_attribute_that_fast_dds_ignores_hides_nothing(self):
        name, domains = ("<subject_name>", "<subject_name x=\"v\">"), ("<domains>", "<domains x='v>' y=\"\">")
        self.assertEqual(self.judge("permissions", name), "ok")
        self.assertEqual(self.judge("governance", domains), "ok")
        for replaced in (("2037-01-01", "2021-01-01"), ("CN=talker", "CN=another"), (">DENY<", ">MAYBE<"),
                         ("<publish>", "<foo/><publish>")):
            self.assertEqual(self.judge("permissions", replaced, name), "fail", replaced)
        self.assertEqual(self.judge("governance", (">SIGN<", ">WRONG<"), domains), "fail")
        self.assertEqual(self.judge("governance", ("<id>0<", "<id>77<"), domains), "late")


class DeltaLists(ProductRefusals):
    def put_list(self, *revoked, days=("-crldays", "365")):
        """A delta list of the identity CA, which names the folder's certificate if told."""
        ca = self.talker.identity_ca
        (ca / "delta.cnf").write_text((ca / "openssl.cnf").read_text() + "\n[delta]\n2.5.29.27 = critical,DER:02021000\n")
        ca_words = ("-config", ca / "delta.cnf")
        index = (ca / "index.txt").read_text()
        for certificate in revoked:
            openssl("ca", *ca_words, "-revoke", certificate)
        (ca / "crlnumber").write_text("1001\n")
        openssl("ca", *ca_words, "-gencrl", "-crlexts", "delta", *days, "-out", self.at / "delta.pem")
        (ca / "index.txt").write_text(index)
        for folder in self.folders:
            folder.put("crl.pem", self.at / "delta.pem")

    # OpenSSL 3.0.22 and later refuse it; what this machine has counts.
    def test_delta_list_stock_products_take_it_as_openssl_does(self):
        self.put_list()
        check = ("openssl", "verify", "-crl_check", "-CAfile", "talker/identity_ca.pem", "-CRLfile", "delta.pem",
                 "talker/cert.pem")
        takes = self.exit_of(*check) == 0
        stock = dict.fromkeys(("cyclonedds@0.10.2", "fastdds@2.9.1"), "unsafe" if takes else "fail")
        verdicts, told = self.doctor("DOC023")
        self.assertEqual(verdicts, {**stock, "ddssec": "fail"})
        self.assertIn("this is a delta revocation list", told[0])
        for product in ("cyclonedds", "fastdds"):
            self.talk(product, 0 if takes else 1)
        self.talk("ddssec", 1)

    def test_delta_list_that_refuses_the_peer_stock_products_fail(self):
        self.put_list(self.folders[1].certificate)
        self.talk("cyclonedds", 1)
        self.put_list(days=("-crl_lastupdate", "20200101000000Z", "-crl_nextupdate", "20210101000000Z"))
        self.assertEqual(self.doctor()[0], dict.fromkeys(ALL, "fail"))

    def exit_of(self, *words):
        return subprocess.run(words, cwd=self.at, capture_output=True, check=False).returncode


class Partitions(ProductRefusals):
    # Fast DDS applies one expression to the other as to a name.
    def test_same_expressions_fast_dds_matches_them(self):
        rules = allow().replace("</topics>", "</topics><partitions><partition>*</partition></partitions>")
        for folder in self.folders:
            folder.sign("permissions", permissions(grant(folder.subject, rules=rules)))
        for names, exits in (("*", (0, 1, 1)), ("p*", (0, 1, 1)), ("p?", (0, 1, 1)), ("[ab]*", (1, 1, 1)), ("p", (0, 0, 0))):
            for vendors, exit in zip((("fastdds", "fastdds"), ("fastdds", "ddssec"), ("cyclonedds", "cyclonedds")), exits):
                self.run_program("check", "talker", "partner", "--topics", "Square", "--partition", names, "--vendor",
                                 "A=" + vendors[0], "--vendor", "B=" + vendors[1], exit=exit)


class UnreadByUs(ProductRefusals):
    """What ddssec refuses and OpenSSL, and so both products, read: unsafe, and check says that it cannot say."""

    def expect(self, products=("cyclonedds", "fastdds")):
        for product in products:
            self.talk(product, 3)
        verdicts = self.doctor()[0]
        self.assertEqual({verdicts[one] for one in ALL if one.split("@")[0] in products}, {"unsafe"})
        self.assertEqual(verdicts["ddssec"], "fail")

    def test_text_before_a_certificate_and_other_labels(self):
        for name in ("cert.pem", "identity_ca.pem", "permissions_ca.pem"):
            file = self.talker.path / name
            correct = file.read_bytes()
            for octets in (b"# " + b"x" * 2_000_000 + b"\n" + correct, correct.replace(b" CERTIFICATE", b" X509 CERTIFICATE"),
                           correct.replace(b" CERTIFICATE", b" TRUSTED CERTIFICATE")):
                file.write_bytes(octets)
                with self.subTest(name=name, size=len(octets)):
                    self.expect()
            file.write_bytes(b"# " + b"x" * 70_000)
            self.assertEqual(self.doctor()[0], dict.fromkeys(ALL, "fail"))
            self.talk("fastdds", 1)
            file.write_bytes(correct)

    def test_text_after_a_document(self):
        file = self.talker.path / "permissions.p7s"
        file.write_bytes(file.read_bytes() + b"\nmore\n")
        self.expect()

    def test_kinds_of_keys_that_fast_dds_takes(self):
        # Measured: with Ed25519 it starts, and authenticates no peer.
        for kind, verdict, answer in (("rsa1024", "unsafe", 3), ("ed25519", "late", 1)):
            Folder(self.shop, self.at / kind, f"/CN={kind}", kind, kind=kind)
            self.assertEqual(self.doctor(folder=kind)[0]["fastdds@2.9.1"], verdict)
            for folders in ((kind, "partner"), ("partner", kind)):
                self.run_program("check", *folders, "--topics", "Square", "--vendor", "fastdds", exit=answer)
                self.run_program("check", *folders, "--topics", "Square", "--vendor", "cyclonedds", exit=1)

    def test_ca_by_its_key_usage_only(self):
        ca = self.shop.ca("usage", extensions=("keyUsage=critical,keyCertSign,cRLSign",))
        for name in ("one", "other"):
            folder = Folder(self.shop, self.at / name, f"/CN={name}", name, ca=ca)
            folder.put("identity_ca.pem", ca / "cert.pem")
        for product, exit in (("cyclonedds", 0), ("fastdds", 0), ("ddssec", 1)):
            self.run_program("check", "one", "other", "--topics", "Square", "--vendor", product, exit=exit)


if __name__ == "__main__":
    main()
