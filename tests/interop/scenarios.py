"""The table of what is run: scenarios, the pairs of each, and the outcome each must have."""

from dataclasses import dataclass, replace

from documents import OTHER_DOMAIN, Governance, Keys, Permissions, Side

# Outcome words; README.md explains them.
DATA, PARTIAL, MATCHED, HALF, NONE, REFUSED, CUT = (
    "data partial matched half none refused cut".split())
NOTHING = frozenset({NONE, REFUSED})

EXPIRY_SECONDS = 5  # from the making of a document to its end, in the rows about expiry

MIXES = ("ddssec-auth", "ddssec-ac", "ddssec-crypto")  # one plugin of ddssec beside two stock ones
LETTERS = {"ddssec": "o", "stock": "c", "fast": "f", "ddssec-auth": "oA", "ddssec-ac": "oP",
           "ddssec-crypto": "oC"}
OUR_PAIRS = [("ddssec", "ddssec"), ("ddssec", "stock"), ("stock", "ddssec"), ("ddssec", "fast"),
             ("fast", "ddssec")]
STOCK_PAIRS = [("stock", "stock"), ("stock", "fast"), ("fast", "stock"), ("fast", "fast")]


@dataclass(frozen=True)
class Case:
    """One pair to run. `allowed` are the outcomes that count as required; `known` maps an outcome
    that is tolerated, and shown as KNOWN, to its reason."""
    table: str          # which table of the summary it belongs to
    row: str
    variant: str
    publisher: str
    subscriber: str
    sides: tuple        # Side of the publisher, Side of the subscriber
    keys: Keys
    publisher_starts: bool
    allowed: frozenset
    chosen: bool = False
    known: tuple = ()   # (outcome, reason)
    expires: bool = False  # data must flow first and stop later
    reason: str = ""       # a code that the log of a peer of ddssec must show
    payload: int = 0       # octets in each sample; 0: as the peers send them

    @property
    def pair(self):
        return f"{self.publisher}>{self.subscriber}"

    @property
    def name(self):
        return "/".join(part for part in (self.table, self.row, self.variant) if part)

    @property
    def stock_only(self):
        return not any(kind.startswith("ddssec") for kind in (self.publisher, self.subscriber))


# ---- positive: governance x keys x who starts -------------------------------------------------

S, E = "SIGN", "ENCRYPT"
SO, EO = (f"{kind}_WITH_ORIGIN_AUTHENTICATION" for kind in (S, E))
KINDS = {"sign": S, "encrypt": E, "sign-oa": SO, "encrypt-oa": EO}


def _open(**kinds):
    """Without access control: our plugins refuse endpoints of topics whose access is controlled and
    which nothing protects (Cyclone DDS; the row controlled-topic-unguarded)."""
    return Governance(read=False, write=False, **kinds)


def _everything(kind):
    return Governance(discovery=kind, liveliness=kind, rtps=kind, metadata=kind,
                      data=E if kind.startswith(E) else S)


SROS2 = Governance(discovery=E, liveliness=E, rtps=S, metadata=E, data=E)

GOVERNANCES = {
    "all-none": _open(),
    "data-sign": Governance(data=S),
    "data-encrypt": Governance(data=E),
    "rtps-sign+data-encrypt": Governance(rtps=S, data=E),
    "rtps-encrypt+data-encrypt": Governance(rtps=E, data=E),
    **{f"metadata-{name}": Governance(metadata=kind) for name, kind in KINDS.items()},
    "metadata-sign+data-encrypt": Governance(metadata=S, data=E),
    "metadata-encrypt+data-encrypt": Governance(metadata=E, data=E),
    "metadata-encrypt-oa+data-encrypt": Governance(metadata=EO, data=E),
    **{f"discovery-{name}": _open(discovery=kind) for name, kind in KINDS.items()},
    "discovery-encrypt-topic-off": _open(discovery=E, topic_discovery=False),
    **{f"liveliness-{name}": _open(liveliness=kind) for name, kind in KINDS.items()},
    **{f"rtps-{name}": _open(rtps=kind) for name, kind in KINDS.items()},
    "sros2": SROS2,
    **{f"everything-{name}": _everything(kind) for name, kind in KINDS.items()},
    "no-access-control": Governance(metadata=E, data=E, join=False, read=False, write=False),
}
KEYS = {"ec": Keys(), "rsa": Keys("rsa", "rsa", "rsa"), "ec-under-rsa": Keys("ec", "rsa", "rsa"),
        "ec+rsa-permissions": Keys("ec", "ec", "rsa")}


