#!/usr/bin/env python3
"""Mutation test of lib/src: changes one line, builds, runs the tests until one fails, restores the line, and continues.

CONTRIBUTING.md has the commands. It prints one line per mutant, separated by tabs: file, line, before, after, verdict. The
verdict is "caught by TEST", "caught by TEST (time)", "SURVIVED", or "does not compile", which does not count. The seed
orders the mutants by a hash of their text, so that changes of other lines keep the order. After an interruption it restores
the file; after kill -9, use `git checkout lib/src`.

--assertions FILE does the opposite: it lists assertions of the file's own tests that no mutant of the file makes fail. Each
of them repeats another one, tests another file, or cannot fail."""
import argparse
import concurrent.futures
import contextlib
import hashlib
import json
import os
import re
import resource
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
RUNNERS = ["tests_unit", "tests_hard", "tests_realtime", "tests_plugin"]  # tests_unit: all programs unit_<module>
RUNNER = re.compile(r"unit_\w+|tests_(hard|realtime|plugin)")
SWAPS = [(" + ", " - "), (" * ", " / "), (" += ", " -= "), (" *= ", " /= "), (" < ", " <= "), (" > ", " >= "), (" == ", " != "),
         (" && ", " || "), ("++", "--"), ("true", "false"), ("std::min(", "std::max("), ("minCoeff", "maxCoeff"),
         ("std::floor", "std::ceil"), ("break;", "continue;")]
SWAPS += [(b, a) for a, b in SWAPS]
NUMBER = re.compile(r"(?<![\w.'])\d+(\.\d*)?(e[-+]?\d+)?(?![\w.'])")
MINUS = re.compile(r"(?:(?<=[(\[])|(?<=[=,?:] )|(?<=return ))-(?=[\w(])")
# A call, an assignment without a declaration, a jump or a throw.
STATEMENT = re.compile(r"\s*((if \(.*\)|else|for \(.*\)) )?([\w:.\[\]>()-]+(\(.*\)|\[.*\])? [-+*/|&]?= .*|[\w:.>-]+\(.*\)"
                       r"|(\+\+|--)\w+|break|continue|return|throw .*);$")


def mutations(line, before):
    """Return the possible changes of a line, given the code line before it. The rest after a string is not changed."""
    code = re.sub(r"'(\\.|[^'\\])'", lambda m: "'" * len(m[0]), line.split("//")[0]).split('"')[0]
    if re.match(r"\s*(#|using |template|namespace |static_assert|/?\*)", line):
        return []
    result = []
    for old, new in SWAPS:
        word = r"(?<!\w)" + re.escape(old) + r"(?!\w)" if old[0].isalpha() else re.escape(old)
        result += [line[:m.start()] + new + line[m.end():] for m in re.finditer(word, code)]
    for m in NUMBER.finditer(code):
        new = str(int(m[0]) + 1) if m[0].isdigit() else f"(2 * {m[0]})" if float(m[0]) != 0 else "1.0"
        result.append(line[:m.start()] + new + line[m.end():])
    result += [line[:m.start()] + line[m.end():] for m in MINUS.finditer(code)]
    for m in re.finditer(r"\b(if|while) \(", code):
        depth, end = 1, m.end()
        while depth > 0 and end < len(code):
            depth += {"(": 1, ")": -1}.get(code[end], 0)
            end += 1
        condition = line[m.end():end - 1]
        if depth == 0 and not re.search(r"; | = ", condition):
            result.append(line[:m.end()] + f"!({condition})" + line[end - 1:])
    m = STATEMENT.match(line.split("//")[0].rstrip())
    if m and line.count("(") == line.count(")") and re.search(r"([;{}:]|\)|else)$", before):
        result.append(line[:m.start(3)] + ";")
    return result


def candidates(seed, only=()):
    """Return (file, line number, before, after) of all lines that can be changed, in the order of the seed.

    There is one change per line; for the files in `only`, if any, every change."""
    result = []
    for path in [ROOT / name for name in only] or sorted((ROOT / "lib/src").rglob("*.[chi]*")):
        name, seen, before = str(path.relative_to(ROOT)), {}, ""
        for number, line in enumerate(path.read_text().splitlines(), 1):
            seen[line] = seen.get(line, 0) + 1
            digest = hashlib.sha256(f"{seed} {name} {seen[line]} {line}".encode()).digest()
            choice = mutations(line, before)
            if only:
                for after in choice:
                    order = hashlib.sha256(digest + after.encode()).digest()
                    result.append((order, name, number, line.strip(), after.strip()))
            elif choice:
                after = choice[int.from_bytes(digest[:8], "big") % len(choice)]
                result.append((digest, name, number, line.strip(), after.strip()))
            before = line.split("//")[0].strip() or before
    return [c[1:] for c in sorted(result)]


def limit_memory():
    resource.setrlimit(resource.RLIMIT_AS, (8 << 30, 8 << 30))


