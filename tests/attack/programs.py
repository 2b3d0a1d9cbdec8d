#!/usr/bin/env python3
"""Attacks the programs from outside: full and read-only disks, killed processes, pages with hostile names.

    programs.py --tool ENAMEL --surface disk|kill|pages --seconds S --state FOLDER

Each scenario comes from a seed that counts up; FOLDER/seed contains the next one. --seed N repeats one scenario. Surfaces:

- disk: a small tmpfs in a separate mount namespace is full, read-only or without inodes, or the size of files is limited.
  A command must end with its whole output, or with one line that names the file. It must work once there is room.
- kill: signals arrive at random times. The finished files must have the bytes of an undisturbed run.
- pages: reports, comparisons and recordings in Chromium. No name may become an element, a script or a request.

Status: 0: passed; 1: a failure, whose folder is kept; 4: the surface cannot run here."""
import argparse
import collections
import contextlib
import html.parser
import json
import os
import random
import re
import resource
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

DATA = Path(__file__).resolve().parent.parent.parent / "data"
DEVICE = ["--device", str(DATA / "devices/tau-nominal.toml")]
LIMIT = 120.0  # s: a slower command counts as hanging
PROGRESS = re.compile(r"\d+ of \d+ runs|[a-z-]+, delay |enamel: warning: ")  # lines on stderr that are not errors
BLOCK = """name = {5}\nstart = [0.0, 0.0, 0.004]\n[[tool]]\nfrom = [0.0, 0.0, 0.001]\nradius = 0.001\n[bur]\npart = 0
wear = 0.5\n[[obstacle]]\nname = {6}\nshape = "solid"\nfile = "cube.obj"\nunit = "mm"\ncell = 0.0005
position = [-0.0045, -0.0045, -0.009]\n[[obstacle.layer]]\nname = {7}\nhardness = 3.0e9\n[[obstacle.layer]]\nname = {8}
hardness = 1.0e9\ndepth = 0.002\n[[obstacle]]\nname = {9}\nshape = "half_space"\npoint = [0.0, 0.0, -0.012]
normal = [0.0, 0.0, 1.0]\n"""
CUBE = "".join(f"v {9 * (i & 1)} {9 * (i >> 1 & 1)} {9 * (i >> 2)}\n" for i in range(8)) + \
    "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n"
OWN = "document.documentElement.className=document.title='owned'"
HOSTILE = ["<script>OWN</script>", "<img src=x onerror=OWN>", "\"><img src=x onerror=\"OWN\">", "</title><script>OWN</script>",
           "</script><script>OWN</script>", "</svg><img src=x onerror=OWN>", "</style><svg onload=OWN>", "<svg onload=OWN>",
           "${OWN}", "`+OWN+`", "'+OWN+'", "\\\");OWN//", "{{OWN}}", "javascript:OWN", "]]>", "<!--", "-->", "<![CDATA[", "&",
           "&lt;script&gt;OWN", "&#60;img src=x onerror=OWN&#62;", "\u2028OWN\u2029", "\u202eOWN\u2066", "\ufeff", "\ufffe\uffff",
           "e\u0301" * 20, "<base href=HTTP>", "<img src=HTTP/a>", "<meta http-equiv=refresh content=0;url=HTTP>", "url(HTTP)",
           "<iframe srcdoc='<script>top.OWN</script>'>", "/*DATA*/", "/*SCRIPT*/", "/*STYLE*/", "%s%n{}{0:n}", "a_b -1 5 N m",
           "<b style=position:fixed>", "<td class=no>", "</td></table>", "<sub>", "M" * 900]
KEYS = ["__proto__", "constructor", "force", "depth", "toString", "gum", "view", "error", "sides"]


class Failure(Exception):
    pass


def need(condition, expected, happened):
    if not condition:
        raise Failure(f"expected: {expected}; happened: {happened}")


def contents(names, base):
    """Return the contents of the files with these names, and of all files in folders with these names."""
    files = [f for n in names for f in ((base / n).rglob("*") if (base / n).is_dir() else [base / n]) if f.is_file()]
    return {str(f.relative_to(base)): f.read_bytes() for f in files}


