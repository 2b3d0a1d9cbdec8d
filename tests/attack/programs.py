#!/usr/bin/env python3
"""Attacks the programs from outside: full and read-only disks, killed processes, pages with hostile names.

programs.py --tool ENAMEL --surface disk|kill|pages --seconds S --state FOLDER draws scenarios from a seed that counts up;
FOLDER/seed holds the next one. --seed N repeats one. disk: a small tmpfs in a mount namespace of its own, filled, without
inodes or read-only, or a limit of the size of files; a command ends with its whole output or one line that names the file,
and works once there is room. kill: signals at random moments; the finished files have the bytes of an undisturbed run.
pages: reports, comparisons and recordings opened in Chromium; no name becomes an element, a script or a request. Status:
0 passed, 1 a failure (its folder stays), 4 the surface cannot run here."""
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
import xml.etree.ElementTree
from pathlib import Path

DATA = Path(__file__).resolve().parent.parent.parent / "data"
DEVICE = ["--device", str(DATA / "devices/tau-nominal.toml")]
LIMIT = 120.0  # s: a command that takes longer hangs
SIGNALS = [signal.SIGKILL, signal.SIGKILL, signal.SIGTERM, signal.SIGINT]
PROGRESS = re.compile(r"\d+ of \d+ runs|[a-z-]+, delay |enamel: warning: ")  # what commands say on stderr beside errors


class Failure(Exception):
    pass


def need(condition, expected, happened):
    if not condition:
        raise Failure(f"expected: {expected}; happened: {happened}")


def contents(paths, base):
    """All files of paths below base, by relative name; figures and part files of runs too."""
    files = [f for p in paths for f in ([base / p] if not (base / p).is_dir() else sorted((base / p).rglob("*")))]
    return {str(f.relative_to(base)): f.read_bytes() for f in files if f.is_file()}


class Job:
    """A command with random options, and the files and folders that it writes."""

    def __init__(self, random_, kinds):
        self.kind = random_.choice(kinds)
        seed, renderer = str(random_.randint(1, 3)), random_.choice(["position-control", "hold", "impedance"])
        self.more, self.outputs = [], ["out"]
        if self.kind == "push":
            self.outputs = [["out.rec"], ["out.csv"], ["out.csv", "out.rec"]][random_.randrange(3)]
            self.args = ["push", *DEVICE, "--renderer", renderer, "--seed", seed, "--device-damping", "4", "--duration",
                         random_.choice(["1.1", "3"])]
            for name in self.outputs:
                self.args += ["--record" if name.endswith("rec") else "--output", name]
        elif self.kind == "study":
            self.args = ["study", "--no-convergence", "--renderers", random_.choice([renderer, "position-control,hold"]),
                         "--grid", random_.choice("13"), "--runs", str(random_.randint(2, 6)), "--scenario",
                         random_.choice(["1", "1,2"]), "--seed", seed, "--threads", random_.choice("12"), "--output", "out"]
        elif self.kind == "compare":
            self.args = ["compare", *DEVICE, "--renderers", f"{renderer},passivity", "--grid", "1", "--runs",
                         random_.choice("258"), "--plants", "closed-form", "--delays", "none,constant:1", "--tasks",
                         random_.choice(["push", "push,release,impact"]), "--seed", seed, "--output", "out"]
        else:
            self.outputs = ["out." + {"design": "json", "mesh": "stl", "prepare": "ply", "fmu": "fmu", "replay": "html",
                                      "evaluate": "json"}[self.kind]]
            self.args = {"design": ["design", *DEVICE, "--rate", random_.choice(["1000", "2000"]), "--output"],
                         "mesh": ["mesh", "--generate", random_.choice(["molar", "jaw"]), "--output"],
                         "prepare": ["mesh", "open.obj", "--deviation", random_.choice(["0", "20"]), "--prepare"],
                         "fmu": ["fmu", *DEVICE, *random_.choice([[], ["--renderer", renderer]]), "--output"],
                         "replay": ["replay", "in.rec", "--html"],
                         "evaluate": ["evaluate", *DEVICE, "--input", "rows.json", "--output"]}[self.kind] + self.outputs
        self.isStudy = self.kind in ("study", "compare")

    def on(self):
        """The options that go on where the job was disturbed."""
        return ["--resume"] if self.isStudy else ["--overwrite"]