def stock_outcome(publisher, subscriber, publisher_starts, governance):
    """What two stock peers do with valid documents (measured): Fast DDS cannot start towards
    Cyclone DDS, and its writer never pairs with a Cyclone reader on payload-only topics."""
    starter, other = ((publisher, subscriber) if publisher_starts else (subscriber, publisher))
    if (starter, other) == ("fast", "stock"):
        return NONE
    payload_only = governance.metadata == "NONE" and governance.data != "NONE"
    if (publisher, subscriber) == ("fast", "stock") and payload_only:
        return HALF
    return DATA


def _positive(row, side, keys, pair, publisher_starts, variant=""):
    stock_only = "ddssec" not in "".join(pair)
    wanted = stock_outcome(*pair, publisher_starts, side.governance) if stock_only else DATA
    start = "start-pub" if publisher_starts else "start-sub"
    return Case("governance", row, "/".join(filter(None, (keys, variant, start))), *pair,
                (side, side), KEYS[keys], publisher_starts, frozenset({wanted}))


def governance_cases():
    cases = []
    for row, governance in GOVERNANCES.items():
        for keys in ("ec", "rsa", "ec-under-rsa"):
            for pair in OUR_PAIRS + STOCK_PAIRS:
                for publisher_starts in (True, False):
                    cases.append(_positive(row, Side(governance), keys, pair, publisher_starts))
    for row in ("sros2", "rtps-encrypt", "rtps-encrypt-oa", "everything-encrypt-oa"):
        for pair in OUR_PAIRS + STOCK_PAIRS:
            side = Side(GOVERNANCES[row], keysize=128)
            starts = pair[0] != "fast" or pair[1] == "fast"
            cases.append(_positive(row, side, "ec", pair, starts, "aes128"))
    for pair in OUR_PAIRS + STOCK_PAIRS:
        starts = pair[0] != "fast" or pair[1] == "fast"
        cases.append(_positive("sros2", Side(SROS2), "ec+rsa-permissions", pair, starts))
    return cases


def _choose_governance(cases):
    """About 60 of them: each row once or twice with turning pairs, keys and directions, and what
    two stock peers cannot do."""
    pairs, keys = [f"{p}>{s}" for p, s in OUR_PAIRS], ("ec", "rsa", "ec-under-rsa")
    rows = [row for number, row in enumerate(GOVERNANCES) for _ in range(1 + number % 2)]
    wanted = set()
    for turn, row in enumerate(rows):  # 2, 3 and 5 have no common factor: all combinations come
        start = "start-sub" if turn % 2 else "start-pub"
        wanted.add((row, f"{keys[turn % 3]}/{start}", pairs[turn % 5]))
    for row in ("data-encrypt", "rtps-encrypt+data-encrypt"):
        wanted.add((row, "ec/start-sub", "fast>ddssec"))
    for key in ("ec", "rsa"):
        wanted.add(("sros2", f"{key}/start-pub", "fast>ddssec"))
        wanted.add(("sros2", f"{key}/start-sub", "ddssec>fast"))
    for pair in pairs:
        wanted.add(("everything-encrypt-oa", "ec/aes128/start-pub", pair))
    wanted.add(("everything-encrypt-oa", "ec/aes128/start-sub", "fast>ddssec"))
    wanted.add(("sros2", "ec+rsa-permissions/start-pub", "ddssec>fast"))
    return [replace(case, chosen=(case.row, case.variant, case.pair) in wanted) for case in cases]


# ---- one plugin of ddssec beside two stock ones ---------------------------------------------------

def mixed_cases():
    chosen = {("ddssec-auth", "stock"), ("ddssec-auth", "fast"), ("ddssec-ac", "stock"),
              ("fast", "ddssec-ac"), ("ddssec-crypto", "stock"), ("fast", "ddssec-crypto"),
              ("ddssec", "ddssec-auth"), ("ddssec-ac", "ddssec"), ("ddssec", "ddssec-crypto")}
    cases = []
    for row in ("sros2", "all-none", "everything-encrypt-oa", "data-encrypt"):
        for mix in MIXES:
            for other in ("ddssec", "stock", "fast"):
                for pair in ((mix, other), (other, mix)):
                    # Only our cryptography sends the token a Fast DDS writer waits for.
                    if row == "data-encrypt" and pair[0] == "fast" and mix != "ddssec-crypto":
                        continue
                    case = replace(_positive(row, Side(GOVERNANCES[row]), "ec", pair,
                                             pair[0] != "fast"), table="mixed")
                    picked = row == "sros2" and pair in chosen
                    picked |= row == "data-encrypt" and pair == ("fast", "ddssec-crypto")
                    cases.append(replace(case, chosen=picked))
    for pair, publisher_starts in ((("fast", "ddssec-auth"), True), (("ddssec-auth", "fast"), False)):
        cases.append(replace(_positive("sros2", Side(SROS2), "ec", pair, publisher_starts),
                             table="mixed", chosen=pair[0] == "fast"))
    return cases


