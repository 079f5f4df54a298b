#!/usr/bin/env python3
"""A permissions CA whose key DDS-Security does not allow: ddssec's plugins refuse it, and stock products take it
(measured with pairs of Cyclone DDS 0.10.2 and of Fast DDS 2.9.1, which exchanged samples)."""

from transcript import WithoutLists, main
from workshop import KEY_KINDS, Folder, Workshop

KEY_KINDS |= {"p521": ("EC", "ec_paramgen_curve:secp521r1"), "p224": ("EC", "ec_paramgen_curve:secp224r1"),
              "secp256k1": ("EC", "ec_paramgen_curve:secp256k1")}
KINDS = ("rsa1024", "p521", "p224", "secp256k1")
STOCK = {"cyclonedds@0.10.2": "ok", "fastdds@2.9.1": "ok"}


class PermissionsCaKeys(WithoutLists):
    def make(self, kind):
        shop = Workshop(self.at / kind / "shop")
        shop.ca("permissions", kind=kind)
        return [Folder(shop, self.at / kind / name, f"/CN={name}", name) for name in ("talker", "partner")]

    def test_stock_products_take_every_key(self):
        for kind in KINDS:
            with self.subTest(kind=kind):
                self.make(kind)
                out = self.json("doctor", f"{kind}/talker", exit=1)
                self.assertEqual(out["result"]["verdicts"], {**STOCK, "ddssec": "fail"})
                told = [one for one in out["diagnostics"] if one["id"] == "DOC014"]
                self.assertEqual([one["vendors"] for one in told], [["ddssec"]])
                self.assertTrue(told[0]["message"].endswith("; ddssec's plugins refuse it"), told[0]["message"])
                for vendor in ("cyclonedds", "fastdds"):
                    pair = (f"{kind}/talker", f"{kind}/partner", "--topics", "Square")
                    self.json("check", *pair, "--vendor", f"A={vendor}", "--vendor", f"B={vendor}")
                self.json("check", *pair, "--vendor", "A=ddssec", "--vendor", "B=cyclonedds", exit=1)

    # Measured with 91 kinds of keys and signatures: with these, Fast DDS makes no participant.
    def test_kinds_that_fast_dds_does_not_start_with(self):
        self.make("rsa1024")
        folder = self.at / "rsa1024/talker"
        correct = {name: (folder / name).read_bytes() for name in ("identity_ca.pem", "permissions_ca.pem")}
        explicit = ("ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-pkeyopt", "ec_param_enc:explicit")
        for file, kind in (("identity_ca.pem", explicit), ("identity_ca.pem", ("ed25519",)), ("identity_ca.pem", ("ed448",)),
                           ("permissions_ca.pem", ("rsa-pss",))):
            with self.subTest(file, kind=kind):
                self.openssl("req", "-x509", "-nodes", "-subj", "/CN=x", "-keyout", "key", "-out", str(folder / file),
                             "-newkey", *kind)
                out = self.json("doctor", str(folder), "--vendor", "fastdds", exit=1)
                told = [one for one in out["diagnostics"] if one["id"] == "DOC014" and one["file"].endswith(file)]
                self.assertIn("and Fast DDS 2.9.1 refuse it", told[0]["message"])
                (folder / file).write_bytes(correct[file])

    def test_stock_products_still_check_the_signature(self):
        for document in ("governance", "permissions"):
            folder = self.make("rsa1024" if document == "governance" else "p521")[0]
            file = folder.path / f"{document}.p7s"
            file.write_bytes(file.read_bytes().replace(b"2020-01-01", b"2020-01-02").replace(b">SIGN<", b">NONE<"))
            out = self.json("doctor", str(folder.path), exit=1)
            self.assertEqual(out["result"]["verdicts"], {**dict.fromkeys(STOCK, "fail"), "ddssec": "fail"})
            self.assertIn("DOC031", [one["id"] for one in out["diagnostics"]])


if __name__ == "__main__":
    main()