class Job:
    """A command with random options, and the files and folders that it writes."""

    def __init__(self, draw, kinds):
        self.kind, seed = draw.choice(kinds), ["--seed", str(draw.randint(1, 3))]
        renderer, one = draw.choice(["position-control", "hold", "impedance"]), ["--grid", "1"]
        ends = {"study": "", "compare": "", "design": ".json", "mesh": ".stl", "prepare": ".ply", "fmu": ".fmu", "replay": ".html"}
        files = [["out.rec"], ["out.csv"], ["out.csv", "out.rec"]][draw.randrange(3)]
        self.outputs = files if self.kind == "push" else ["out" + ends.get(self.kind, ".json")]
        self.isStudy = self.kind in ("study", "compare")
        self.resume = ["--resume" if self.isStudy else "--overwrite"]  # continues after the disturbance
        self.args = {
            "push": ["push", *DEVICE, "--renderer", renderer, *seed, "--device-damping", "4", "--duration", draw.choice(["1.1", "3"]),
                     *sum((["--record" if n.endswith("rec") else "--output", n] for n in files), [])],
            "study": ["study", "--no-convergence", "--renderers", draw.choice([renderer, "position-control,hold"]), "--grid",
                      draw.choice("13"), "--runs", draw.choice("246"), "--scenario", draw.choice(["1", "1,2"]), *seed, "--output"],
            "compare": ["compare", *DEVICE, "--renderers", f"{renderer},passivity", *one, "--runs", draw.choice("258"), "--plants",
                        "closed-form", "--delays", "none,constant:1", "--tasks", draw.choice(["push", "push,release"]), *seed, "--output"],
            "design": ["design", *DEVICE, "--rate", draw.choice(["1000", "2000"]), "--output"],
            "mesh": ["mesh", "--generate", draw.choice(["molar", "jaw"]), "--output"],
            "prepare": ["mesh", "cube.obj", "--deviation", draw.choice(["0", "20"]), "--prepare"],
            "fmu": ["fmu", *DEVICE, *draw.choice([[], ["--renderer", renderer]]), "--output"],
            "replay": ["replay", "in.rec", "--html"],
            "evaluate": ["evaluate", *DEVICE, "--input", "rows.json", "--output"]}[self.kind]
        self.args += self.outputs if self.kind != "push" else []


