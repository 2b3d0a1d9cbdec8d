#!/usr/bin/env python3
"""The binary interface of enamel.h: its structs and functions, read from the header.

layout.py --check: compare the stored description (lib/src/c/enamel.abi), the ctypes module and Enamel.cs with the
header. layout.py --write: write all three again, after a change that is meant. Structs are laid out by the rules of
the C interfaces of x86-64 and AArch64: every member is aligned to its size. tests/c/layout.c proves it to a compiler.
"""

import os
import re
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
HEADERS = ["lib/include/enamel/plugin/abi.h", "lib/include/enamel/plugin/driver.h",
           "lib/include/enamel/c/enamel.h"]
DESCRIPTION = "lib/src/c/enamel.abi"
PROOF = "tests/c/layout.c"
PYTHON = "plugins/ctypes/enamel_c.py"
CSHARP = "plugins/csharp/Enamel.cs"
BEGIN, END = "generated from enamel.h: begin", "generated from enamel.h: end"

SIZES = {"double": 8, "uint64_t": 8, "uint32_t": 4, "int32_t": 4, "uint16_t": 2, "size_t": 8}
PYTHON_TYPES = {"double": "c_double", "uint64_t": "c_uint64", "uint32_t": "c_uint32", "int32_t": "c_int32",
                "uint16_t": "c_uint16", "size_t": "c_size_t", "void": "None"}
CSHARP_TYPES = {"double": "double", "uint64_t": "ulong", "uint32_t": "uint", "int32_t": "int", "uint16_t": "ushort",
                "size_t": "UIntPtr", "void": "void"}


class Member:
    """A member of a struct, or a parameter: type without `const` and `*`, pointers, name, array sizes."""

    def __init__(self, text, constants):
        self.function = None
        match = re.match(r"^(.*?)\(\*(\w+)\)\((.*)\)$", text)
        if match:
            self.name, self.pointers, self.arrays, self.const = match[2], 1, [], False
            self.base = "function"
            self.function = (Member(match[1].strip() + " result", constants), parameters(match[3], constants))
            return
        match = re.match(r"^(const )?(\w+)\s*(\**)\s*(\w*)((?:\[\w+\])*)$", text)
        if not match:
            raise SystemExit("cannot read: " + text)
        self.const, self.base, self.name = bool(match[1]), match[2], match[4]
        self.pointers = len(match[3])
        self.arrays = [int(constants.get(size, size)) for size in re.findall(r"\[(\w+)\]", match[5])]

    @property
    def count(self):
        product = 1
        for size in self.arrays:
            product *= size
        return product


def parameters(text, constants):
    return [] if text.strip() in ("", "void") else [Member(one.strip(), constants) for one in text.split(",")]


class Header:
    def __init__(self):
        text = ""
        for path in HEADERS:
            with open(os.path.join(ROOT, path), encoding="utf-8") as file:
                text += file.read()
        self.constants = {name: value.rstrip("u") for name, value in re.findall(r"^#define (ENAMEL_\w+) (\d+u?)$", text, re.M)}
        text = re.sub(r"/\*.*?\*/", "", text, flags=re.S)
        text = re.sub(r"^#.*$", "", text, flags=re.M)
        self.enums = []
        for name, body in re.findall(r"enum (\w+) \{(.*?)\};", text, re.S):
            values = re.findall(r"(\w+) = (\d+)", body)
            self.enums.append((name, values))
            self.constants.update(values)
        self.opaque = [a for a, b in re.findall(r"typedef struct (\w+) (\w+);", text) if a == b]
        self.structs = {}
        for name, body in re.findall(r"typedef struct (\w+) \{(.*?)\} \w+;", text, re.S):
            members = []
            for line in " ".join(body.split()).split(";"):
                line = line.strip()
                if not line:
                    continue
                declared = re.match(r"^((?:const )?\w+ )(\w+(?:\[\w+\])*(?:, \w+(?:\[\w+\])*)+)$", line)
                if declared:
                    members += [Member(declared[1] + one, self.constants) for one in declared[2].split(", ")]
                else:
                    members.append(Member(line, self.constants))
            self.structs[name] = members
        self.callbacks = {}
        for result, name, arguments in re.findall(r"typedef (\w+) \(\*(\w+)\)\((.*?)\);", " ".join(text.split())):
            self.callbacks[name] = (Member(result + " result", self.constants), parameters(arguments, self.constants))
        self.functions = []
        for result, name, arguments in re.findall(r"ENAMEL_API ([\w ]+?\**) ?(enamel_\w+)\((.*?)\);", " ".join(text.split())):
            self.functions.append((Member(result + " result", self.constants), name, parameters(arguments, self.constants)))

    def align(self, member):
        if member.pointers or member.base in self.callbacks:
            return 8
        if member.base in self.structs:
            return max(self.align(one) for one in self.structs[member.base])
        return SIZES[member.base]

    def size(self, member):
        if member.pointers or member.base in self.callbacks:
            return 8 * member.count
        if member.base in self.structs:
            return self.layout(member.base)[0] * member.count
        return SIZES[member.base] * member.count

    def layout(self, name):
        """Return the size of a struct, and (member, offset) of each member."""
        offset, places, largest = 0, [], 1
        for member in self.structs[name]:
            step = self.align(member)
            largest = max(largest, step)
            offset = (offset + step - 1) // step * step
            places.append((member, offset))
            offset += self.size(member)
        return (offset + largest - 1) // largest * largest, places