class Attack:
    def __init__(self, tool, seed, folder):
        self.tool, self.seed, self.folder, self.random = tool, seed, folder, random.Random(seed)
        self.command, self.cleanups, self.note, self.refused = [], [], "", False

    def run(self, args, cwd, **options):
        """Status (minus the signal) and standard error of a command that must not hang."""
        self.command = [self.tool, *args]
        try:
            done = subprocess.run(self.command, cwd=cwd, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, timeout=LIMIT, **options)
        except subprocess.TimeoutExpired:
            raise Failure(f"expected: an end within {LIMIT:.0f} s; happened: none")
        return done.returncode, done.stderr.decode(errors="surrogateescape")

    def oneLine(self, text, names):
        lines = [line for line in text.splitlines() if not PROGRESS.match(line)]
        good = len(lines) == 1 and lines[0].startswith("enamel: ") and (not names or any(n in lines[0] for n in names))
        need(good, f"one line \"enamel: ...\" that names {' or '.join(names) or 'it'}", repr(text[-600:]))

    def inputs(self, place):
        (place / "open.obj").write_text("v 0 0 0\nv 9 0 0\nv 0 9 0\nv 0 0 9\nf 1 3 2\nf 1 2 4\nf 1 4 3\n")
        (place / "rows.json").write_text(json.dumps([{"q": [1e-3 * i, 0, 0, 0, 0, 0]} for i in range(40)]))
        need(self.run(["push", *DEVICE, "--duration", "0.5", "--record", "in.rec"], place)[0] == 0, "a recording", "none")

    def wholeRun(self, job, name="whole"):
        """What the job writes undisturbed, checked, and how long it takes."""
        place = self.folder / name
        place.mkdir()
        self.inputs(place)
        begin = time.monotonic()
        status, text = self.run(job.args, place)
        need(status == 0, "an undisturbed run ends with 0", f"{status}: {text[-600:]}")
        took, files = time.monotonic() - begin, contents(job.outputs, place)
        for file, data in files.items():
            if file.endswith(".json"):
                json.loads(data)
            if file.endswith((".stl", ".ply")):
                need(self.run(["mesh", file], place)[0] == 0, "a mesh that loads", file)
            if file.endswith(".rec"):
                need(self.run(["replay", file], place)[0] == 0, "a recording that replays equal", file)
        return files, took

    def noParts(self, place, most=0):
        left = [str(f) for f in place.rglob("*.part")]
        need(len(left) <= most, f"at most {most} files *.part", f"{len(left)}: {left[:3]}")

    def oldOrNew(self, job, place, old, whole):
        """A single file is whole; study and compare remove results before they begin, a new recording grows."""
        for name in job.outputs if not job.isStudy else ():
            now = (place / name).read_bytes() if (place / name).exists() else None
            grows = name.endswith("rec") and name not in old
            need(grows or now in (old.get(name), whole[name]), f"{name} as it was or as it becomes",
                 "it is gone" if now is None else f"{len(now)} bytes of neither")

    def finish(self, job, place, whole):
        """The disturbed job goes on and ends with the bytes of an undisturbed one."""
        args = [a for a in job.args if a != "--overwrite"]
        status, text = self.run(args + job.on(), place)
        if status != 0 and job.isStudy and "holds another study" in text:  # it was disturbed before it replaced that
            self.oneLine(text, ["out"])
            status, text = self.run(args + ["--overwrite"], place)
        need(status == 0, "the next run ends with 0", f"{status}: {text[-600:]}")
        now = contents(job.outputs, place)
        bad = [n for n in whole.keys() | now.keys() if whole.get(n) != now.get(n) and not re.search(r"-of-\d+\.csv$|\.part$", n)]
        need(not bad, "the bytes of an undisturbed run", f"other bytes in {bad}")

    def prepareOld(self, job, place):
        """With chance 1/2 old results, which the job replaces."""
        if self.random.random() < 0.5:
            return {}
        args = list(job.args)
        if "--seed" in args:
            args[args.index("--seed") + 1] = "9"
        need(self.run(args, place)[0] == 0, "old results", "none")
        for name in job.outputs:
            if (place / name).is_file() and not name.endswith("rec"):
                (place / name).write_bytes(b"old\n" * self.random.randint(1, 5000))
        job.args.append("--overwrite")
        return contents(job.outputs, place)

    # ---- disk ----

    def mount(self, place, options):
        subprocess.run(["mount", "-t", "tmpfs", "-o", options, "none", str(place)], check=True)
        self.cleanups.append(lambda: subprocess.run(["umount", "-l", str(place)]))

    def disk(self):
        job = Job(self.random, ["push", "push", "study", "study", "compare", "design", "mesh", "prepare", "fmu", "replay", "evaluate"])
        whole, took = self.wholeRun(job)
        size = sum(len(data) for data in whole.values())
        place, how = self.folder / "disk", self.random.choice(["small", "full", "inodes", "read-only", "limit", "other user"])
        place.mkdir()
        room = 4 * size + (12 << 20)  # study needs 8 MB before it begins
        if how not in ("limit", "other user"):
            if os.environ.get("ENAMEL_ATTACK_MOUNTS") != "yes":
                how = "limit"
            else:
                self.mount(place, f"size={room // 1024}k,nr_inodes=200")
        self.inputs(place)
        old = self.prepareOld(job, place)
        self.note = f"{how}, {'old results' if old else 'no results yet'}"
        options, thread, stop, delay = {}, None, threading.Event(), self.random.uniform(-0.3, 1.0) * took
        share, isLate = self.random.random(), delay > 0 and how in ("small", "full", "inodes", "read-only")

        def disturb():
            stop.wait(max(0.0, delay))
            if how in ("small", "full"):  # small: room for a part of the output
                free = os.statvfs(place).f_bavail * os.statvfs(place).f_frsize - (int(share * size) if how == "small" else 0)
                with contextlib.suppress(OSError), open(place / "filler", "wb", buffering=0) as file:  # full: that is the aim
                    while free > 0 or how == "full":
                        free -= file.write(bytes(min(65536, max(4096, free))))
            elif how == "inodes":
                subprocess.run(["mount", "-o", f"remount,nr_inodes={200 - os.statvfs(place).f_favail + int(4 * share)}", str(place)])
            while how == "read-only" and not stop.is_set() and subprocess.run(
                    ["mount", "-o", "remount,ro", str(place)], stderr=subprocess.DEVNULL).returncode != 0:
                time.sleep(0.002)  # a file is being written

        if how == "limit":
            most = int(share * max(len(data) for data in whole.values()))
            options["preexec_fn"] = lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (most, most))
        elif how == "other user" and os.geteuid() == 0:
            options["preexec_fn"] = lambda: (os.setgroups([]), os.setgid(65534), os.setuid(65534))
            self.folder.chmod(0o755)
        elif how == "other user":
            place.chmod(0o555)
        elif isLate:
            thread = threading.Thread(target=disturb)
            thread.start()
        else:
            disturb()
        try:
            status, text = self.run(job.args, place, **options)
        finally:
            stop.set()
            if thread:
                thread.join()
            if how == "other user":
                place.chmod(0o755)
        need(status >= 0, "no crash", f"signal {-status}")
        self.noParts(place)
        if status != 0:
            self.oneLine(text, job.outputs)
            self.oldOrNew(job, place, old, whole)
        else:
            now = contents(job.outputs, place)
            need(now == whole, "the whole output with status 0", f"other bytes in {[n for n in whole if now.get(n) != whole[n]]}")
        if how in ("inodes", "read-only"):
            subprocess.run(["mount", "-o", "remount,rw,nr_inodes=400", str(place)], check=True)
        (place / "filler").unlink(missing_ok=True)
        self.finish(job, place, whole)

    # ---- kill ----

    def killOne(self, args, place, seconds, container):
        wrap = ["unshare", "-p", "-f", "--kill-child", "--"] if container else []  # the same process number every time
        self.command = [*wrap, self.tool, *args]
        process = subprocess.Popen(self.command, cwd=place, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
        return process, time.monotonic() + self.random.uniform(0.0, seconds), signal.SIGKILL if container else self.random.choice(SIGNALS)

    def kill(self):
        job = Job(self.random, ["study", "study", "study", "compare", "compare", "push", "push", "design", "mesh", "fmu", "replay"])
        whole, took = self.wholeRun(job)
        place = self.folder / "killed"
        place.mkdir()
        self.inputs(place)
        old = self.prepareOld(job, place)
        bystanders = {"note.txt": b"mine", "out.json.bak": b"", "other.part": b"p"}
        if job.isStudy:
            (place / "out").mkdir(exist_ok=True)
            bystanders.update({"out/runs-notes.txt": b"mine", "out/mine.csv": b"1,2\n"})
        for name, data in bystanders.items():
            (place / name).write_bytes(data)
        parts = self.random.choice([1, 1, 2, 3]) if job.kind == "study" and not old else 1
        together = 2 if job.isStudy and parts == 1 and self.random.random() < 0.3 else 1
        container = os.geteuid() == 0 and self.random.random() < 0.3
        mixed = parts > 1 and self.random.random() < 0.4  # begins without --part
        kills, times = 0, self.random.randint(1, 12)
        self.note = f"{parts} parts, {together} at once, {times} times{', one process number' if container else ''}"
        for turn in range(times):
            first = turn == 0 or (job.isStudy and not (place / "out").exists())
            args = job.args if first or parts > 1 else [a for a in job.args if a != "--overwrite"] + job.on()
            if job.isStudy and turn > 0 and not list(place.glob("out/**/runs.csv")):
                args = job.args
            started = [self.killOne(args + (["--part", f"{i}/{parts}"] if parts > 1 and not (mixed and turn == 0) else []), place, 1.2 * took, container)
                       for i in range(1, (1 if mixed and turn == 0 else max(parts, together)) + 1)]
            for process, end, how in sorted(started, key=lambda s: s[1]):
                try:
                    process.wait(max(0.0, end - time.monotonic()))
                except subprocess.TimeoutExpired:
                    process.send_signal(how)
                try:
                    text = process.communicate(timeout=LIMIT)[1].decode(errors="surrogateescape")
                except subprocess.TimeoutExpired:
                    raise Failure(f"expected: an end within {LIMIT:.0f} s of signal {how}; happened: none")
                time.sleep(0.05 if container else 0.0)  # the program outlives what stands around it for an instant
                kills += process.returncode != 0
                allowed = [0, -how, 128 + how] + ([1] if together > 1 or mixed or (old and job.isStudy) else [])
                need(process.returncode in allowed, f"status in {allowed}", f"{process.returncode}: {text[-600:]}")
                if process.returncode > 0 and process.returncode != 128 + signal.SIGKILL:
                    self.oneLine(text, ["out"])
            self.noParts(place, kills * len(job.outputs) + 1)
            self.oldOrNew(job, place, old, whole)
            for name in job.outputs:
                if name.endswith("rec") and (place / name).exists():
                    status, text = self.run(["replay", name], place)
                    short = (place / name).stat().st_size < 65536 and status == 1
                    need(status == 0 or short, "a killed recording replays equal", f"{status}: {text[-600:]}")
        for i in range(1, parts + 1) if parts > 1 else ():
            need(self.run(job.args + ["--part", f"{i}/{parts}"], place)[0] in (0, int(mixed)), "a part that ends", "an error")
        for name in bystanders:
            need((place / name).exists() and (place / name).read_bytes() == bystanders[name], f"{name} untouched", "it changed")
            (place / name).unlink()
        self.finish(job, place, whole)

    # ---- pages ----

    def hostileName(self, forFile=False):
        own, port = "document.documentElement.className=document.title='owned'", self.port
        pieces = ["<script>OWN</script>", "<img src=x onerror=OWN>", "\"><img src=x onerror=\"OWN\">", "</script><script>OWN</script>",
                  "</title><script>OWN</script>", "</svg><img src=x onerror=OWN>", "</style><svg onload=OWN>", "<svg onload=OWN>",
                  "${OWN}", "`+OWN+`", "'+OWN+'", "\\\");OWN//", "{{OWN}}", "javascript:OWN", "]]>", "<!--", "-->", "<![CDATA[",
                  "&lt;script&gt;OWN", "&#60;img src=x onerror=OWN&#62;", "&", "&amp", "\u2028OWN\u2029", "\u202eOWN\u2066", "\ufeff",
                  "\ufffe\uffff", "e\u0301" * 20, f"<base href=http://127.0.0.1:{port}>", f"<img src=http://127.0.0.1:{port}/a>",
                  f"<meta http-equiv=refresh content=0;url=http://127.0.0.1:{port}>", f"url(http://127.0.0.1:{port})",
                  f"<iframe srcdoc='<script>top.OWN</script>'>", "/*DATA*/", "/*SCRIPT*/", "/*STYLE*/", "%s%n{}{0:n}", "a_b -1 5 N m",
                  "<b style=position:fixed>", "<td class=no>", "</td></table>", "<sub>", "M" * 900]
        name = "".join(self.random.choice(pieces) for _ in range(self.random.randint(1, 3))).replace("OWN", own)
        if self.random.random() < 0.1:
            name = self.random.choice(["__proto__", "constructor", "force", "depth", "toString", "gum", "view", "error", "sides"])
        if not forFile:
            return "Zq7" + name[:1500] if len(name) > 20 else name
        name = name.replace("/", self.random.choice(["", "\u2215"])).replace(",", "")
        if self.random.random() < 0.05:
            name += self.random.choice(["\x01", "\x1b[31m", "\n", "\udcff", "\x7f", "\t"])
        return "Zq7" + os.fsencode(name)[:150].decode(errors="surrogateescape")

    def makePages(self, names, place, kind):
        """Pages with these names in them; the path of the page. None: a command refused a name in one line."""
        def toml(name):
            return json.dumps(name).replace("\x7f", "\\u007f")

        place.mkdir()
        device, servo, scene, out = (place / (names[i] + end) for i, end in enumerate((".toml", ".json", "-scene.toml", "")))
        device.write_text(re.sub(r'(?m)^name = .*', lambda m: "name = " + toml(names[4]), (DATA / "devices/tau-nominal.toml").read_text()))
        shutil.copy(DATA / "servos/tau-hold-0.json", servo)
        text = f"name = {toml(names[5])}\nstart = [0.0, 0.0, 0.004]\n[[tool]]\nfrom = [0.0, 0.0, 0.001]\nradius = 0.001\n" \
               f"[[tool]]\nfrom = [0.0, 0.0, 0.002]\nto = [0.0, 0.0, 0.022]\nradius = 0.0006\n[bur]\npart = 0\nwear = 0.5\n" \
               f"[[obstacle]]\nname = {toml(names[6])}\nshape = \"solid\"\nfile = \"cube.ply\"\nunit = \"mm\"\ncell = 0.0005\n" \
               f"position = [-0.0045, -0.0045, -0.009]\n"
        text += "".join(f"[[obstacle.layer]]\nname = {toml(names[7 + i])}\nhardness = {3 - i}.0e9\ndepth = {2e-3 * i}\n".replace("depth = 0.0\n", "")
                        for i in range(2))
        scene.write_text(text + f"[[obstacle]]\nname = {toml(names[9])}\nshape = \"half_space\"\npoint = [0.0, 0.0, -0.012]\nnormal = [0.0, 0.0, 1.0]\n")
        corners = "\n".join(f"{9 * (i & 1)} {9 * (i >> 1 & 1)} {9 * (i >> 2)}" for i in range(8))
        quads = "\n".join(f"4 {f}" for f in ("0 2 3 1", "4 5 7 6", "0 1 5 4", "2 6 7 3", "0 4 6 2", "1 3 7 5"))
        (place / "cube.ply").write_text("ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n"
                                        f"element face 6\nproperty list uchar int vertex_indices\nend_header\n{corners}\n{quads}\n")
        where = ["--device", str(device), "--output", str(out)]
        tuned = place / "tuned.json"
        tuned.write_text(re.sub(r'"model": *"(?:[^"\\\\]|\\\\.)*"', lambda m: '"model": ' + json.dumps(names[4]),
                                (DATA / "servos/rivals-tau.json").read_text()))
        commands = {"study": [["study", "--no-convergence", "--renderers", f"{servo},impedance", "--grid", "3", "--runs", "2", *where]],
                    "scene study": [["study", "--no-convergence", "--renderers", f"{servo},position-control", "--grid", "1", "--runs",
                                     "2", "--scene", str(scene), *where]],
                    "compare": [["compare", "--renderers", f"{servo},position-control,tuned:impedance", "--tuned", str(tuned), "--grid",
                                 "1", "--runs", "3", "--plants", "closed-form", "--delays", "none", "--tasks", "push,release", *where]],
                    "replay": [["push", "--device", str(device), "--scene", str(scene), "--renderer", "hold", "--gain", str(servo),
                                "--duration", "1.2", "--record", f"{out}.rec"],
                               ["replay", f"{out}.rec", "--renderer", "impedance", "--html", f"{out}.html"]]}[kind]
        for command in commands:
            status, text = self.run(command, place)
            need(status in (0, 1), "status 0 or 1", f"{status}: {text[-600:]}")
            isThere = (out / "report.html").exists() or (out / "compare.html").exists() or os.path.exists(f"{out}.rec")
            if status == 1 and not (isThere and "--html" not in command and command[0] == "push"):
                if "--html" in command and os.path.exists(f"{out}.html"):
                    continue  # another renderer differs: status 1 without a word
                self.oneLine(text, [])
                return None
        return {"compare": out / "compare.html", "replay": Path(f"{out}.html")}.get(kind, out / "report.html")

    def open(self, page):
        url = "file://" + "".join(chr(b) if chr(b).isalnum() and b < 128 or b in b"/._-" else f"%{b:02X}" for b in os.fsencode(page))
        self.command = ["chromium", "--headless", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
                        "--disable-background-networking", "--disable-component-update", "--no-first-run", "--enable-logging=stderr",
                        f"--user-data-dir={self.folder / 'browser'}", "--virtual-time-budget=3000", "--dump-dom", url + "#t=0.5"]
        try:
            done = subprocess.run(self.command, capture_output=True, timeout=LIMIT)
        except subprocess.TimeoutExpired:
            raise Failure(f"expected: the page opens within {LIMIT:.0f} s; happened: no end")
        said = [line for line in done.stderr.decode(errors="replace").splitlines() if ":CONSOLE" in line and "GL Driver" not in line]
        return Elements(done.stdout.decode(errors="replace")), said

    def pages(self):
        kind = self.note = self.random.choice(["study", "scene study", "compare", "replay", "replay"])
        with socket.create_server(("127.0.0.1", 0)) as server:
            self.port = server.getsockname()[1]
            plain = self.open(self.makePages([f"plain{i}" for i in range(10)], self.folder / "plain", kind))[0]
            names = [self.hostileName(i < 4) for i in range(10)]
            page = self.makePages(names, self.folder / "hostile", kind)
            if page is None:
                self.refused = True
                return
            seen, said = self.open(page)
            need(seen.title != "owned" and "owned" not in seen.classes, "no script of a name runs", f"title {seen.title[:80]}")
            need(not said, "nothing on the console", repr(said[:3]))
            more = {k for k in seen.kinds if k not in plain.kinds and k[0] not in ("sub", "tspan")}
            need(not more, "only elements and attributes of a page with plain names", f"also {sorted(more)[:5]}")
            for tag in ("script", "style", "title", "table", "tr", "td", "th", "figure", "svg", "dt", "dd", "p", "h1", "h2"):
                need(seen.counts[tag] == plain.counts[tag], f"{plain.counts[tag]} elements {tag}", str(seen.counts[tag]))
            need(len(seen.text) > 0.8 * len(plain.text), "the page's text", f"{len(seen.text)} of {len(plain.text)} characters")
            marks = [names[4 if kind != "replay" else 5]] + ([names[7]] if kind == "replay" else [])
            for name in marks:
                need("Zq7" not in name or "Zq7" in seen.text, "the names are shown", "they are missing")
            if kind == "replay":
                body = dict(seen.body)
                need(body.get("data-ready") == "yes" and "data-error" not in body, "the page's script ran", str(body)[:200])
                need(not seen.emptyValues, "every row of the panel has its value", f"{seen.emptyValues} are empty")
            for figure in page.parent.glob("figures/*.svg"):
                try:
                    tags = {e.tag.split("}")[-1] for e in xml.etree.ElementTree.parse(figure).iter()}
                except xml.etree.ElementTree.ParseError as error:
                    raise Failure(f"expected: {figure.name} is XML; happened: {error}")
                need(not tags & {"script", "img", "iframe", "foreignObject", "a"}, "plain shapes", f"{figure.name} has {tags}")
            server.setblocking(False)
            try:
                server.accept()
                raise Failure("expected: no request; happened: the page made one")
            except BlockingIOError:
                pass


class Elements(html.parser.HTMLParser):
    """The elements of a page as the browser dumps it."""

    def __init__(self, text):
        super().__init__()
        self.kinds, self.counts, self.title, self.text, self.classes, self.body = set(), collections.Counter(), "", "", "", []
        self.inside, self.emptyValues, self.value = "", 0, None
        self.feed(text)
        self.text = re.sub(r"\s+", " ", self.text)

    def handle_starttag(self, tag, attributes):
        self.kinds.add((tag, tuple(sorted(name for name, _ in attributes))))
        self.counts[tag] += 1
        self.inside = tag
        if tag == "html":
            self.classes = dict(attributes).get("class") or ""
        if tag == "body":
            self.body = attributes
        if tag == "dd":
            self.value = ""

    def handle_endtag(self, tag):
        if tag == "dd":
            self.emptyValues += not self.value
            self.value = None
        self.inside = ""

    def handle_data(self, data):
        if self.inside == "title" and self.counts["title"] == 1:
            self.title += data
        if self.inside not in ("script", "style"):
            self.text += data
        if self.value is not None:
            self.value += data


def unableReason(surface):
    if surface == "pages" and shutil.which("chromium") is None:
        return "chromium is not installed"
    return None


def ownMounts(arguments):
    """Starts again in a mount namespace of its own, where that is possible."""
    if "ENAMEL_ATTACK_MOUNTS" in os.environ:
        return
    wrap = ["unshare", "-m" if os.geteuid() == 0 else "-rm"]
    test = "t=$(mktemp -d) && mount -t tmpfs -o size=64k none $t && umount $t; s=$?; rmdir $t; exit $s"
    able = shutil.which("unshare") and subprocess.run([*wrap, "sh", "-c", test], stderr=subprocess.DEVNULL).returncode == 0
    os.environ["ENAMEL_ATTACK_MOUNTS"] = "yes" if able else "no"
    if able:
        os.execvp("unshare", [*wrap, sys.executable, *arguments])
    print("disk: no mounts here: only limits of the size of files and folders without permission", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tool", required=True)
    parser.add_argument("--surface", required=True, choices=["disk", "kill", "pages"])
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--state", required=True)
    parser.add_argument("--seed", type=int, help="this scenario alone")
    options = parser.parse_args()
    if reason := unableReason(options.surface):
        print(f"{options.surface}: cannot run here: {reason}")
        return 4
    if options.surface == "disk":
        ownMounts(sys.argv)
    state = Path(options.state).absolute()
    state.mkdir(parents=True, exist_ok=True)
    counter = state / "seed"
    seed = options.seed if options.seed is not None else int(counter.read_text()) if counter.exists() else 1
    begin = said = time.monotonic()
    count = refused = 0
    while True:
        folder = Path(tempfile.mkdtemp(prefix=f"{options.surface}-{seed}-", dir=state))
        attack = Attack(str(Path(options.tool).absolute()), seed, folder)
        try:
            getattr(attack, options.surface)()
        except Failure as failure:
            command = " ".join(attack.command)
            print(f"{options.surface}: seed {seed} ({attack.note}): {command!a}: {str(failure)!a}; folder {folder}", flush=True)
            return 1
        finally:
            for cleanup in attack.cleanups:
                cleanup()
        shutil.rmtree(folder)
        count, refused = count + 1, refused + attack.refused
        if options.seed is not None:
            break
        seed += 1
        counter.write_text(f"{seed}\n")
        now = time.monotonic()
        if now - said > 30.0:
            print(f"{options.surface}: {count} scenarios, {now - begin:.0f} s", flush=True)
            said = now
        if now - begin >= options.seconds:
            break
    print(f"{options.surface}: {count} scenarios, {time.monotonic() - begin:.0f} s: passed" + (f" ({refused} names refused)" if refused else ""))
    return 0


if __name__ == "__main__":
    sys.exit(main())
