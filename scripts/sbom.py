#!/usr/bin/env python3
"""Writes the bill of materials of an installed folder (scripts/sbom.sh).
Usage: sbom.py INSTALLED BUILD FILE"""

import datetime
import json
import os
import pathlib
import re
import subprocess
import sys
import uuid

# Debian's names of licences, in SPDX's words.
SPDX = {"apache-2.0": "Apache-2.0", "isc": "ISC", "zlib": "Zlib", "zlib/libpng": "Zlib", "expat": "MIT", "mit": "MIT",
        "expat with embedded exception": "MIT", "bsd-2-clause": "BSD-2-Clause", "bsd-3-clause": "BSD-3-Clause",
        "gpl-2+": "GPL-2.0-or-later", "gpl-3+": "GPL-3.0-or-later", "lgpl-2.1+": "LGPL-2.1-or-later",
        "bsd-3-clause or epl-2": "BSD-3-Clause OR EPL-2.0"}
# Of packages whose copyright file has no fields, by their source.
BY_SOURCE = [("gcc-", "GPL-3.0-or-later WITH GCC-exception-3.1"), ("glibc", "LGPL-2.1-or-later"), ("libpcap", "BSD-3-Clause")]
NOT_COMPILED_IN = {"linux", "glibc"}  # constants and declarations only


def output_of(*command):
    return subprocess.run(command, check=True, text=True, capture_output=True).stdout


def needed_by(file):
    return re.findall(r"\(NEEDED\).*\[(.+)\]", output_of("readelf", "-dW", file))


def is_elf(file):
    with open(file, "rb") as opened:
        return opened.read(4) == b"\x7fELF"


def places_of(file):
    """Where the loader finds each library that a file needs, directly or not."""
    return {name: pathlib.Path(place).resolve() for name, place in re.findall(r"(\S+) => (/\S+)", output_of("ldd", file))} | {
        pathlib.Path(place).name: pathlib.Path(place).resolve()
        for place in re.findall(r"^\s+(/\S*ld-linux\S*) \(", output_of("ldd", file), re.MULTILINE)}


def owners_of(files):
    """The Debian package of each file; dpkg knows a file of /lib or /usr/lib by one of the two names."""
    wanted = {}
    for file in map(str, files):
        bare = file.removeprefix("/usr")
        wanted |= {bare: file, "/usr" + bare: file}
    said = subprocess.run(["dpkg-query", "--search", *wanted], text=True, capture_output=True, check=False).stdout
    owners = {}
    for line in said.splitlines():
        package, _, file = line.partition(": ")
        if file in wanted:
            owners[wanted[file]] = package.split(",")[0].split(":")[0]
    return owners


class Package:
    def __init__(self, name):
        fields = "${Version}\t${Architecture}\t${source:Package}\t${Homepage}\n"
        line = output_of("dpkg-query", "--show", "--showformat", fields, name).splitlines()[0]
        self.name = name
        self.version, self.architecture, self.source, self.homepage = line.split("\t")

    def reference(self):
        release = pathlib.Path("/etc/os-release").read_text(encoding="utf-8")
        distribution = re.search(r'^VERSION_ID="?([\d.]+)', release, re.MULTILINE)
        suffix = f"&distro=debian-{distribution[1]}" if distribution else ""
        version = self.version.replace(":", "%3A").replace("+", "%2B")
        return f"pkg:deb/debian/{self.name.replace('+', '%2B')}@{version}?arch={self.architecture}{suffix}"

    def licence(self):
        """SPDX expression, or what the copyright file says of `Files: *`."""
        file = pathlib.Path(f"/usr/share/doc/{self.name}/copyright")
        text = file.read_text(encoding="utf-8", errors="replace") if file.is_file() else ""
        stated = re.search(r"^Files:\s+\*\s*$.*?^License:[ \t]*(.+?)\s*$", text, re.MULTILINE | re.DOTALL)
        if stated:
            name = stated[1]
            return {"expression": SPDX[name.lower()]} if name.lower() in SPDX else {"license": {"name": name}}
        for source, expression in BY_SOURCE:
            if self.source.startswith(source):
                return {"expression": expression}
        return {"license": {"name": f"see {file}"}}

    def component(self, use):
        out = {"type": "library", "bom-ref": self.reference(), "name": self.name, "version": self.version,
               "purl": self.reference(), "licenses": [self.licence()],
               "properties": [{"name": "ddssec:use", "value": use}, {"name": "ddssec:debian-source", "value": self.source}]}
        if self.homepage:
            out["externalReferences"] = [{"type": "website", "url": self.homepage}]
        return out