def spelled(member):
    """Return the C type of a member or parameter."""
    if member.function:
        result, arguments = member.function
        return "%s(*)(%s)" % (spelled(result), ", ".join(spelled(a) for a in arguments))
    text = ("const " if member.const else "") + member.base + "*" * member.pointers
    return text + "".join("[%d]" % size for size in member.arrays)


def description(header):
    lines = ["The binary interface of libenamel.so for 64 bits: sizes and offsets in bytes. Written by tests/c/layout.py."]
    for name, value in sorted(header.constants.items()):
        if not name.startswith("ENAMEL_VERSION"):
            lines.append("constant %s %s" % (name, value))
    for name in header.structs:
        size, places = header.layout(name)
        lines.append("struct %s %d" % (name, size))
        lines += ["  %d %s %s" % (offset, member.name, spelled(member)) for member, offset in places]
    for name, (result, arguments) in header.callbacks.items():
        lines.append("callback %s %s(%s)" % (name, spelled(result), ", ".join(spelled(a) for a in arguments)))
    for result, name, arguments in header.functions:
        lines.append("function %s %s(%s)" % (name, spelled(result), ", ".join(spelled(a) for a in arguments)))
    return "\n".join(lines) + "\n"


def proof(header):
    lines = ["/* The layout of enamel.h as tests/c/layout.py has it, checked by the compiler. Written by it. */",
             "#include <enamel/c/enamel.h>", "", "#define CHECK(name, a, b) extern char name[(a) == (b) ? 1 : -1]", ""]
    for name in header.structs:
        size, places = header.layout(name)
        lines.append("CHECK(size_%s, sizeof(%s), %d);" % (name, name, size))
        lines += ["CHECK(at_%s_%s, offsetof(%s, %s), %d);" % (name, m.name, name, m.name, offset) for m, offset in places]
    return "\n".join(lines + ["", "int main(void) { return 0; }"]) + "\n"


class Python:
    def __init__(self, header):
        self.header = header

    def type(self, member, parameter=False):
        h = self.header
        if member.function:
            return self.callback(*member.function)
        if member.base in h.opaque:
            return "POINTER(c_void_p)" if member.pointers == 2 else "c_void_p"
        if member.base == "char":
            return "c_char_p" if member.const else "c_void_p"
        if member.base == "void":
            return "c_void_p" if member.pointers else "None"
        base = PYTHON_TYPES.get(member.base, member.base)
        if member.pointers:
            return "POINTER(%s)" % base
        for size in reversed(member.arrays):
            base = "(%s * %d)" % (base, size)
        return base

    def callback(self, result, arguments):
        return "CFUNCTYPE(%s)" % ", ".join([self.type(result)] + [self.type(a) for a in arguments])

    def text(self):
        h, out = self.header, []
        for name, values in h.enums:
            out += ["%s = %s" % value for value in values] + [""]
        for name in ("ENAMEL_MAX_CONTACTS", "ENAMEL_MAX_JOINTS", "ENAMEL_MAX_TOOL_PARTS", "ENAMEL_MAX_LAYERS",
                     "ENAMEL_ABI_VERSION"):
            out.append("%s = %s" % (name, h.constants[name]))
        done = set()
        for name, (result, arguments) in h.callbacks.items():
            pending = [a.base for a in arguments if a.base in h.structs]
            for struct in pending:
                self.struct(struct, done, out)
            out += ["", "", "%s = %s" % (name, self.callback(result, arguments))]
        for name in h.structs:
            self.struct(name, done, out)
        out += ["", "", "_FUNCTIONS = {"]
        for result, name, arguments in h.functions:
            kinds = ", ".join(self.type(a) for a in arguments)
            out.append("    \"%s\": (%s, [%s])," % (name, self.type(result), kinds))
        return "\n".join(out + ["}"]) + "\n"

    def struct(self, name, done, out):
        if name in done:
            return
        done.add(name)
        for member in self.header.structs[name]:
            bases = [member] if not member.function else member.function[1]
            for one in bases:
                if one.base in self.header.structs:
                    self.struct(one.base, done, out)
        out += ["", "", "class %s(Structure):" % name, "    _fields_ = ["]
        out += ["        (\"%s\", %s)," % (m.name, self.type(m)) for m in self.header.structs[name]]
        out.append("    ]")