class Attack:
    plain = {}  # by kind of page: the elements of a page with harmless names

    def __init__(self, tool, seed, folder):
        self.tool, self.folder, self.random = tool, folder, random.Random(seed)
        self.command, self.cleanups, self.note, self.refused = [], [], "", False

    def run(self, args, cwd, **options):
        """Return status (minus the signal) and standard error of a command that must not hang."""
        self.command = [self.tool, *args]
        try:
            done = subprocess.run(self.command, cwd=cwd, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, timeout=LIMIT, **options)
        except subprocess.TimeoutExpired:
            raise Failure(f"expected: an end within {LIMIT:.0f} s; happened: none")
        return done.returncode, done.stderr.decode(errors="surrogateescape")

    def works(self, args, place, what):
        status, text = self.run(args, place)
        need(status == 0, f"{what} ends with 0", f"{status}: {text[-600:]}")

    def oneLine(self, text, names):
        lines = [line for line in text.splitlines() if not PROGRESS.match(line)]
        good = len(lines) == 1 and lines[0].startswith("enamel: ") and (not names or any(n in lines[0] for n in names))
        need(good, f"one line \"enamel: ...\" that names {' or '.join(names) or 'it'}", repr(text[-600:]))

    def inputs(self, place):
        (place / "cube.obj").write_text(CUBE[:CUBE.rfind("f")])  # an open mesh
        (place / "rows.json").write_text(json.dumps([{"q": [1e-3 * i, 0, 0, 0, 0, 0]} for i in range(40)]))
        self.works(["push", *DEVICE, "--duration", "0.5", "--record", "in.rec"], place, "a recording")

    def wholeRun(self, job):
        """Run the job undisturbed and check its files. Return them and the time."""
        place = self.folder / "whole"
        place.mkdir()
        self.inputs(place)
        begin = time.monotonic()
        self.works(job.args, place, "an undisturbed run")
        took, files = time.monotonic() - begin, contents(job.outputs, place)
        for file, data in files.items():
            if file.endswith(".json"):
                json.loads(data)
            if file.endswith((".stl", ".ply", ".rec")):
                self.works(["replay" if file.endswith("rec") else "mesh", file], place, "reading it again")
        return files, took

    def prepareOld(self, job, place):
        """With probability 1/2, make old results that the job must replace."""
        if self.random.random() < 0.5:
            return {}
        self.works(["9" if before == "--seed" else a for before, a in zip([""] + job.args, job.args)], place, "an older run")
        for name in job.outputs:
            if (place / name).is_file() and not name.endswith("rec"):
                (place / name).write_bytes(b"old\n" * self.random.randint(1, 5000))
        job.args.append("--overwrite")
        return contents(job.outputs, place)

    def checkRest(self, job, place, old, whole, most):
        """Check that single files are whole. Study and compare remove results before they begin; a new recording grows."""
        left = [str(f) for f in place.rglob("*.part")]
        need(len(left) <= most, f"at most {most} files *.part", f"{len(left)}: {left[:3]}")
        for name in job.outputs if not job.isStudy else ():
            now = (place / name).read_bytes() if (place / name).exists() else None
            grows = name.endswith("rec") and name not in old
            need(grows or now in (old.get(name), whole[name]), f"{name} as it was or as it becomes", f"{now and len(now)} bytes")

    def finish(self, job, place, whole):
        """Continue the disturbed job; it must end with the bytes of an undisturbed one."""
        args = [a for a in job.args if a != "--overwrite"]
        status, text = self.run(args + job.resume, place)
        if status != 0 and "holds another study" in text:  # it was disturbed before it replaced the older study
            self.oneLine(text, ["out"])
            status, text = self.run(args + ["--overwrite"], place)
        need(status == 0, "the next run ends with 0", f"{status}: {text[-600:]}")
        now = {n: data for n, data in contents(job.outputs, place).items() if not re.search(r"-of-\d+\.csv$|\.part$", n)}
        need(now == whole, "the bytes of an undisturbed run", [n for n in whole.keys() | now.keys() if whole.get(n) != now.get(n)])

    # ---- disk ----

    def disturb(self, how, place, free, stop):
        """Take away space, inodes or write permission; `free` bytes remain."""
        if how in ("small", "full"):
            more = os.statvfs(place).f_bavail * os.statvfs(place).f_frsize - free
            with contextlib.suppress(OSError), open(place / "filler", "wb", buffering=0) as file:
                while more > 0 or how == "full":
                    more -= file.write(bytes(min(65536, max(4096, more))))
        elif how == "inodes":
            used = 200 - os.statvfs(place).f_favail
            subprocess.run(["mount", "-o", f"remount,nr_inodes={used + free % 4}", str(place)], stderr=subprocess.DEVNULL)
        while how == "read-only" and not stop.is_set() and subprocess.run(
                ["mount", "-o", "remount,ro", str(place)], stderr=subprocess.DEVNULL).returncode != 0:
            time.sleep(0.002)  # while a file is being written

    def disk(self):
        job = Job(self.random, "push push study study compare design mesh prepare fmu replay evaluate".split())
        whole, took = self.wholeRun(job)
        size, place = sum(len(data) for data in whole.values()), self.folder / "disk"
        how = self.random.choice(["small", "full", "inodes", "read-only", "limit", "other user"])
        place.mkdir()
        if how not in ("limit", "other user") and os.environ["ENAMEL_ATTACK_MOUNTS"] == "yes":
            room = (4 * size + (12 << 20)) // 1024  # study checks for 8 MB before it begins
            subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={room}k,nr_inodes=200", "none", str(place)], check=True)
            self.cleanups.append(lambda: subprocess.run(["umount", "-l", str(place)]))
        elif how != "other user":
            how = "limit"
        self.inputs(place)
        old = self.prepareOld(job, place)
        self.note = f"{how}, {'old results' if old else 'no results yet'}"
        delay, stop, options = self.random.uniform(-0.3, 1.0) * took, threading.Event(), {}
        free = int(self.random.random() * (max(map(len, whole.values())) if how == "limit" else size))
        thread = threading.Timer(max(0.0, delay), self.disturb, (how, place, free, stop))
        if how == "limit":
            options["preexec_fn"] = lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (free, free))
        elif how == "other user" and os.geteuid() == 0:
            options["preexec_fn"] = lambda: (os.setgroups([]), os.setgid(65534), os.setuid(65534))
            self.folder.chmod(0o755)
        elif how == "other user":
            place.chmod(0o555)
        thread.start()
        if delay <= 0.0:
            time.sleep(0.0 if how in ("limit", "other user") else 0.1)
        try:
            status, text = self.run(job.args, place, **options)
        finally:
            stop.set()
            thread.join()
            if how == "other user":
                place.chmod(0o755)
        need(status >= 0, "no crash", f"signal {-status}")
        self.checkRest(job, place, old, whole, 0)
        if status != 0:
            self.oneLine(text, job.outputs)
        else:
            now = contents(job.outputs, place)
            need(now == whole, "the whole output with status 0", [n for n in whole if now.get(n) != whole[n]])
        if how in ("inodes", "read-only"):
            subprocess.run(["mount", "-o", "remount,rw,nr_inodes=400", str(place)], check=True)
        (place / "filler").unlink(missing_ok=True)
        self.finish(job, place, whole)

    # ---- kill ----

    def start(self, args, place, latest, container):
        """Start the process. Return it with the time and the kind of its signal."""
        wrap = ["unshare", "-p", "-f", "--kill-child", "--"] if container else []  # the same process number every time
        self.command = [*wrap, self.tool, *args]
        process = subprocess.Popen(self.command, cwd=place, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
        how = signal.SIGKILL if container else self.random.choice([signal.SIGKILL, signal.SIGKILL, signal.SIGTERM, signal.SIGINT])
        return process, time.monotonic() + self.random.uniform(0.0, latest), how

    def end(self, process, when, how, mayRefuse):
        try:
            process.wait(max(0.0, when - time.monotonic()))
        except subprocess.TimeoutExpired:
            process.send_signal(how)
        try:
            text = process.communicate(timeout=LIMIT)[1].decode(errors="surrogateescape")
        except subprocess.TimeoutExpired:
            raise Failure(f"expected: an end within {LIMIT:.0f} s of signal {how}; happened: none")
        allowed = [0, -how, 128 + how] + [1] * mayRefuse
        need(process.returncode in allowed, f"status in {allowed}", f"{process.returncode}: {text[-600:]}")
        if process.returncode > 0 and process.returncode != 128 + signal.SIGKILL:
            self.oneLine(text, ["out"])
        return process.returncode != 0

    def kill(self):
        job = Job(self.random, "study study study compare compare push push design mesh fmu replay".split())
        whole, took = self.wholeRun(job)
        place = self.folder / "killed"
        place.mkdir()
        self.inputs(place)
        old = self.prepareOld(job, place)
        mine = {"note.txt": b"mine", "out.json.bak": b"", **({"out/runs-notes.txt": b"mine", "out/my.csv": b"1\n"} if job.isStudy else {})}
        for name, data in mine.items():
            (place / name).parent.mkdir(exist_ok=True)
            (place / name).write_bytes(data)
        parts = self.random.choice([1, 1, 2, 3]) if job.kind == "study" and not old else 1
        together = 2 if job.isStudy and parts == 1 and self.random.random() < 0.3 else 1
        mixed = parts > 1 and self.random.random() < 0.4  # starts without --part
        container = os.geteuid() == 0 and self.random.random() < 0.3
        kills, times = 0, self.random.randint(1, 12)
        self.note = f"{parts} parts, {together} at once, {times} times{', one process number' * container}"
        for turn in range(times):
            isSplit = parts > 1 and not (mixed and turn == 0)
            begun = list(place.glob("out/**/runs.csv")) if job.isStudy else turn > 0
            args = [a for a in job.args if a != "--overwrite"] + job.resume if begun and turn > 0 and not isSplit else job.args
            started = [self.start(args + (["--part", f"{i + 1}/{parts}"] if isSplit else []), place, 1.2 * took, container)
                       for i in range(parts if isSplit else together)]
            for one in sorted(started, key=lambda s: s[1]):
                kills += self.end(*one, together > 1 or mixed or bool(old and job.isStudy))
            time.sleep(0.05 if container else 0.0)  # the program may outlive its container for an instant
            self.checkRest(job, place, old, whole, kills * len(job.outputs))
            for name in job.outputs:
                if name.endswith("rec") and (place / name).exists():
                    status, text = self.run(["replay", name], place)
                    isShort = status == 1 and (place / name).stat().st_size < 65536  # less than one chunk
                    need(status == 0 or isShort, "a killed recording replays equal", f"{status}: {text[-600:]}")
        for i in range(parts if parts > 1 else 0):
            status, text = self.run(job.args + ["--part", f"{i + 1}/{parts}"], place)
            need(status in (0, int(mixed)), "a part ends", f"{status}: {text[-600:]}")
        for name, data in mine.items():
            need((place / name).exists() and (place / name).read_bytes() == data, f"{name} untouched", "it changed")
            (place / name).unlink()
        self.finish(job, place, whole)

    # ---- pages ----

    def hostileName(self, forFile, port):
        name = "".join(self.random.choice(HOSTILE) for _ in range(self.random.randint(1, 3)))
        name = "Zq7" + name.replace("OWN", OWN).replace("HTTP", f"http://127.0.0.1:{port}")[:1500]
        if not forFile:
            return self.random.choice(KEYS) if self.random.random() < 0.1 else name
        name = name.replace("/", self.random.choice(["", "\u2215"])).replace(",", "")
        if self.random.random() < 0.1:
            name = name[:50] + self.random.choice(["\x01", "\x1b[31m", "\n", "\udcff", "\udcff", "\x7f", "\t"]) + name[50:]
        return os.fsencode(name)[:150].decode(errors="surrogateescape")

    def makePage(self, names, place, kind):
        """Return a page that contains these names; None: a command rejected a name in one line."""
        place.mkdir()
        device, servo, scene, out = (str(place / (names[i] + end)) for i, end in enumerate((".toml", ".json", "-scene.toml", "")))
        quoted = [json.dumps(name).replace("\x7f", "\\u007f") for name in names]
        text = (DATA / "devices/tau-nominal.toml").read_text()
        Path(device).write_text(re.sub("(?m)^name = .*", lambda _: "name = " + quoted[4], text))
        Path(scene).write_text(BLOCK.format(*quoted))
        (place / "cube.obj").write_text(CUBE)
        shutil.copy(DATA / "servos/tau-hold-0.json", servo)
        tuned = json.loads((DATA / "servos/rivals-tau.json").read_text())
        (place / "tuned.json").write_text(json.dumps({**tuned, "model": names[4]}))
        common = ["--device", device, "--output", out, "--runs", "2", "--renderers", f"{servo},position-control,impedance"]
        commands = {"study": [["study", "--no-convergence", "--grid", "3", *common]],
                    "scene study": [["study", "--no-convergence", "--grid", "1", "--scene", scene, *common]],
                    "compare": [["compare", "--grid", "1", "--tuned", "tuned.json", "--plants", "closed-form", "--delays", "none",
                                 "--tasks", "push,release", *common[:-1], common[-1] + ",tuned:impedance"]],
                    "replay": [["push", "--device", device, "--scene", scene, "--renderer", "hold", "--gain", servo, "--duration", "1.2",
                                "--record", out + ".rec"], ["replay", out + ".rec", "--html", out + ".html", "--set", "release=on"]]}[kind]
        page = {"compare": out + "/compare.html", "replay": out + ".html"}.get(kind, out + "/report.html")
        for command in commands:
            status, text = self.run(command, place)
            need(status in (0, 1), "status 0 or 1", f"{status}: {text[-600:]}")
            if not os.path.exists(page if command is commands[-1] else out + ".rec"):
                self.oneLine(text, [])
                return None
        return Path(page)

    def open(self, page):
        """Return the elements of a page in the browser, and the console output."""
        self.command = ["chromium", "--headless", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
                        "--disable-background-networking", "--disable-component-update", "--no-first-run", "--enable-logging=stderr",
                        f"--user-data-dir={self.folder / 'browser'}", "--virtual-time-budget=3000", "--dump-dom", page.as_uri() + "#t=0.5"]
        try:
            done = subprocess.run(self.command, capture_output=True, timeout=LIMIT)
        except subprocess.TimeoutExpired:
            raise Failure(f"expected: the page opens within {LIMIT:.0f} s; happened: no end")
        said = [line for line in done.stderr.decode(errors="replace").splitlines() if ":CONSOLE" in line and "GL Driver" not in line]
        return Elements(done.stdout.decode(errors="replace")), said

    def pages(self):
        kind = self.note = self.random.choice(["study", "scene study", "compare", "replay", "replay"])
        with socket.create_server(("127.0.0.1", 0)) as server:
            server.setblocking(False)
            names = [self.hostileName(i < 4, server.getsockname()[1]) for i in range(10)]
            page = self.makePage(names, self.folder / "hostile", kind)
            if page is None:
                self.refused = True
                return
            if kind not in self.plain:
                self.plain[kind] = self.open(self.makePage([f"plain{i}" for i in range(10)], self.folder / "plain", kind))[0]
            plain = self.plain[kind]
            seen, said = self.open(page)
            with contextlib.suppress(BlockingIOError):
                server.accept()
                raise Failure("expected: no request; happened: the page made one")
        need("owned" not in (seen.title, seen.of["html"].get("class")), "no script of a name runs", seen.title[:80])
        need(not said, "nothing on the console", said[:3])
        more = {k for k in seen.kinds if k not in plain.kinds and k[0] not in ("sub", "tspan")}
        need(not more, "only elements and attributes of a page with plain names", sorted(more)[:5])
        for tag in ("script", "style", "title", "table", "tr", "td", "th", "figure", "svg", "dt", "dd", "p", "h1", "h2"):
            need(seen.counts[tag] == plain.counts[tag], f"{plain.counts[tag]} elements {tag}", seen.counts[tag])
        need(len(seen.text) > 0.8 * len(plain.text), "the page's text", f"{len(seen.text)} of {len(plain.text)} characters")
        shown = names[5 if kind == "replay" else 4]
        need(shown[:3] in seen.text, "the names are shown", "they are missing")
        if kind == "replay":
            ready = seen.of["body"].get("data-ready") == "yes" and "data-error" not in seen.of["body"]
            need(ready and seen.values.count("") == 0, "the page's script fills every row", f"{seen.of['body']} {seen.values}")
        else:
            need("built without Vega" in seen.text or seen.of["body"].get("data-ready") == "yes", "every figure is drawn", f"{seen.of['body']}")


class Elements(html.parser.HTMLParser):
    """Elements of a page as dumped by the browser."""

    def __init__(self, text):
        super().__init__()
        self.kinds, self.counts, self.of = set(), collections.Counter(), {"html": {}, "body": {}}
        self.title = self.text = self.inside = ""
        self.values = []  # values in the rows of a replay's panel
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        self.kinds.add((tag, tuple(sorted(name for name, _ in attributes))))
        self.counts[tag] += 1
        self.of[tag] = dict(attributes)
        self.inside = tag
        self.values += [""] * (tag == "dd")

    def handle_endtag(self, tag):
        self.inside = ""

    def handle_data(self, data):
        self.title += data * (self.inside == "title" and self.counts["title"] == 1)
        self.text += " ".join(data.split()) * (self.inside not in ("script", "style"))
        if self.inside == "dd":
            self.values[-1] += data


def startInOwnMounts():
    """Restart in a separate mount namespace if possible; otherwise return."""
    wrap = ["unshare", "-m" if os.geteuid() == 0 else "-rm"]
    test = "t=$(mktemp -d) && mount -t tmpfs -o size=64k none $t && umount $t; s=$?; rmdir $t; exit $s"
    isAble = shutil.which("unshare") and subprocess.run([*wrap, "sh", "-c", test], stderr=subprocess.DEVNULL).returncode == 0
    os.environ["ENAMEL_ATTACK_MOUNTS"] = "yes" if isAble else "no"
    if isAble:
        os.execvp("unshare", [*wrap, sys.executable, *sys.argv])
    print("disk: no mounts here: only limits of the size of files and folders without permission", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tool", required=True)
    parser.add_argument("--surface", required=True, choices=["disk", "kill", "pages"])
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--state", required=True)
    parser.add_argument("--seed", type=int, help="this scenario alone")
    options = parser.parse_args()
    if options.surface == "pages" and shutil.which("chromium") is None:
        print("pages: cannot run here: chromium is not installed")
        return 4
    if options.surface == "disk" and "ENAMEL_ATTACK_MOUNTS" not in os.environ:
        startInOwnMounts()
    state, name = Path(options.state).absolute(), options.surface
    state.mkdir(parents=True, exist_ok=True)
    counter = state / "seed"
    seed = options.seed if options.seed is not None else int(counter.read_text()) if counter.exists() else 1
    begin = said = time.monotonic()
    count = refused = 0
    while True:
        folder = Path(tempfile.mkdtemp(prefix=f"{name}-{seed}-", dir=state))
        attack = Attack(str(Path(options.tool).absolute()), seed, folder)
        try:
            getattr(attack, name)()
        except Failure as failure:
            command = " ".join(attack.command)
            print(f"{name}: seed {seed} ({attack.note}): {command!a}: {str(failure)!a}; folder {folder}", flush=True)
            return 1
        finally:
            for cleanup in attack.cleanups:
                cleanup()
        shutil.rmtree(folder)
        count, refused, seed = count + 1, refused + attack.refused, seed + 1
        if options.seed is None:
            counter.write_text(f"{seed}\n")
        now = time.monotonic()
        if options.seed is not None or now - begin >= options.seconds:
            break
        if now - said > 30.0:
            print(f"{name}: {count} scenarios, {now - begin:.0f} s", flush=True)
            said = now
    print(f"{name}: {count} scenarios, {now - begin:.0f} s: passed" + (f" ({refused} names refused)" if refused else ""))
    return 0


if __name__ == "__main__":
    sys.exit(main())