# ---- negatives and their positive controls ------------------------------------------------------

# How a row is judged when one peer is of ddssec.
MUST_DATA, MUST_NONE, NO_DATA, MUST_REFUSE, EITHER, MUST_CUT = (
    "data none no-data refuse either cut".split())
# A host's shortcoming: Cyclone DDS asks no plugin about a participant that is not authenticated.
CORE_DECIDES = ((DATA, "Cyclone's core asks no plugin about unauthenticated participants"),)
NOTHING_PROTECTED = ((DATA, "nothing is protected, and Cyclone's core matches without authentication (GOV040)"),)
MATCHED_ONLY = ((MATCHED, "Cyclone's core matches without authentication; message protection lets no sample pass"),)


@dataclass(frozen=True)
class Row:
    """A faulty pair. `stock` are the outcomes of F>F, F>C, C>F and C>C, words joined by "|"."""
    name: str
    publisher: Side
    subscriber: Side
    stock: tuple
    ddssec: str
    faulty: int = 0     # 0: the publisher has the fault, 1: the subscriber
    quick: bool = True  # part of the chosen set
    known: tuple = ()
    keys: Keys = Keys()
    pairs: tuple = ()   # only these pairs of ddssec; empty: all that make sense
    reason: str = ""    # as in Case


def _pub(row_name, stock, ddssec, base=SROS2, quick=True, **fault):
    good = Side(base)
    return Row(row_name, replace(good, **fault), good, stock, ddssec, 0, quick)


def _sub(row_name, stock, ddssec, base=SROS2, quick=True, **fault):
    good = Side(base)
    return Row(row_name, good, replace(good, **fault), stock, ddssec, 1, quick)


ALL_NONE, ALL_DATA, ALL_REFUSED = (NONE,) * 4, (DATA,) * 4, (REFUSED,) * 4
NO_PUBLISH, NO_SUBSCRIBE = Permissions(publish=()), Permissions(subscribe=())
ELSEWHERE = Permissions(domain=OTHER_DOMAIN)
GUESTS = Governance(allow_unauthenticated=True, join=False, read=False, write=False)
GUESTS_CONTROLLED = replace(GUESTS, read=True, write=True)
GUESTS_ENCRYPTED = replace(GUESTS, metadata=E, data=E)


