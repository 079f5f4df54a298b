#!/usr/bin/env python3
"""What `ddssec doctor` and `check` predict is what the products do: participants are started on the
folders of tests/cli/golden_folders.py, and on pairs of them.

Usage: doctor_test.py SOURCE BUILD [--ours | FOLDER...]
--ours: our plugins alone on every folder; measure.py starts the stock products on them.
"""

import datetime
import pathlib
import subprocess
import sys
import tempfile

SOURCE, BUILD = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()
sys.path.insert(0, str(SOURCE / "tests/cli"))

import fastdds_permissions  # noqa: E402
import forecast  # noqa: E402
import golden_folders  # noqa: E402
from pair import Namespace  # noqa: E402

CHOSEN = ("correct", "sros2-keystore", "key-of-another", "p384", "permissions-by-itself",
          "form-nocerts", "form-opaque-text", "subject-slashes", "subject-blanks", "subject-trailing-comma",
          "subject-line-break", "grant-second",
          "governance-other-domain", "governance-order", "governance-pre-shared-key",
          "governance-key-revision", "identity-below-intermediate", "x509-v1-ca", "x509-v1-permissions-ca",
          "identity-sha512", "form-crcrlf", "governance-bom", "governance-doctype", "governance-escaped-quotes")
# Of ours only embedded participants take them.
EMBEDDED_ONLY = ("governance-key-revision",)
MEASURED_FASTDDS = "fastdds@2.9.1"
EMBEDDED = forecast.Product("embedded", [BUILD / "bin/embedded_peer"])


def of_ours():
    """Our verdicts: the second column of doctor_golden.txt."""
    rows = (line.split() for line in (SOURCE / "tests/cli/doctor_golden.txt").read_text().splitlines()
            if line and not line.startswith("#"))
    return {name: verdict for name, verdict, *_ in rows}


def verdict_of(table, version, name):
    """What the table says; nothing of a version that it lacks."""
    if version == "ddssec":
        return of_ours()[name]
    return table.outcome(name, version) if version in table.columns else None


def alone(namespace, paths, products):
    """Whether each participant comes up, against the table: only `fail` says that it does not."""
    wrong, table = 0, forecast.Table(SOURCE)
    for name, folder in paths.items():
        for version, product in products.items():
            verdict = verdict_of(table, version, name)
            if verdict is None:
                continue
            host = EMBEDDED if version == "ddssec" and name in EMBEDDED_ONLY else product
            up, output = forecast.comes_up(namespace, host, name, folder)
            if up != (verdict != "fail"):
                print(f"{name}: doctor says {verdict} for {version}, but it came up: {up}\n{output}")
                wrong += 1
    return wrong


def foretold(products, folders):
    """Whether `check` says that they talk, and whether of ddssec it means the embedded participant alone."""
    words = [str(BUILD / "bin/ddssec"), "check", *map(str, folders), "--topics", "Square", "--require",
             "writer=A", "--vendor", "A=" + products[0], "--vendor", "B=" + products[1]]
    done = subprocess.run(words, capture_output=True, text=True, timeout=60, check=False)
    return done.returncode == 0, "only of ddssec's embedded participant" in done.stdout + done.stderr


def together(namespace, where, products):
    """Both products in both places: who starts the handshake decides."""
    shop = golden_folders.Workshop(where / "pair")
    folders = []
    for name in ("talker", "listener"):
        golden_folders.Folder(shop, where / name, f"/CN={name}", name)
        folders.append(where / name)
    wrong, seen = 0, set()
    cyclone, fast, ours = products
    for pair in ((cyclone, fast), (fast, cyclone), (fast, ours)):
        said, embedded_only = foretold(pair, folders)
        tried = [(" -> ".join(pair), said and not embedded_only, [products[one] for one in pair])]
        if embedded_only:
            tried.append((f"{fast} -> embedded", said, [products[fast], EMBEDDED]))
        for text, says, both in tried:
            did = forecast.exchange(namespace, both, folders)
            print(f"{text}: foretold {says}, happened {did}")
            wrong += says != did
            seen.add(did)
    return wrong + (seen != {True, False})


def limits_of_fastdds(namespace, where, product):
    """Pairs of Fast DDS with permissions that it does not use as they say."""
    tool, wrong = str(BUILD / "bin/ddssec"), 0
    subprocess.run([tool, "init", "limits", "-q"], cwd=where, check=True)
    folders = [where / "limits" / name for name in ("talker", "listener")]
    for text, end, rules, is_heard, _ in fastdds_permissions.rows(datetime.datetime.now(datetime.timezone.utc)):
        for folder in folders:
            document = fastdds_permissions.DOCUMENT.format(name=folder.name, end=end, rules=rules)
            (where / "limits.xml").write_text(document)
            subprocess.run([tool, "permissions", "sign", "limits.xml", "--ca", "limits", "-o", folder / "permissions.p7s",
                            "--replace", "--no-lint", "-q"], cwd=where, check=True)
        did = forecast.exchange(namespace, [product, product], folders, topic=fastdds_permissions.TOPIC)
        print(f"Fast DDS, permissions {text}: foretold {is_heard}, happened {did}")
        wrong += did != is_heard
    return wrong


def main():
    only_ours = sys.argv[3:] == ["--ours"]
    products = forecast.installed(BUILD)
    with tempfile.TemporaryDirectory(prefix="ddssec-doctor-") as where:
        paths = golden_folders.make_all(where, None if only_ours else sys.argv[3:] or CHOSEN)
        namespace = Namespace()
        try:
            if only_ours:
                products = {"ddssec": products["ddssec"]}
                wrong = alone(namespace, paths, products)
            else:
                wrong = alone(namespace, paths, products) + together(namespace, pathlib.Path(where), products)
                if MEASURED_FASTDDS in products:
                    wrong += limits_of_fastdds(namespace, pathlib.Path(where), products[MEASURED_FASTDDS])
        finally:
            namespace.close()
    print(f"{len(paths)} folders with {', '.join(products)}: {wrong} not as foretold")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
