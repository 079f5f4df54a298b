#!/usr/bin/env python3
"""Starts the installed products on every folder of tests/cli/golden_folders.py, and compares what they do with the
table that `ddssec doctor` and `check` predict from (governance/doctor/measured_outcomes.def).

Usage: measure.py SOURCE BUILD [--newer] [--write] [FOLDER...]
--newer: Debian 13's Cyclone DDS and Fast DDS instead, from packages that come into BUILD; on Debian 13 they are
the installed ones. Exit 77: they cannot be had.
--write: puts what was measured into the table; a version that it lacks becomes a new column.
"""

import argparse
import pathlib
import sys
import tempfile

sys.dont_write_bytecode = True
HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "cli")]

import debian13  # noqa: E402
import forecast  # noqa: E402
import golden_folders  # noqa: E402
from pair import Namespace  # noqa: E402

# Believed by those that come up, and not to be believed.
UNSAFE = {"rsa-1024", "permissions-by-itself", "permissions-by-unlisted-intermediate", "form-sha1",
          "permissions-domain-tag"}
# Cyclone DDS reads more topics in it than ddssec (DOC107), or takes the grant of another subject (DOC011).
UNSAFE_WITH_CYCLONEDDS = {"grant-bracket-caret", "subject-trailing-comma"}
# Those that may come up without exchanging samples of Square: they are paired with a correct participant, in each
# role that their grant allows.
BOTH = ("publisher", "subscriber")
PAIRED = {"correct": BOTH, "key-of-another": BOTH, "ed25519": BOTH, "grant-other-domain": BOTH, "grant-default-allow": BOTH,
          "grant-deny-one-way": BOTH[:1], "grant-deny-other-way": BOTH[1:], "grant-deny-first": BOTH,
          "governance-other-domain": BOTH}
PAIR_SECONDS = 6


def newer(source, build):
    """Debian 13's products; None if they cannot be had."""
    if debian13.is_installed():
        return forecast.installed(build)
    cyclone = debian13.Packages(build / "debian13")
    fast = debian13.Packages(build / "debian13-fastdds")
    if cyclone.fetch(*debian13.CYCLONE) or fast.fetch("libfastdds-dev", "libssl3t64"):
        return None
    program = build / "debian13-fastdds/fastdds_peer"
    debian13.build_fastdds_peer(source, fast, program)
    versions = [next(packages.libraries.glob(pattern)).name.split(".so.")[1]
                for packages, pattern in ((cyclone, "libddsc.so.*.*.*"), (fast, "libfastdds.so.*.*.*"))]
    return {f"cyclonedds@{versions[0]}": forecast.Product(
                "cyclonedds", cyclone.loader(cyclone.stock_plugins, build / "bin/cyclone_peer")),
            f"fastdds@{versions[1]}": forecast.Product("fastdds", fast.loader(None, program))}


def exchanges(product, folder, partner, roles):
    """In each of the roles, with the same product on the other side."""
    namespace = Namespace()
    try:
        pairs = {"publisher": (folder, partner), "subscriber": (partner, folder)}
        return all(forecast.exchange(namespace, (product, product), pairs[role], PAIR_SECONDS) for role in roles)
    finally:
        namespace.close()


def outcome(namespace, product, name, folder, partner):
    up, _ = forecast.comes_up(namespace, product, name, folder)
    if not up:
        return "fail"
    if name in PAIRED and not exchanges(product, folder, partner, PAIRED[name]):
        return "late"
    is_unsafe = name in UNSAFE or (product.name == "cyclonedds" and name in UNSAFE_WITH_CYCLONEDDS)
    return "unsafe" if is_unsafe else "ok"


def measure(products, where, names):
    """For each product what came of each folder."""
    paths = golden_folders.make_all(where, names)
    partner = where / "partner"
    golden_folders.Folder(golden_folders.Workshop(where / "workshop"), partner, "/CN=partner", "partner")
    out = {}
    for version, product in products.items():
        namespace = Namespace()
        try:
            out[version] = {name: outcome(namespace, product, name, folder, partner) for name, folder in paths.items()}
        finally:
            namespace.close()
    return out


def compare(table, results):
    """The number of outcomes that the table does not have; each is printed."""
    wrong = 0
    for version, outcomes in results.items():
        for name, did in outcomes.items():
            says = table.of(version).get(name, "nothing") if version in table.columns else "nothing"
            if says != did:
                print(f"{version}: {name}: measured {did}, the table says {says}")
                wrong += 1
    return wrong


def enter(table, results):
    """New columns begin as their older neighbour, new rows of what was not measured as the version before."""
    for version, outcomes in results.items():
        if version not in table.columns:
            vendor, number = version.split("@")
            key = [int(part) for part in number.split(".")]
            older = [column for column in table.columns if column.startswith(vendor + "@") and
                     [int(part) for part in column.split("@")[1].split(".")] < key]
            at = list(table.columns).index(older[-1])
            columns = list(table.columns.items())
            table.columns = dict([*columns[:at + 1], (version, "measured"), *columns[at + 1:]])
            for words in table.rows.values():
                words.insert(at + 1, words[at])
        column = list(table.columns).index(version)
        for name, did in outcomes.items():
            table.rows.setdefault(name, ["ok"] * len(table.columns))[column] = did
    table.rows = {name: table.rows[name] for name in golden_folders.FOLDERS if name in table.rows}
    table.write()


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("source", type=lambda text: pathlib.Path(text).resolve())
    options.add_argument("build", type=lambda text: pathlib.Path(text).resolve())
    options.add_argument("--newer", action="store_true")
    options.add_argument("--write", action="store_true")
    options.add_argument("folders", nargs="*")
    chosen = options.parse_intermixed_args()
    products = newer(chosen.source, chosen.build) if chosen.newer else forecast.installed(chosen.build)
    if products is None:
        print("NOT RUN: Debian 13's packages cannot be had; the reason is above")
        return 77
    products.pop("ddssec", None)
    table = forecast.Table(chosen.source)
    with tempfile.TemporaryDirectory(prefix="ddssec-measure-") as where:
        results = measure(products, pathlib.Path(where), chosen.folders or None)
    wrong = compare(table, results)
    count = sum(map(len, results.values()))
    print(f"{', '.join(results)}: {count} outcomes, {wrong} not as in {table.path.name}")
    if chosen.write:
        enter(table, results)
    return 1 if wrong and not chosen.write else 0


if __name__ == "__main__":
    sys.exit(main())
