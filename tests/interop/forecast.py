"""Starts products on participants' folders, and reads the table of what they did (governance/doctor/measured_outcomes.def)."""

import os
import pathlib
import re
import subprocess

FILES = {"identity_ca": ("identity_ca.pem", "identity_ca.cert.pem"), "identity_certificate": ("cert.pem",),
         "private_key": ("key.pem",), "permissions_ca": ("permissions_ca.pem", "permissions_ca.cert.pem"),
         "governance": ("governance.p7s",), "permissions": ("permissions.p7s",), "crl": ("crl.pem",)}
COLUMN = re.compile(r"^COLUMN\((\w+), (\d+), (\d+), (\d+), (\w+)\)$", re.M)
ROW = re.compile(r"^ROW\((\w+), +([a-z, ]+)\)$", re.M)


class Table:
    """The columns, as "cyclonedds@0.10.2" and how each is known, and the rows: folder to one word a column."""

    def __init__(self, source):
        self.path = pathlib.Path(source) / "governance/doctor/measured_outcomes.def"
        text = self.path.read_text()
        self.head = text[:COLUMN.search(text).start()]
        self.columns = {f"{name}@{'.'.join(version)}": how for name, *version, how in COLUMN.findall(text)}
        self.rows = {row.replace("_", "-"): re.split(r", *", words) for row, words in ROW.findall(text)}

    def outcome(self, folder, product):
        return self.rows[folder][list(self.columns).index(product)]

    def of(self, product):
        return {folder: self.outcome(folder, product) for folder in self.rows}

    def write(self):
        columns = [f"COLUMN({name}, {', '.join(version.split('.'))}, {how})"
                   for name, version, how in ((*column.split("@"), how) for column, how in self.columns.items())]
        rows = [f"ROW({folder.replace('-', '_') + ',':<38} " + "".join(f"{word + ',':<8}" for word in words).rstrip(" ,") + ")"
                for folder, words in self.rows.items()]
        self.path.write_text("\n".join([self.head + columns[0], *columns[1:],
                                        "// ROW(folder, an outcome for each column)", *rows]) + "\n")


class Product:
    """A product as a test peer runs it."""

    def __init__(self, name, command, environment=None):
        self.name = name
        self.command = command  # what comes before the peer's options
        self.environment = environment or {}

    def start_words(self, folder, role, topic, seconds):
        return [*map(str, self.command), role, "--topic", topic, "--timeout", str(seconds), *security(folder)]

    def variables(self):
        out = {**os.environ, "TZ": "UTC"}
        out.pop("LD_LIBRARY_PATH", None)
        return {**out, **self.environment}


def security(folder):
    out = []
    for option, names in FILES.items():
        there = [folder / name for name in names if (folder / name).exists()]
        if there or option != "crl":
            out += ["--" + option, str((there or [folder / names[0]])[0])]
    return out


def topic_of(name):
    return "rt/chatter" if name == "sros2-keystore" else "Square"


def comes_up(namespace, product, name, folder):
    """Whether the product's participant is created, and the process does not end by a signal; and what was printed."""
    command = namespace.enter(product.start_words(folder, "--publish", topic_of(name), 0))
    done = subprocess.run(command, text=True, capture_output=True, timeout=60, env=product.variables(), check=False)
    return not has_crashed(done.returncode) and "refused participant" not in done.stdout, done.stdout + done.stderr


def has_crashed(returncode):
    """Whether a signal ended the process, also where a shell ran it."""
    return returncode < 0 or returncode > 128


def exchange(namespace, products, folders, limit=10, topic="Square"):
    """Whether a publisher and a subscriber exchanged all samples. Fast DDS starts first: one in ten
    times it and a Cyclone DDS that runs already, stock or with ours, miss each other's handshake.
    README.md of this folder says what else takes some pairs beyond four seconds."""
    running = []
    for product, folder, role in sorted(zip(products, folders, ("--publish", "--subscribe")),
                                        key=lambda one: not one[0].name.startswith("fastdds")):
        one = subprocess.Popen(namespace.enter(product.start_words(folder, role, topic, limit)), text=True,
                               stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, env=product.variables())
        running.append((one, one.stdout.readline()))  # it says that it was created
    for one, _ in running:
        one.communicate(timeout=60)
    return [one.returncode for one, _ in running] == [0, 0]


def installed(build):
    """The products of this machine by their names with versions, and ours."""
    cyclone, fast = build / "bin/cyclone_peer", build / "bin/fastdds_peer"
    return {
        version_of("cyclonedds", cyclone, r"libddsc\.so\.\S+"): Product("cyclonedds", [cyclone]),
        version_of("fastdds", fast, r"libfast(?:rtps|dds)\.so\.\S+"): Product("fastdds", [fast]),
        "ddssec": Product("ddssec", [cyclone], {"LD_LIBRARY_PATH": str(build / "dropin")})}


def version_of(name, program, library):
    """The version in the name of the library that the program would load."""
    listed = subprocess.run(["ldd", program], text=True, capture_output=True, check=True).stdout
    path = re.search(library + r" => (\S+)", listed)[1]
    return f"{name}@{pathlib.Path(path).resolve().name.split('.so.')[1]}"
