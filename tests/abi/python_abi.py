"""python_abi.py HEADER MODULE [--update]: the declarations of the C header as ctypes, against the checked-in module.

--update writes the module. What is declared where: structs with their fields, constants without the BCCSPLAT_ prefix,
callback types, and for every function its result and arguments. Handles and arrays are void pointers; fields that look at
numbers which the library reads have the type of these.
"""
import difflib
import re
import sys

SCALARS = {"int32_t": "c_int32", "uint32_t": "c_uint32", "int64_t": "c_int64", "uint64_t": "c_uint64",
           "double": "c_double", "float": "c_float", "void": "None"}
PYTHON_TYPES = {"c_double": "float", "c_float": "float", "c_char_p": "str", "c_void_p": "Any"}


def camel(name):
    return "".join(part.capitalize() for part in name.removeprefix("bccsplat_").split("_"))


class Header:
    def __init__(self, text):
        self.defines = re.findall(r"^#define BCCSPLAT_(\w*VERSION\w*) (\d+)$", text, re.M)
        text = re.sub(r"/\*.*?\*/", " ", text, flags=re.S)
        text = re.sub(r"^#.*?(?<!\\)$", "", text, flags=re.M | re.S)
        text = re.sub(r'extern "C" \{', "", text)
        self.constants, self.structs, self.callbacks, self.functions = [], [], [], []
        SCALARS.update({name: SCALARS[base] for base, name in re.findall(r"typedef\s+(\w+)\s+(bccsplat_\w+)\s*;", text)})
        declaration = re.compile(
            r"enum\s*\{(?P<enum>[^}]*)\}\s*;"
            r"|typedef\s+struct\s+(?P<struct>\w+)\s*\{(?P<fields>[^}]*)\}\s*\w+\s*;"
            r"|typedef\s+(?P<cb_result>\w+)\s*\(\*(?P<callback>\w+)\)\((?P<cb_args>[^)]*)\)\s*;"
            r"|BCCSPLAT_API\s+(?P<result>[\w\s*]+?)\s*\b(?P<function>bccsplat_\w+)\s*\((?P<args>[^)]*)\)\s*;")
        found = list(declaration.finditer(text))
        self.struct_names = {m["struct"] for m in found if m["struct"]}
        self.callback_names = {m["callback"] for m in found if m["callback"]}
        for m in found:
            if m["enum"]:
                self.enum(m["enum"])
            elif m["struct"]:
                self.structs.append((m["struct"], self.fields(m["fields"])))
            elif m["callback"]:
                self.callbacks.append((m["callback"], self.type(m["cb_result"]), self.arguments(m["cb_args"])))
            elif m["function"]:
                self.functions.append((m["function"], self.type(m["result"]), self.arguments(m["args"])))

    def enum(self, body):
        for item in filter(None, (part.strip() for part in body.split(","))):
            name, value = re.fullmatch(r"BCCSPLAT_(\w+)\s*=\s*(-?\w+)", item).groups()
            self.constants.append((name, int(value, 0)))

    def type(self, text):
        """ctypes name of a C type; `text` has neither declarator nor array length."""
        base = " ".join(text.replace("const", " ").replace("*", " ").split())
        stars = text.count("*")
        if base == "char" and stars == 1:
            return "c_char_p"
        if stars == 0:
            return base if base in self.callback_names else SCALARS[base]
        if stars == 1 and base in self.struct_names:
            return f"POINTER({camel(base)})"
        return "c_void_p"

    def arguments(self, text):
        if text.strip() == "void":
            return []
        pointers = re.sub(r"(\w+)\[\d+\]", r"*\1", text)
        return [self.type(re.sub(r"\w+$", "", argument.strip())) for argument in pointers.split(",")]

    def fields(self, body):
        out = []
        for line in filter(None, (part.strip() for part in body.split(";"))):
            first, *more = [part.strip() for part in line.split(",")]
            base, name = re.fullmatch(r"([\w\s*]+?)\s*\b(\w+(?:\[\w+\])*)", first).groups()
            for declarator in [name, *more]:
                field, *lengths = re.findall(r"\w+", declarator)
                kind = self.type(base)
                if kind == "c_void_p" and (looked := re.fullmatch(r"const (\w+)\s*\*", base)) and looked[1] in SCALARS and looked[1] != "void":
                    kind = f"POINTER({SCALARS[looked[1]]})"
                for length in reversed(lengths):
                    kind = f"{kind} * {length}"
                out.append((field, kind))
        return out