def _negative_rows():
    yield _pub("unknown-identity-ca", ALL_NONE, MUST_NONE, signed_by="other", trusts="other")
    yield replace(_pub("unknown-identity-ca-all-none", (NONE, NONE, NONE, DATA), MUST_NONE, _open(), quick=False,
                       signed_by="other", trusts="other"), known=NOTHING_PROTECTED)
    yield replace(_pub("unknown-identity-ca-rtps-sign", (NONE, NONE, NONE, MATCHED), MUST_NONE, _open(rtps=S),
                       quick=False, signed_by="other", trusts="other"), known=MATCHED_ONLY)
    yield _pub("certificate-not-under-own-ca", ALL_REFUSED, MUST_REFUSE, quick=False,
               signed_by="other")
    yield _pub("certificate-expired", ALL_REFUSED, MUST_REFUSE, expired=True)
    yield _pub("private-key-of-another", (REFUSED, REFUSED, NONE, NONE), MUST_REFUSE,
               foreign_key=True)
    yield _sub("publisher-on-crl", ALL_NONE, MUST_NONE, crl="peer")
    yield _sub("crl-names-another", ALL_DATA, MUST_DATA, crl="stranger")
    yield _pub("permissions-deny-publish", ALL_REFUSED, MUST_REFUSE, permissions=NO_PUBLISH)
    yield _sub("permissions-deny-subscribe", ALL_REFUSED, MUST_REFUSE, permissions=NO_SUBSCRIBE)
    yield _pub("deny-publish-remote-only", ALL_NONE, MUST_NONE, quick=False, permissions=NO_PUBLISH,
               governance=replace(SROS2, write=False))
    yield _sub("deny-subscribe-remote-only", ALL_NONE, MUST_NONE, quick=False,
               permissions=NO_SUBSCRIBE, governance=replace(SROS2, read=False))
    yield _pub("permissions-other-domain", (NONE, NONE, REFUSED, REFUSED), MUST_REFUSE,
               permissions=ELSEWHERE)
    yield _pub("other-domain-remote-only", ALL_NONE, MUST_NONE, permissions=ELSEWHERE,
               governance=replace(SROS2, join=False, read=False, write=False))
    yield _pub("permissions-expired", ALL_REFUSED, MUST_REFUSE,
               permissions=Permissions(not_after="2021-01-01T00:00:00"))
    yield _pub("permissions-not-yet-valid", ALL_REFUSED, MUST_REFUSE, quick=False,
               permissions=Permissions(not_before="2036-01-01T00:00:00"))
    yield _pub("permissions-other-subject", ALL_REFUSED, MUST_REFUSE, quick=False,
               permissions=Permissions(other_subject=True))
    yield _pub("permissions-tampered", ALL_REFUSED, MUST_REFUSE, quick=False,
               tamper="permissions")
    yield _pub("permissions-unknown-signer", ALL_REFUSED, MUST_REFUSE, quick=False,
               permissions_by="other", governance_by="main")
    yield _pub("permissions-ca-differs", ALL_NONE, MUST_NONE, permissions_by="second",
               permissions_ca="second")
    yield _pub("governance-tampered", ALL_REFUSED, MUST_REFUSE, tamper="governance")
    yield _pub("governance-wrong-signer", ALL_REFUSED, MUST_REFUSE, quick=False,
               governance_by="other")
    yield _pub("governance-domain-not-covered", ALL_REFUSED, MUST_REFUSE,
               governance=replace(SROS2, domains=(99, 99)))
    for name, mine, peers in (
            ("rtps-none-sign", _open(), _open(rtps=S)),
            ("rtps-sign-encrypt", _open(rtps=S), _open(rtps=E)),
            ("metadata", Governance(metadata=S), Governance(metadata=E)),
            ("data", Governance(metadata=S, data=S), Governance(metadata=S, data=E)),
            ("discovery", _open(discovery=S), _open(discovery=E))):
        yield Row("governance-differs-" + name, Side(mine), Side(peers), ALL_NONE, MUST_NONE, 0,
                  name == "rtps-none-sign")
    # What only keys can enforce under Cyclone's core: its peers say themselves whether they are asked.
    for name, unguarded in (("", Governance()), ("-in-protected-messages", Governance(rtps=E))):
        yield replace(_pub("controlled-topic-unguarded" + name, ALL_DATA, MUST_REFUSE, unguarded,
                           quick=not name), reason="controlled_topic_unguarded")
    # CVE-2023-24011: one CA for both, permissions signed with the participant's own identity.
    one_ca = Side(SROS2, permissions_ca="identity", permissions_by="identity")
    forged = replace(one_ca, permissions_by="leaf", governance_by="identity")
    yield Row("one-ca-for-both", one_ca, one_ca, ALL_DATA, MUST_DATA)
    yield Row("self-signed-permissions", forged, one_ca, ALL_DATA, MUST_REFUSE)
    yield Row("self-signed-permissions-subscriber", one_ca, forged, ALL_DATA, MUST_REFUSE, 1)


def _plain_rows():
    guest = Side(plain=True)
    unseen = "none|half|matched"  # never data
    for name, governance, stock_pub, stock_sub, ddssec in (
            ("not-allowed", SROS2, ALL_NONE, ALL_NONE, NO_DATA),
            ("allowed-open-topic", GUESTS, (NONE, HALF, NONE, DATA), (NONE, NONE, HALF, DATA),
             EITHER),
            ("allowed-controlled-topic", GUESTS_CONTROLLED, (NONE, DATA, NONE, DATA),
             (NONE, NONE, DATA, DATA), NO_DATA),
            ("allowed-encrypted-topic", GUESTS_ENCRYPTED, (NONE, unseen, NONE, unseen),
             (NONE, NONE, unseen, unseen), NO_DATA)):
        known = CORE_DECIDES if governance == GUESTS_CONTROLLED else ()
        yield Row(f"plain-publisher-{name}", guest, Side(governance), stock_pub, ddssec,
                  quick=name == "allowed-open-topic", known=known)
        yield Row(f"plain-subscriber-{name}", Side(governance), guest, stock_sub, ddssec, 1,
                  quick=name == "allowed-controlled-topic", known=known)
    # DDS-Security 1.2, clause 9.8.3.1: who fails to authenticate is treated like who cannot. Fast DDS 2.9 never
    # reads the attribute.
    yield replace(_pub("unknown-ca-publisher-allowed-open", (NONE, NONE, NONE, DATA), MUST_DATA, GUESTS,
                       quick=False, signed_by="other", trusts="other"),
                  pairs=(("ddssec", "ddssec"), ("ddssec", "stock"), ("stock", "ddssec")))


