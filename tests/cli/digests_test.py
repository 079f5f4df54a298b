#!/usr/bin/env python3
"""Digests of signatures on certificates. Measured with real pairs: Fast DDS 2.9.1 starts with SHA-256 only, Cyclone DDS
0.10.2 and ddssec's plugins with these too."""

from transcript import WithoutLists, main
from workshop import CA_EXTENSIONS, Folder, Workshop, openssl


class Digests(WithoutLists):
    def setUp(self):
        super().setUp()
        self.shop = Workshop(self.at / "shop")

    def verdicts(self, folder, exit):
        answer = self.json("doctor", folder.path, exit=exit)
        told = [one["message"] for one in answer["diagnostics"] if one["id"] == "DOC015"]
        return answer["result"]["verdicts"], told

    def check_refused_by_fastdds(self, folder, words):
        verdicts, told = self.verdicts(folder, 1)
        self.assertEqual(verdicts, {"cyclonedds@0.10.2": "ok", "fastdds@2.9.1": "fail", "ddssec": "ok"})
        self.assertEqual(len(told), 1)
        self.assertIn(words, told[0])

    def test_a_certificate_signed_with_sha_224_is_refused_by_fastdds(self):
        folder = Folder(self.shop, self.at / "talker", label="sha224", digest="sha224")
        self.check_refused_by_fastdds(folder, "signed with SHA224")

    def test_a_ca_signed_with_sha_1_is_refused_by_fastdds(self):
        ca = self.shop.ca("sha1", digest="sha1", extensions=CA_EXTENSIONS)
        folder = Folder(self.shop, self.at / "talker", label="below-sha1", ca=ca)
        folder.put("identity_ca.pem", ca / "cert.pem")
        self.check_refused_by_fastdds(folder, "signed with SHA1;")

    def test_a_ca_signed_with_pss_is_refused_by_fastdds(self):
        ca = self.shop.ca("pss", kind="rsa", extensions=CA_EXTENSIONS)
        openssl("req", "-x509", "-new", "-sha256", "-days", "3650", "-key", ca / "key.pem", "-subj", "/CN=pss CA",
                "-sigopt", "rsa_padding_mode:pss", *[part for text in CA_EXTENSIONS for part in ("-addext", text)],
                "-out", ca / "cert.pem")
        folder = Folder(self.shop, self.at / "talker", label="below-pss", ca=ca)
        folder.put("identity_ca.pem", ca / "cert.pem")
        self.check_refused_by_fastdds(folder, "signed with RSASSA-PSS")

    def test_certificates_signed_with_sha_256_fit_all_products(self):
        folder = Folder(self.shop, self.at / "talker")
        self.assertEqual(self.verdicts(folder, 0), ({"cyclonedds@0.10.2": "ok", "fastdds@2.9.1": "ok", "ddssec": "ok"}, []))


if __name__ == "__main__":
    main()