def annotation(kind):
    if "*" in kind:
        element, *lengths = kind.split(" * ")
        python = element
        for _ in lengths:
            python = f"Array[{python}]"
        return python
    if kind.startswith(("POINTER", "bccsplat_")):
        return "Any"
    return PYTHON_TYPES.get(kind, "int")


def wrapped(prefix, items, suffix):
    lines, line = [], prefix
    for i, item in enumerate(items):
        text = item + (suffix if i + 1 == len(items) else ", ")
        if len(line) + len(text.rstrip()) > 110:
            lines.append(line.rstrip())
            line = " " * prefix.index(prefix.lstrip()[0]) + "    "
        line += text
    return lines + [line]


def module(header):
    yield '"""The C declarations of bccsplat.h, written by tests/abi/python_abi.py: do not edit."""'
    yield "# fmt: off"
    yield "from __future__ import annotations"
    yield ""
    yield "from ctypes import (CFUNCTYPE, POINTER, Array, c_char_p, c_double, c_float, c_int32, c_int64, c_uint32,"
    yield "                    c_uint64, c_void_p)"
    yield "from typing import TYPE_CHECKING, Any"
    yield ""
    yield "from ._structs import Fields, Struct"
    yield ""
    for name, value in header.defines + header.constants:
        yield f"{name} = {value}"
    yield ""
    # A callback that is handed a struct follows it.
    after = {camel(name): [] for name, _ in header.structs}
    for name, result, arguments in header.callbacks:
        lines = wrapped(f"{name} = CFUNCTYPE(", [result, *arguments], ")")
        handed = [kind for kind in after if f"POINTER({kind})" in arguments]
        if handed:
            after[max(handed, key=list(after).index)] += lines
        else:
            yield from lines
    yield "\n"
    yield "def constant(kind: str, name: str) -> int:"
    yield '    """A constant of the header by its name without the prefix: constant("LATTICE", "d4star")."""'
    yield '    names = [n.removeprefix(kind + "_") for n in globals() if n.startswith(kind + "_")]'
    yield "    if not names:"
    yield "        raise ValueError(f\"{kind.lower()} is a number, not {name!r}\")"
    yield '    wanted = name.upper().replace("-", "_")'
    yield "    if wanted not in names:"
    yield "        raise ValueError(f\"{kind.lower()} {name!r} is none of: {', '.join(names).lower()}\")"
    yield '    return int(globals()[kind + "_" + wanted])'
    for name, fields in header.structs:
        sized = fields[0][0] == "struct_size"
        yield "\n"
        yield f"class {camel(name)}({'Struct' if sized else 'Fields'}):"
        for field, kind in fields[sized:]:
            yield f"    {field}: {annotation(kind)}"
        if sized:
            yield "    if TYPE_CHECKING:"
            named = [f"{field}: Any = ..." for field, _ in fields[1:] if not field.startswith("reserved")]
            yield from wrapped("        def __init__(self, *, ", named, ") -> None: ...")
        yield from wrapped("    _fields_ = [", [f'("{field}", {kind})' for field, kind in fields], "]")
        if after[camel(name)]:
            yield "\n"
            yield from after[camel(name)]
    yield "\n"
    yield "# Result and arguments of every function."
    yield "FUNCTIONS: dict[str, tuple[Any, ...]] = {"
    for name, result, arguments in header.functions:
        yield from wrapped(f'    "{name}": (', [result, *arguments], ",),")
    yield "}"


def main(header, path, update=None):
    text = "\n".join(module(Header(open(header, encoding="utf-8").read()))) + "\n"
    if update == "--update":
        open(path, "w", encoding="utf-8").write(text)
        return 0
    old = open(path, encoding="utf-8").read()
    sys.stdout.writelines(difflib.unified_diff(old.splitlines(True), text.splitlines(True), path, "from " + header))
    if old != text:
        print(f"The header has other declarations. If that is meant: python3 {sys.argv[0]} {header} {path} --update")
    return int(old != text)


if __name__ == "__main__":
    if len(sys.argv) not in (3, 4):
        sys.exit(__doc__)
    sys.exit(main(*sys.argv[1:]))