def _accepted_rows():
    """Positive controls: what looks odd and must work."""
    for name, pattern in (("star", "Squ*"), ("question-mark", "S?uare")):
        wild = Permissions(publish=(pattern,), subscribe=(pattern,))
        yield Row(f"topic-pattern-{name}", *[Side(SROS2, wild)] * 2, ALL_DATA, MUST_DATA,
                  quick=False)
    yield Row("members-where-strangers-are-allowed", Side(GUESTS), Side(GUESTS), ALL_DATA, MUST_DATA)
    inside = Side(SROS2, Permissions(partition="yard"), partition="yard")
    yield Row("partition-allowed", inside, inside, ALL_DATA, MUST_DATA)
    outside = replace(inside, partition="street")
    yield Row("partition-not-allowed", outside, inside, ALL_REFUSED, MUST_REFUSE)
    yield _pub("private-key-with-password", ALL_DATA, MUST_DATA, password=True)
    yield _pub("documents-as-data-uris", (REFUSED, REFUSED, DATA, DATA), MUST_DATA,
               data_uris=True)
    # What stock Cyclone DDS does not know (Fast DDS does).
    good, unknown = Side(SROS2), (DATA, REFUSED, REFUSED, REFUSED)
    yield Row("ec-p384", good, good, unknown, MUST_DATA, pairs=(("ddssec", "ddssec"),),
              keys=Keys("ec384", "ec384", "ec384"))
    below = replace(good, signed_by="intermediate")
    yield Row("certificate-under-intermediate-ca", below, below, unknown, MUST_DATA,
              pairs=(("ddssec", "ddssec"), ("ddssec", "fast"), ("fast", "ddssec")))


def _expiry_rows():
    """The publisher's right ends while data flows."""
    for what in ("identity", "permissions"):
        yield _pub(f"{what}-expires", (DATA, CUT, DATA, CUT), MUST_CUT, quick=False,
                   **{f"{what}_seconds": EXPIRY_SECONDS})
    # The stock ones read their list once.
    good = Side(SROS2)
    yield Row("certificate-revoked-meanwhile", good, replace(good, crl="later"), ALL_DATA, MUST_CUT,
              quick=False, pairs=(("ddssec", "ddssec"), ("stock", "ddssec"), ("fast", "ddssec")),
              reason="certificate_revoked")


STOCK_ORDER = [("fast", "fast"), ("fast", "stock"), ("stock", "fast"), ("stock", "stock")]


def _alone(row, kind):
    """The row's outcome between two stock peers of one kind."""
    return row.stock[STOCK_ORDER.index((kind, kind))]


def _allowed(row, pair):
    """The outcomes that are right for this row and pair."""
    if "ddssec" not in pair:
        return frozenset(row.stock[STOCK_ORDER.index(pair)].split("|"))
    if row.ddssec == MUST_CUT:
        return frozenset({CUT})
    if row.ddssec == MUST_DATA:
        return frozenset({DATA})
    if row.ddssec == MUST_NONE:
        return frozenset({NONE})
    if row.ddssec == NO_DATA:  # a plain peer knows of no refusal and may believe in a match;
        return frozenset({NONE, HALF, REFUSED})  # ddssec may refuse to serve such a topic at all
    if row.ddssec == EITHER:
        return frozenset({DATA, HALF, NONE})
    # The faulty side must be refused at creation if it is ours; a stock one may come so far that
    # our side has to refuse it.
    return frozenset({REFUSED}) if pair[row.faulty] == "ddssec" else NOTHING


def _meaningful(row, pair):
    sides = (row.publisher, row.subscriber)
    if row.pairs and "ddssec" in pair:
        return pair in row.pairs
    if any(side.plain and kind == "ddssec" for side, kind in zip(sides, pair)):
        return False  # a plain peer has no plugins
    faulty = pair[row.faulty]
    # A stock peer that refuses its own documents never meets ours.
    return faulty == "ddssec" or "ddssec" not in pair or _alone(row, faulty) != REFUSED