def header_packages(build):
    """Packages whose headers were compiled into what is installed."""
    deps = output_of("ninja", "-C", str(build), "-t", "deps")
    headers = set()
    for block in re.split(r"\n(?=\S)", deps):
        if not block.startswith("tests/"):
            headers |= set(re.findall(r"^\s+(/usr/(?:include|lib)/\S+)$", block, re.MULTILINE))
    files = sorted({str(pathlib.Path(header).resolve()) for header in headers})
    return set(owners_of(files).values()) if files else set()


def version_of(build):
    return re.search(r"CMAKE_PROJECT_VERSION:STATIC=(\S+)", (build / "CMakeCache.txt").read_text(encoding="utf-8"))[1]


def bill(installed, build):
    version = version_of(build)
    own = sorted(file for file in installed.rglob("*") if file.is_file() and not file.is_symlink() and is_elf(file))
    places, edges = {}, {}
    for file in own:
        places |= places_of(file)
    owners = owners_of(places.values())
    package_of = {name: owners[str(place)] for name, place in places.items() if str(place) in owners}
    missing = sorted(set(places) - set(package_of))
    if missing:
        sys.exit(f"sbom.py: no Debian package has {', '.join(missing)}")
    packages = {name: Package(name) for name in sorted(set(package_of.values()))}
    for name, place in places.items():
        edge = edges.setdefault(packages[package_of[name]].reference(), set())
        edge |= {packages[package_of[other]].reference() for other in needed_by(place) if other in package_of}
    linked_sources = {package.source for package in packages.values()}
    compiled = [package for package in map(Package, sorted(header_packages(build) - set(packages)))
                if package.source not in linked_sources | NOT_COMPILED_IN]

    product = f"pkg:generic/ddssec@{version}"
    components, direct = [], set()
    for file in own:
        name = file.relative_to(installed).as_posix()
        components.append({"type": "library" if name.endswith(".so") else "application", "bom-ref": f"{product}#{name}",
                           "name": name, "version": version, "licenses": [{"expression": "Apache-2.0"}]})
        edges[f"{product}#{name}"] = {packages[package_of[other]].reference() for other in needed_by(file)}
        direct |= edges[f"{product}#{name}"]
    components += [package.component("linked" if package.reference() in direct else "linked by another library")
                   for package in packages.values()]
    components += [package.component("compiled in: headers") for package in compiled]
    edges[product] = {f"{product}#{file.relative_to(installed).as_posix()}" for file in own} | {
        package.reference() for package in compiled}
    for package in compiled:
        edges.setdefault(package.reference(), set())
    time = datetime.datetime.fromtimestamp(int(os.environ["SOURCE_DATE_EPOCH"]), datetime.timezone.utc)
    return {
        "bomFormat": "CycloneDX", "specVersion": "1.5", "version": 1,
        "metadata": {"timestamp": time.strftime("%Y-%m-%dT%H:%M:%SZ"),
                     "component": {"type": "application", "bom-ref": product, "name": "ddssec", "version": version,
                                   "licenses": [{"expression": "Apache-2.0"}], "purl": product}},
        "components": components,
        "dependencies": [{"ref": reference, "dependsOn": sorted(edge - {reference})} for reference, edge in sorted(edges.items())],
    }


def main():
    installed, build, out = map(pathlib.Path, sys.argv[1:])
    document = bill(installed, build)
    # The same content has the same number.
    number = uuid.uuid5(uuid.NAMESPACE_URL, json.dumps(document, sort_keys=True))
    document = {"bomFormat": document.pop("bomFormat"), "specVersion": document.pop("specVersion"),
                "serialNumber": f"urn:uuid:{number}", **document}
    out.write_text(json.dumps(document, indent=2) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
