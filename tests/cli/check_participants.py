"""Two participants for the tests of `ddssec check`."""

import pathlib
import tempfile

from transcript import WithoutLists
from workshop import Folder, Workshop, grant, permissions

ONE_WAY = """<allow_rule>
        <domains><id>0</id></domains>
        <{0}><topics><topic>Square</topic></topics></{0}>
      </allow_rule>"""


class CheckTest(WithoutLists):
    """talker publishes Square and listener subscribes to it, until something is changed."""

    @classmethod
    def setUpClass(cls):
        cls.made = tempfile.TemporaryDirectory(prefix="ddssec-check-")
        cls.addClassCleanup(cls.made.cleanup)
        cls.shop = Workshop(pathlib.Path(cls.made.name) / "workshop")

    def setUp(self):
        super().setUp()
        self.talker = self.participant("talker", "publish")
        self.listener = self.participant("listener", "subscribe")

    def participant(self, name, may, **leaf):
        made = Folder(self.shop, self.at / name, f"/CN={name}", leaf.pop("label", name), **leaf)
        made.sign("permissions", permissions(grant(made.subject, ONE_WAY.format(may))))
        return made

    def check(self, *words, exit):
        return self.json("check", "talker", "listener", *words, exit=exit)

    def apart(self, rule, *values, words=(), document=None):
        """They do not talk, and one sentence says so with these values."""
        out = self.check(*words, exit=1)
        told = [d for d in out["diagnostics"] if d["id"] == rule]
        told = [d for d in told if all(value in d["message"] for value in values)]
        self.assertTrue(told, out["diagnostics"])
        if document:
            self.assertEqual(pathlib.Path(told[0]["file"]).name, document)
        self.assertTrue(told[0]["hint"])
        self.hint = told[0]["hint"]
        return out["result"]