class CSharp:
    def __init__(self, header):
        self.header = header

    def plain(self, member):
        return CSHARP_TYPES.get(member.base, member.base)

    def name(self, member):
        return ("@" if member.name in ("base", "event") else "") + member.name

    def parameter(self, member):
        h = self.header
        if member.function:
            return "IntPtr"
        if member.base in h.opaque:
            return "out IntPtr" if member.pointers == 2 else "IntPtr"
        if member.base == "char":
            return "[MarshalAs(UnmanagedType.LPUTF8Str)] string" if member.const else "IntPtr"
        if member.base in ("void",):
            return "IntPtr" if member.pointers else "void"
        if member.pointers and member.base in h.structs:
            return "ref " + member.base
        if member.pointers and member.const:
            return self.plain(member) + "[]"
        if member.pointers:
            return "[In, Out] double[]" if member.base == "double" else "out " + self.plain(member)
        return self.plain(member)

    def callback(self, name, result, arguments):
        kinds = []
        for a in arguments:
            kind = self.parameter(a)
            if a.pointers and a.base == "double":
                kind = "IntPtr"
            if a.base == "char":
                kind = "IntPtr"
            kinds.append(kind + " " + (self.name(a) or "value"))
        return ["    [UnmanagedFunctionPointer(CallingConvention.Cdecl)]",
                "    public delegate %s %s(%s);" % (self.plain(result), name, ", ".join(kinds)), ""]

    def text(self):
        h, out = self.header, []
        for name, values in h.enums:
            out.append("    public enum %s { %s }" % (name, ", ".join("%s = %s" % value for value in values)))
        out.append("")
        for name, (result, arguments) in h.callbacks.items():
            out += self.callback(name, result, arguments)
        for name, members in h.structs.items():
            if name in ("EnamelTickInput", "EnamelTickOutput", "EnamelDescription", "EnamelConfiguration", "EnamelPlugin",
                        "EnamelConnected", "EnamelDriver"):
                continue  # of plugins, which are written in C or C++
            for member in members:
                if member.function:
                    out += self.callback(name + "_" + member.name, *member.function)
            out += ["    [StructLayout(LayoutKind.Sequential)]", "    public struct %s" % name, "    {"]
            for member in members:
                if member.function:
                    out.append("        [MarshalAs(UnmanagedType.FunctionPtr)] public %s_%s %s;" % (name, member.name, member.name))
                elif member.base in h.callbacks:
                    out.append("        public IntPtr %s;" % self.name(member))
                elif member.pointers:
                    out.append("        public IntPtr %s;" % self.name(member))
                elif member.arrays:
                    out.append("        [MarshalAs(UnmanagedType.ByValArray, SizeConst = %d)] public %s[] %s;"
                               % (member.count, self.plain(member), self.name(member)))
                else:
                    out.append("        public %s %s;" % (self.plain(member), self.name(member)))
            out += ["    }", ""]
        out += ["    public static class Native", "    {", "        const string Library = \"enamel\";", ""]
        for result, name, arguments in h.functions:
            if any(a.base == "EnamelPlugin" for a in arguments):
                continue
            kinds = []
            for a in arguments:
                kind = a.base if a.base in h.callbacks else self.parameter(a)
                if kind in ("ref EnamelParameter", "ref EnamelGuide"):
                    kind = kind[4:] + "[]"
                if name == "enamel_set_tool" and a.pointers:
                    kind = "IntPtr"  # the bur may be missing
                kinds.append("%s %s" % (kind, self.name(a)))
            returned = "IntPtr" if result.pointers else self.plain(result)
            out += ["        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]",
                    "        public static extern %s %s(%s);" % (returned, name, ", ".join(kinds)), ""]
        return "\n".join(out[:-1] + ["    }"]) + "\n"


def between(text, generated, comment):
    """Return the text with everything between the two marks replaced."""
    begin, end = comment + " " + BEGIN + "\n", comment + " " + END
    head, rest = text.split(begin)
    return head + begin + generated + rest[rest.index(end):]


def main():
    if sys.argv[1:] not in (["--check"], ["--write"]):
        raise SystemExit("usage: layout.py --check | --write")
    header = Header()
    wanted = {DESCRIPTION: description(header), PROOF: proof(header)}
    for path, text, comment in ((PYTHON, Python(header).text(), "#"), (CSHARP, CSharp(header).text(), "    //")):
        with open(os.path.join(ROOT, path), encoding="utf-8") as file:
            wanted[path] = between(file.read(), text, comment)
    wrong = 0
    for path, text in wanted.items():
        full = os.path.join(ROOT, path)
        old = open(full, encoding="utf-8").read() if os.path.exists(full) else ""
        if old == text:
            continue
        if sys.argv[1] == "--write":
            with open(full, "w", encoding="utf-8") as file:
                file.write(text)
            continue
        wrong += 1
        for number, (a, b) in enumerate(zip(old.splitlines(), text.splitlines()), 1):
            if a != b:
                print("%s:%d: has \"%s\", the header says \"%s\"" % (path, number, a, b))
                break
        else:
            print(path + ": its length differs")
    if wrong:
        raise SystemExit("the binary interface of enamel.h changed: raise ENAMEL_VERSION_MINOR if a program of an older "
                         "header would break, run tests/c/layout.py --write, and say it in CHANGELOG.md")


main()