# What an attacker or a user would try first is in the chosen set with each of these pairs.
ALWAYS = {("self-signed-permissions", ("stock", "ddssec")),
          ("self-signed-permissions", ("fast", "ddssec")),
          ("self-signed-permissions", ("ddssec", "stock")),
          ("certificate-revoked-meanwhile", ("stock", "ddssec")),
          ("identity-expires", ("stock", "ddssec")), ("permissions-expires", ("fast", "ddssec")),
          ("plain-publisher-not-allowed", ("stock", "ddssec")),
          ("plain-publisher-allowed-controlled-topic", ("stock", "ddssec"))}


def negative_cases():
    cases, turn = [], 0
    for table, rows in (("negative", _negative_rows()), ("negative", _plain_rows()),
                        ("accepted", _accepted_rows()), ("expiry", _expiry_rows())):
        for row in rows:
            mine = [pair for pair in OUR_PAIRS if _meaningful(row, pair)]
            turn += 1
            for pair in mine + STOCK_PAIRS:
                starts = pair[0] != "fast" or pair[1] == "fast"
                chosen = row.quick and pair == mine[turn % len(mine)]
                chosen |= (row.name, pair) in ALWAYS
                cases.append(Case(table, row.name, "", *pair, (row.publisher, row.subscriber),
                                  row.keys, starts, _allowed(row, pair), chosen, row.known,
                                  table == "expiry", row.reason if "ddssec" in pair else ""))
    return cases


# ---- ChaCha20-Poly1305 --------------------------------------------------------------------------

CHACHA = "org.ddssec.ChaCha20-Poly1305"


def cipher_cases():
    """Between two of ours it works, whichever of them chose it. A peer that did not announce it is
    refused with that reason."""
    def case(row, pair, sides, outcomes=frozenset({DATA}), **more):
        starts = pair[0] != "fast" or pair[1] == "fast"
        return Case("cipher", row, "", *pair, sides, Keys(), starts, outcomes, **more)

    cases, both = [], ("ddssec", "ddssec")
    for row in ("everything-encrypt-oa", "everything-sign-oa", "sros2", "data-encrypt",
                "metadata-sign"):
        side = Side(GOVERNANCES[row], cipher=CHACHA)
        cases.append(case("both-" + row, both, (side, side), chosen=row == "everything-encrypt-oa"))
    aes, chacha = Side(SROS2), Side(SROS2, cipher=CHACHA)
    cases.append(case("publisher-only", both, (chacha, aes)))
    cases.append(case("subscriber-only", both, (aes, chacha)))
    process = Side(SROS2, process_cipher=CHACHA)
    cases.append(case("by-environment", both, (process, process), chosen=True))
    unmatched = frozenset({NONE, HALF})
    cases.append(case("by-environment-peer-has-aes-only", ("ddssec", "stock"), (process, aes),
                      unmatched, reason="cipher_not_understood_by_peer"))
    for pair in (("ddssec", "stock"), ("stock", "ddssec"), ("ddssec", "fast"), ("fast", "ddssec"),
                 ("ddssec", "ddssec-auth")):
        sides = (chacha, aes) if pair[0] == "ddssec" else (aes, chacha)
        cases.append(case("peer-has-aes-only", pair, sides, unmatched,
                          chosen=pair in (("ddssec", "stock"), ("fast", "ddssec"),
                                          ("ddssec", "ddssec-auth")),
                          reason="cipher_not_understood_by_peer"))
    return cases


# ---- sizes --------------------------------------------------------------------------------------

def size_cases():
    """Samples that do not end with a whole word: Fast DDS leaves octets between a protected payload and the next
    submessage."""
    for row in ("data-encrypt", "sros2", "everything-encrypt-oa"):
        side = Side(GOVERNANCES[row])
        for pair in (("fast", "ddssec"), ("ddssec", "fast"), ("stock", "ddssec")):
            for size in (5, 6, 7, 17):
                yield Case("sizes", row, f"{size} octets", *pair, (side, side), Keys(), pair[0] != "fast", frozenset({DATA}),
                           chosen=row == "sros2" and pair[0] == "fast" and size in (5, 7), payload=size)


def all_cases():
    """Every case, those of two stock peers included."""
    return (_choose_governance(governance_cases()) + mixed_cases() + negative_cases() +
            cipher_cases() + list(size_cases()))
