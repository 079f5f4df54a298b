#!/usr/bin/env python3
"""Holds what scripts/demo.sh and the target ddssec_all build to the documents: what the demo runs itself, what README's
first lines run, which build ddssec_all before the demo, and what the pages run."""

import pathlib
import re
import sys

# A program of ours where a shell looks for a command.
COMMAND = re.compile(r"(?:^|[|;&(]|\bsudo\s|\b\w+=\S*\s)\s*(ddssec(?:-[a-z]+)*)(?=\s|$)")
BUILT = re.compile(r"(?:build/release|\$build|\$\{build\})\"?/(?:bin/([\w-]+)|(dropin))")
CODE = re.compile(r"^```(?:sh|text)\n(.*?)^```|^    ([^\n]*)$", re.MULTILINE | re.DOTALL)


def list_of_demo(text):
    """The arguments of its function `build`: targets."""
    return set(" ".join(re.findall(r"^ *build ([a-z][\w -]*?)(?: >.*)?$", text, re.MULTILINE)).split())


def list_of_all(text):
    """What ddssec_all depends on, whatever else is there."""
    return set(" ".join(re.findall(r"(?:add_custom_target\(ddssec_all DEPENDS|add_dependencies\(ddssec_all)([^)]*)\)",
                                   text)).split())


def run_by(text):
    """The targets that make what the shell text runs."""
    out = {program or "ddssec_dropin" for program, _ in BUILT.findall(text)}
    for line in text.splitlines():
        out.update(COMMAND.findall(line.split(" #")[0]))
    return out


def code_of(page):
    return "\n".join(block or line for block, line in CODE.findall(page))


def faults(root):
    demo = (root / "scripts/demo.sh").read_text(encoding="utf-8")
    built, every = list_of_demo(demo), list_of_all((root / "CMakeLists.txt").read_text(encoding="utf-8"))
    used = run_by(demo) - {"$program"} | set(re.findall(r"\bprogram=(\w+)", demo))
    yield from (f"scripts/demo.sh runs {name}, and does not build it" for name in sorted(used - built))
    readme = re.search(r"^## Try it\n(.*?)^## ", (root / "README.md").read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)
    first = code_of(readme.group(1)) if readme else ""
    if "ddssec" not in run_by(first) or "ddssec_dropin" not in run_by(first):
        yield "README.md, Try it: no line with the tool and the drop-in folder was found"
    if not re.search(r"--target ddssec_all\b.*scripts/demo\.sh", first, re.DOTALL):
        yield "README.md, Try it: ddssec_all is not built before scripts/demo.sh, which does not build the tool"
    yield from (f"README.md runs {name}, which ddssec_all does not build" for name in sorted(run_by(first) - every))
    for page in sorted((root / "docs").glob("*.md")):
        text = page.read_text(encoding="utf-8")
        needs = run_by(code_of(text))
        if "scripts/demo.sh" in text and "--target ddssec_all" not in text:
            yield from (f"docs/{page.name} runs {name}, which scripts/demo.sh does not build" for name in sorted(needs - built))
        yield from (f"docs/{page.name} runs {name}, which ddssec_all does not build" for name in sorted(needs - every))


def main():
    found = list(faults(pathlib.Path(sys.argv[1])))
    for fault in found:
        print(fault)
    print(f"{len(found)} faults between scripts/demo.sh and the documents")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
