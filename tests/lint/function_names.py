#!/usr/bin/env python3
"""The name of a function agrees with what the function returns.

A function that makes an Error, or a std::unexpected<Error>, has a name that ends in _error, or in _event if the Error is
only raised as an event. One that adds details to an error begins with with_. The verbs of VERBS have one kind of result
each (docs/contributing.md, Code). Exit 1 and a line for each fault.

Usage: function_names.py SOURCE_FOLDER
"""

import pathlib
import re
import sys

FOLDERS = ("base", "wire", "pki", "governance", "plugins", "rtps", "secured", "cli", "programs", "idl")
FUNCTION = re.compile(r"(?:^|\n)[ \t]*(?:(?:public|private|protected):\s*)?(?:template\s*<[^;{}()]*>\s*)?"
                      r"(?P<type>[A-Za-z_\[][\w:<>,\s*&\[\]]*?[\w>*&])\s+(?:\w+::)*(?P<name>[a-z]\w*)\s*\(")
NO_TYPE = {"return", "co_return", "else", "new", "case", "throw", "using", "delete"}
SPECIFIERS = re.compile(r"\b(static|virtual|inline|friend|constexpr|explicit|ddssec::)\b|\[\[nodiscard\]\]|\bddssec::")
MAKES_ERROR = re.compile(r"(std::unexpected<Error>|Error)$")
ERROR_NAME = re.compile(r"(\w+_)?(error|event)$|with_\w+$")
# (the verb, the results that its functions have, what to do about others)
VERBS = [
    ("check", re.compile(r"(Status|(\w+::)*(Memory)?Result<.+>)$"),
     "check_ returns a Status or a Result; a condition is is_ or has_, and what adds findings is diagnose_"),
    ("diagnose", re.compile(r"(void|Diagnosis)$"), "diagnose_ adds findings and returns nothing"),
    ("judge", re.compile(r"(?!(void|bool|Status|Result<bool>)$).+$"), "judge returns a verdict: a type of its own"),
]

# Functions that make an error and have another name.
OTHER_NAMES = {
    ("base/result.hpp", "fail"): "the short word for all of them",
    ("base/renewal_refusals.hpp", "note"): "records the error, and returns it",
    ("cli/commands/check_commands.cpp", "check_commands"): "the commands of the group \"check\"",
    ("cli/commands/groups.hpp", "check_commands"): "the commands of the group \"check\"",
    ("governance/doctor/diagnosis.cpp", "check_for"): "the check, a noun",
    ("governance/doctor/diagnosis.hpp", "check_for"): "the check, a noun",
}
# The host's interface in C prescribes these names and their result.
PRESCRIBED = re.compile(r"plugins/cyclonedds/\w+_adapter\.cpp$"), "DDS_Security_boolean"


def files_in(root):
    return (path for folder in FOLDERS for path in sorted((root / folder).rglob("*.[ch]pp")))


def functions_in(text):
    """(line, type, name) of each function that is declared or defined with its type before its name."""
    text = re.sub(r'"(?:\\.|[^"\\\n])*"', '""', re.sub(r"//[^\n]*", "", text))
    for found in FUNCTION.finditer(text):
        kind = " ".join(SPECIFIERS.sub(" ", found["type"]).split())
        if kind and kind.split()[0] not in NO_TYPE:
            yield text.count("\n", 0, found.start("name")) + 1, kind, found["name"]


def fault_of(kind, name):
    """What is wrong with the name of a function that returns `kind`, or nothing."""
    if MAKES_ERROR.fullmatch(kind) and not ERROR_NAME.fullmatch(name):
        return "it makes an error: end the name in _error"
    for verb, results, advice in VERBS:
        if re.match(verb + r"(_|$)", name) and not results.fullmatch(kind):
            return advice
    return ""


# What the rules say of a few functions: the lint's own test.
EXAMPLES = [
    ("Error refusal(Code code);", False),
    ("  static std::unexpected<Error> refuse(int handle) {", False),
    ("inline std::unexpected<Error> limit_error(int limit) {", True),
    ("Error ListedRenewals::taken_event() const {", True),
    ("Error with_hint(const Error& error);", True),
    ("  const Error& error() const;", True),
    ("  Error first;", True),
    ("  return refuse(Code::internal);", True),
    ("Status check_name(std::string_view name);", True),
    ("Result<Admission::Permission> Admission::check_permissions(const Guid& peer) {", True),
    ("  void check_deadlines(MonotonicTime now);", False),
    ("bool Header::check(const void* node) {", False),
    ("void diagnose_files(const LoadedFolder& folder, Diagnosis& out);", True),
    ("Status diagnose_files(const LoadedFolder& folder);", False),
    ("Decision judge(const ParticipantData& data);", True),
    ("  Status judge(BytesView file);", False),
]


def main():
    root = pathlib.Path(sys.argv[1]).resolve()
    found, count, used = [], 0, set()
    for example, is_right in EXAMPLES:
        if is_right == any(fault_of(kind, name) for _, kind, name in functions_in(example)):
            found.append(f"{__file__}: the example is judged wrongly: {example}")
    for path in files_in(root):
        file = path.relative_to(root).as_posix()
        for line, kind, name in functions_in(path.read_text(encoding="utf-8")):
            count += 1
            fault = fault_of(kind, name)
            if PRESCRIBED[0].match(file) and kind == PRESCRIBED[1]:
                continue
            if fault and (file, name) in OTHER_NAMES:
                used.add((file, name))
            elif fault:
                found.append(f"{file}:{line}: {name}: {fault}")
    found += [f"{file}: {name} needs no exception" for file, name in sorted(OTHER_NAMES.keys() - used)]
    print("\n".join(found) if found else f"the names of {count} functions agree with their results")
    return 1 if found or not count else 0


if __name__ == "__main__":
    sys.exit(main())