class Tests:
    def __init__(self, options, runners, wanted=None):
        self.build, self.jobs = options.build.resolve(), options.jobs
        if failure := self.make(runners):
            sys.exit(failure)
        listed = json.loads(subprocess.check_output(["ctest", "--show-only=json-v1"], cwd=self.build))["tests"]
        self.entries = {t["name"]: t["command"] for t in listed if RUNNER.fullmatch(Path(t.get("command", [""])[0]).name)
                        and (not wanted or t["name"] in wanted)}
        self.pool, self.running = concurrent.futures.ThreadPoolExecutor(self.jobs), set()
        # Time of each test without a mutant. Tests that fail or take too long are left out.
        file = self.build / "mutate_times.json"
        self.times = json.loads(file.read_text()) if file.exists() else {}
        new = sorted(self.entries.keys() - self.times.keys())
        self.times.update(zip(new, self.pool.map(lambda n: self.duration(n, options.longest), new)))
        file.write_text(json.dumps(self.times, indent=1))
        left_out = [n for n in self.entries if self.times[n] is None or self.times[n] > options.longest]
        print("left out:", ", ".join(left_out) or "no test", file=sys.stderr)
        self.entries = {n: c for n, c in self.entries.items() if n not in left_out}

    def duration(self, name, longest):
        start = time.monotonic()
        return None if self.run(name, longest) else time.monotonic() - start

    def ordered(self, source):
        """Order the tests: named like the file, then with its header, then with its module; short ones first."""
        module, stem, folder = source.split("/")[2], Path(source).stem, Path(source).parent.name

        def rank(name):
            path = ROOT / "tests" / (name.replace(".", "/", 1) + ".cpp")
            text = path.read_text() if path.exists() else ""
            includes = re.findall(r'#include "(?:enamel/)?(\w+)/(?:\w+/)*(\w+)\.', text)
            return (name.split(".")[1] not in (stem, folder), (module, stem) not in includes, module not in dict(includes))
        return sorted(self.entries, key=lambda n: (rank(n), self.times[n]))

    def make(self, targets):
        """Build the targets. Return the compiler's output on failure, else an empty text."""
        command = ["ninja", "-C", self.build, "-j", str(self.jobs), *targets]
        done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        return done.stdout if done.returncode != 0 else ""

    def run(self, name, limit):
        """Run a test. Return None if it passes, else its name with the reason."""
        folder = self.build / "mutate_tmp" / name
        folder.mkdir(parents=True, exist_ok=True)
        test = subprocess.Popen([*self.entries[name], "--abort"], cwd=folder, stdout=subprocess.DEVNULL,
                                stderr=subprocess.DEVNULL, start_new_session=True, env={**os.environ, "TMPDIR": str(folder)},
                                preexec_fn=limit_memory)
        self.running.add(test)
        try:
            return None if test.wait(limit) in (0, 4) else name  # 4: skipped
        except subprocess.TimeoutExpired:
            return name + " (time)"
        finally:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(test.pid, signal.SIGKILL)
            test.wait()
            self.running.discard(test)
            shutil.rmtree(folder, ignore_errors=True)

    def verdict(self, source):
        built, names = set(), self.ordered(source)
        limit = {name: 20 + 5 * self.times[name] for name in names}
        for some in (names[i:i + self.jobs] for i in range(0, len(names), self.jobs)):
            runners = {Path(self.entries[n][0]).name for n in some} - built
            if runners and self.make(sorted(runners)):
                return "does not compile"
            built |= runners
            for name, failed in zip(some, self.pool.map(self.run, some, map(limit.get, some))):
                # Repeat it, so that a hiccup of the machine does not count.
                if failed and ("(time)" in failed or self.run(name, limit[name])):
                    return "caught by " + failed
        return "SURVIVED"


@contextlib.contextmanager
def mutated(tests, source, number, before, after):
    """Change the file, and restore it afterwards."""
    path = ROOT / source
    text = path.read_text()
    lines = text.split("\n")
    lines[number - 1] = lines[number - 1].replace(before, after)
    try:
        path.write_text("\n".join(lines))
        yield
    except BaseException:
        for test in list(tests.running):
            test.kill()
        raise
    finally:
        path.write_text(text)  # with a new time, so that files built from the mutant are built again


def tests_of(sources):
    """Return the ctest names of the sources' tests: tests of the same name, or from the rows of covered_by."""
    rows = re.search(r"set\(covered_by\n(.*?)\)", (ROOT / "tests/CMakeLists.txt").read_text(), re.S)[1].split()
    covered = dict(zip(rows[::2], rows[1::2]))
    result = []
    for source in sources:
        name = re.sub(r"^lib/(src|include/enamel)/|\.\w+$", "", source)
        own = [f"{label}/{Path(name).name}" for label in ("unit", "hard", "plugin", "realtime")]
        found = [covered[name]] if name in covered else [t for t in own if (ROOT / "tests" / (t + ".cpp")).exists()]
        if not found:
            sys.exit(f"{source} has no test of its name: give --tests")
        result += [t.replace("/", ".", 1) for t in found if t.startswith(("unit", "plugin"))] or [found[0].replace("/", ".", 1)]
    return sorted(set(result))


