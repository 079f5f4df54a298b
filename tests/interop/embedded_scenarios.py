"""The same table for the embedded participant (rtps/) in the place of our plugins in Cyclone DDS,
and both beside each other."""

from dataclasses import replace

import scenarios
EMBEDDED = "embedded"
PAIRS = [(EMBEDDED, EMBEDDED), (EMBEDDED, "ddssec"), ("ddssec", EMBEDDED), (EMBEDDED, "stock"),
         ("stock", EMBEDDED), (EMBEDDED, "fast"), ("fast", EMBEDDED)]


def _instead(case, pair):
    """The case with `pair`; what a host may not be able to do, the embedded participant must."""
    allowed = case.allowed
    if case.row.startswith("plain-") and case.row.endswith("-allowed-open-topic"):
        allowed = frozenset({scenarios.DATA})
    reason = case.reason
    if case.row.startswith("controlled-topic-unguarded"):
        # The embedded participant judges each endpoint itself.
        allowed = frozenset({scenarios.REFUSED if "ddssec" in pair else scenarios.DATA})
        reason = case.reason if "ddssec" in pair else ""
    return replace(case, reason=reason, publisher=pair[0], subscriber=pair[1], table="embedded-" + case.table,
                   allowed=allowed, known=(), chosen=False)


def _pairs_for(case):
    """Which pairs stand for a pair of ours."""
    as_embedded = tuple(EMBEDDED if kind == "ddssec" else kind
                        for kind in (case.publisher, case.subscriber))
    out = [as_embedded]
    if (case.publisher, case.subscriber) == ("ddssec", "ddssec"):
        # A fault of ours in Cyclone is Cyclone's table; a plain peer is never "ours".
        plain = [side.plain for side in case.sides]
        if not any(plain):
            out += [(EMBEDDED, "ddssec"), ("ddssec", EMBEDDED)]
    return out


def _choose(cases):
    """About 40: every governance row once, with turning pairs and directions, and the negatives."""
    pairs = [f"{p}>{s}" for p, s in PAIRS]
    rows = list(scenarios.GOVERNANCES)
    wanted = {(row, f"ec/start-{'sub' if turn % 2 else 'pub'}", pairs[turn % len(pairs)])
              for turn, row in enumerate(rows)}
    # The initiator's and the replier's part against each vendor, with both kinds of keys.
    for key in ("ec", "rsa"):
        wanted |= {("sros2", f"{key}/start-{start}", pair) for start in ("pub", "sub")
                   for pair in ("embedded>fast", "stock>embedded")}
    always = {("self-signed-permissions", "fast>embedded"), ("unknown-identity-ca", "stock>embedded"),
              ("plain-publisher-allowed-controlled-topic", "stock>embedded"),
              ("plain-publisher-not-allowed", "fast>embedded"),
              ("unknown-ca-publisher-allowed-open", "stock>embedded"),
              ("unknown-ca-publisher-allowed-open", "embedded>ddssec"),
              ("plain-publisher-allowed-open-topic", "fast>embedded"),
              ("plain-subscriber-allowed-open-topic", "embedded>fast"),
              ("governance-differs-rtps-none-sign", "embedded>embedded"),
              ("permissions-expired", "embedded>embedded"),
              ("permissions-deny-publish", "embedded>embedded"),
              ("other-domain-remote-only", "embedded>stock"),
              ("publisher-on-crl", "fast>embedded"),
              ("certificate-revoked-meanwhile", "fast>embedded"),
              ("both-everything-encrypt-oa", "embedded>embedded"),
              ("both-sros2", "embedded>ddssec"), ("by-environment", "ddssec>embedded"),
              ("peer-has-aes-only", "embedded>stock"), ("peer-has-aes-only", "fast>embedded")}
    return [replace(case, chosen=(case.row, case.variant, case.pair) in wanted or
                    (case.row, case.pair) in always) for case in cases]


def all_cases():
    cases = []
    for case in scenarios.all_cases():
        mixed = {case.publisher, case.subscriber} & set(scenarios.MIXES)
        if mixed or case.stock_only or case.row == "by-environment-peer-has-aes-only":
            continue
        cases += [_instead(case, pair) for pair in _pairs_for(case)]
    return _choose(cases)
