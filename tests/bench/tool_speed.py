#!/usr/bin/env python3
"""What the ddssec program needs: a fleet against the raw operations of OpenSSL, a document of 1 MB, its start.

Usage: tool_speed.py BUILD [--fleet N]     BUILD is a build folder with bin/ddssec and
bin/bench_openssl_operations. Processor seconds, so that other work on the machine counts little; the
raw operations are measured in the same run, before and after.
"""

import argparse
import pathlib
import resource
import subprocess
import tempfile

NOW = ("--now", "2026-11-21T00:00:00Z")


def seconds(words, folder):
    """Processor seconds of one run: of the program itself, and of the system for it."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(words, cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=False)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime - before.ru_utime, after.ru_stime - before.ru_stime


def least(words, folder, rounds):
    return min(sum(seconds(words, folder)) for _ in range(rounds))


def fleet(program, raw, folder, count):
    (folder / "fleet.toml").write_text("\n".join(
        f'[[participant]]\nname = "p{i}"\npublish = ["rt/p{i}"]\nsubscribe = ["rt/*"]' for i in range(count)))
    subprocess.run([program, "ca", "create", "ca", "--no-passphrase", *NOW], cwd=folder, check=True,
                   stdout=subprocess.DEVNULL)

    def operations():
        lines = subprocess.run([raw, str(count)], capture_output=True, text=True, check=True).stdout.split()
        return float(lines[1]), float(lines[3])
    first = operations()
    ours, system = seconds([program, "identity", "issue", "--from", "fleet.toml", "--ca", "ca", "-o", "out", *NOW],
                           folder)
    bare, forms = (sum(pair) / 2 for pair in zip(first, operations()))
    assert len(list((folder / "out").iterdir())) == count
    print(f"identity issue --from, {count} participants with permissions: {ours + system:.2f} s"
          f" ({system:.2f} s of the system for {5 * count} files)")
    print(f"  OpenSSL, a key and two signatures for each: {bare:.3f} s; our own part is {ours / bare:.1f} times that")
    print(f"  the same as X.509, PKCS#8 and S/MIME in memory: {forms:.3f} s; {ours / forms:.1f} times that")


def documents(program, folder):
    subprocess.run([program, "governance", "new", "-o", "g.xml", *NOW], cwd=folder, check=True,
                   stdout=subprocess.DEVNULL)
    text = (folder / "g.xml").read_text()
    begin, end = text.index("      <topic_rule>"), text.index("    </topic_access_rules>")
    rule = text[begin:end]
    many = "".join(rule.replace(">*<", f">rt/robot{i % 50}/part{i}{'*' if i % 3 else ''}<")
                   for i in range(1_000_000 // len(rule)))
    (folder / "big.xml").write_text(text[:begin] + many + text[begin:])
    size = (folder / "big.xml").stat().st_size / 1e6
    for verb in ("lint", "show"):
        print(f"governance {verb} of {size:.2f} MB: {least([program, 'governance', verb, 'big.xml'], folder, 5):.3f} s")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("build", type=pathlib.Path)
    parser.add_argument("--fleet", type=int, default=1000)
    options = parser.parse_args()
    program = (options.build / "bin/ddssec").resolve()
    raw = (options.build / "bin/bench_openssl_operations").resolve()
    with tempfile.TemporaryDirectory(prefix="ddssec-speed-") as name:
        folder = pathlib.Path(name)
        fleet(program, raw, folder, options.fleet)
        documents(program, folder)
        print(f"--help: {1000 * least([program, '--help'], folder, 20):.1f} ms of processor time at best")


if __name__ == "__main__":
    main()