def assertions(options):
    """Print the assertions that no mutant of the files makes fail, and those that are never reached."""
    wanted = options.tests or tests_of(options.assertions)
    listed = (options.build / "tests/CTestTestfile.cmake").read_text()  # ctest itself lists what is built alone
    runners = sorted({Path(re.search(rf'\[{re.escape(name)}\]=\] "(.*?)"', listed)[1]).name for name in wanted})
    tests = Tests(options, runners, wanted)
    files = {f"tests/{name.replace('.', '/', 1)}.cpp" for name in tests.entries}

    def seen(name, word, limit):
        """Return file:line of the assertions that passed or failed in a run."""
        command = [*tests.entries[name], "--reporter", "compact", "--success"]
        with contextlib.suppress(subprocess.TimeoutExpired):
            done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, timeout=limit, preexec_fn=limit_memory)
            places = re.findall(rf"^\S*?(tests/\S+?:\d+): {word}", done.stdout.decode(errors="replace"), re.M)
            return {p for p in places if p.split(":")[0] in files}
        return set()

    reached = set().union(*(seen(name, "passed", 3600) for name in tests.entries))
    failed, count = set(), 0
    for source, number, before, after in candidates(options.seed, options.assertions):
        if count >= options.count:
            break
        with mutated(tests, source, number, before, after):
            if tests.make(runners):
                continue
            fails = set().union(*(seen(name, "failed", 20 + 5 * tests.times[name]) for name in tests.entries))
        count, failed = count + 1, failed | fails
        print(f"{source}:{number}\t{before}\t{after}\t{len(fails)} fail", flush=True)
    tests.make(runners)
    written = {}  # key: place of an assertion; value: its first line, and all lines that a compiler may report for it
    for file in files:
        lines = (ROOT / file).read_text().splitlines()
        for i, line in enumerate(lines):
            if re.match(r"\s*(if \(.*\) |else )?(CHECK|REQUIRE)\w*\(", line):
                end = i + 1
                while end < min(len(lines), i + 12) and not lines[end - 1].split("//")[0].rstrip().endswith(";"):
                    end += 1
                written[file, i + 1] = (line.strip(), {f"{file}:{n}" for n in range(i + 1, end + 1)})
    killed = 0
    for (file, number), (line, places) in sorted(written.items()):
        if places & failed:
            killed += 1
        else:
            print(f"{file}:{number}: {'no mutant makes it fail' if places & reached else 'never reached'}: {line}")
    print(f"{count} mutants, {len(written)} assertions, {killed} can fail")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", type=Path, required=True, help="a configured build folder of its own (Ninja)")
    parser.add_argument("--count", type=int, default=100, help="mutants that compile")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=2, help="of the build, and tests at a time")
    parser.add_argument("--output", type=Path, help="file of results (BUILD/mutants.tsv); what it has is not done again")
    parser.add_argument("--again", action="store_true", help="the survivors of the file once more")
    parser.add_argument("--only", nargs="+", metavar="FILE:LINE", help="these lines alone, again, whatever their place")
    parser.add_argument("--longest", type=float, default=1200, help="leave tests out that take longer unchanged, s")
    parser.add_argument("--assertions", nargs="+", metavar="FILE", help="list the assertions that no mutant of these files "
                        "(lib/src/...cpp, lib/include/...hpp) makes fail")
    parser.add_argument("--tests", nargs="+", metavar="NAME", help="with --assertions: these of ctest, not the files' own")
    options = parser.parse_args()
    output = options.output or options.build / "mutants.tsv"
    for number in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, lambda *_: sys.exit("stopped"))
    if options.assertions:
        assertions(options)
        return
    done = {}
    if output.exists():
        rows = [line.split("\t") for line in output.read_text().splitlines()]
        done = {(r[0], r[2], r[3]): r[4] for r in rows if len(r) == 5}
    tests, verdicts = Tests(options, RUNNERS), []
    for source, number, before, after in candidates(options.seed):
        if len(verdicts) >= options.count:
            break
        if options.only and f"{source}:{number}" not in options.only:
            continue
        verdict = None if options.only else done.get((source, before, after))
        if verdict is None or options.again and verdict == "SURVIVED":
            with mutated(tests, source, number, before, after):
                verdict = tests.verdict(source)
            row = "\t".join((source, str(number), before, after, verdict))
            print(row, flush=True)
            with output.open("a") as file:
                file.write(row + "\n")
        if verdict != "does not compile":
            verdicts.append(verdict)
    survived = verdicts.count("SURVIVED")
    print(f"{len(verdicts)} mutants, {len(verdicts) - survived} caught, {survived} survived")


if __name__ == "__main__":
    main()
