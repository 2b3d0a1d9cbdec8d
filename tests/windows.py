"""Compare the build for Windows, under Wine, with a build for Linux: windows.py LINUX_BUILD WINDOWS_BUILD.

Results that use no function of the C library (exp, log, hypot, atan2, ...) must have the same bits. Others must agree
within the bounds below. Then the tool runs as a person would use it, in a folder and with files whose names are not ASCII.
"""
import os
import re
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
from pathlib import Path

SOURCE = Path(__file__).resolve().parent.parent
LINUX, WINDOWS = (Path(p).resolve() for p in sys.argv[1:3])
WINE = "/usr/lib/wine/wine64"
DEVICE = SOURCE / "data/devices/tau-nominal.toml"
TOOLS = {"linux": [LINUX / "apps/enamel/enamel"], "windows": [WINE, WINDOWS / "apps/enamel/enamel.exe"]}
TICKS = 3000  # of each renderer in test_bits
# Largest difference of position, rotation, speed or torque in the 3 s of a push. The noise of the push uses log and
# cos. Position control uses exp, log and hypot each tick, and the loop amplifies their last bits.
BOUNDS = {"hold": 1e-12, "position-control": 1e-6, "impedance": 0.0}
PUSH_BOUND = 1e-9  # SI units: the joint angles of the plant use atan2, and position control uses exp, log and hypot
REPLAY_BOUND = 1e-6  # N m: the same measurements, so that nothing is amplified by the plant

os.environ["LC_ALL"] = "C.UTF-8"  # Wine reads file names in it
failures = []


def check(what, condition, detail=""):
    print(f"{'passed' if condition else 'FAILED'}  {what}{': ' + str(detail) if detail else ''}", flush=True)
    if not condition:
        failures.append(what)


def run(system, *arguments, folder=None):
    """Return the exit status and the whole output."""
    done = subprocess.run([*TOOLS[system], *arguments], cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          timeout=600, check=False)
    return done.returncode, done.stdout.decode()


def compare_bits():
    rows = {}
    for system, command in (("linux", [LINUX / "tests/test_bits"]), ("windows", [WINE, WINDOWS / "tests/test_bits.exe"])):
        text = subprocess.run(command, stdout=subprocess.PIPE, check=True).stdout.decode()
        rows[system] = [line.split() for line in text.splitlines()]
    check("test_bits: number of ticks", len(rows["linux"]) == len(rows["windows"]) == TICKS * len(BOUNDS))
    for k, (renderer, bound) in enumerate(BOUNDS.items()):
        pairs = list(zip(rows["linux"], rows["windows"]))[k * TICKS:(k + 1) * TICKS]
        differ = sum(a != b for a, b in pairs)
        most = max(abs(float.fromhex(x) - float.fromhex(y)) for a, b in pairs for x, y in zip(a, b))
        check(f"test_bits, {renderer}", most <= bound and (bound > 0 or differ == 0),
              f"{differ} of {TICKS} ticks differ, by {most:.1e} at most")


def compare_c_programs(folder):
    """The same C program with libenamel.so and with libenamel.dll, which Windows looks for beside the program."""
    for file in ("tests/c_push.exe", "lib/libenamel.dll"):
        shutil.copy(WINDOWS / file, folder)
    rows = [subprocess.run(command, stdout=subprocess.PIPE, check=True).stdout.split()
            for command in ([LINUX / "tests/c_push"], [WINE, folder / "c_push.exe"])]
    torques = [[struct.unpack(">d", bytes.fromhex(word.decode()))[0] for word in words] for words in rows]
    check("C program: the number of torques", len(rows[0]) == len(rows[1]) == 300 * 6)
    most = max(abs(a - b) for a, b in zip(*torques))
    differ = sum(a != b for a, b in zip(*rows))
    check("C program: the same torques with libenamel.dll", most <= PUSH_BOUND, f"{differ} differ, by {most:.1e} N m at most")


def compare_pushes(folder):
    push = ["push", "--device", DEVICE, "--renderer", "impedance", "--device-damping", "4", "--noise", "0"]
    for system in TOOLS:
        status, text = run(system, *push, "--output", f"{system}-ö.csv", "--record", f"{system}-ö.rec", folder=folder)
        check(f"push on {system}", status == 0, text if status else "")
    tables = [[line.split(",") for line in (folder / f"{system}-ö.csv").read_text().splitlines()] for system in TOOLS]
    check("push: the same columns", tables[0][0] == tables[1][0] and len(tables[0]) == len(tables[1]) == TICKS + 1)
    cells = [(a, b) for rows in zip(*tables) for a, b in zip(*rows) if a != b]
    most = max((abs(float(a) - float(b)) for a, b in cells), default=0.0)
    check("push: the same numbers", most <= PUSH_BOUND, f"{len(cells)} differ, by {most:.1e} at most")
    status, text = run("windows", *push, "--output", "windows-ö.csv", folder=folder)
    check("an existing file is not replaced", status == 1 and "--overwrite replaces it" in text)
    status, text = run("windows", *push, "--output", "windows-ö.csv", "--overwrite", folder=folder)
    check("and replaced on request", status == 0)
    left = [name for name in os.listdir(folder) if name.endswith(".part")]
    check("no temporary file is left", not left, left)


def compare_replays(folder):
    for renderer in BOUNDS:
        for system, other in (("linux", "windows"), ("windows", "linux")):
            name = f"{renderer}-{system}.rec"
            damping = ["--device-damping", "4"] if renderer == "impedance" else []
            status, text = run(system, "push", "--device", DEVICE, "--renderer", renderer, *damping, "--encoders",
                               "--rates", "low-pass", "--record", name, folder=folder)
            check(f"record {renderer} on {system}", status == 0, text if status else "")
            status, text = run(system, "replay", name, folder=folder)
            check(f"replay {renderer} where it was recorded", status == 0, text if status else "")
            status, text = run(other, "replay", name, folder=folder)
            differ = re.search(r"(\d+) ticks differ.*\n.*requested torque (.*); command (.*)", text)
            if renderer == "position-control" and differ:
                most = max(float(x) for x in re.split("[, ]+", differ[2] + " " + differ[3]))
                check(f"replay {renderer} of {system} on {other}", most <= REPLAY_BOUND,
                      f"{differ[1]} ticks differ, by {most:.1e} N m at most")
            else:
                check(f"replay {renderer} of {system} on {other}: the same bits", status == 0, text if status else "")


def check_plugins():
    folder = WINDOWS / "plugins"
    status, text = run("windows", "plugins", folder)
    names = [f"\n{name} " in "\n" + text for name in ("impedance", "position-control", "template")]
    check("plugins: three are listed, each loaded in a process of its own", status == 0 and all(names), "" if all(names) else text)
    status, text = run("windows", "check-plugin", folder / "enamel_template.dll", "--set", "stiffness=1000")
    check("check-plugin: the template keeps the contract", status == 0 and "keeps the contract" in text, text if status else "")
    for way, message in (("nan", "does not keep the contract"), ("crash", "ended in a crash")):
        status, text = run("windows", "check-plugin", WINDOWS / f"tests/bad_plugins/bad_{way}.dll")
        check(f"check-plugin: bad_{way} is refused", status == 1 and message in text, text.splitlines()[-1])
    status, text = run("windows", "plugins", "--time-limit", "1", WINDOWS / "tests/failing_plugins")
    for way, message in (("throwing", "threw: thrown while it was loaded"), ("crashing", "ended in a crash"),
                         ("loading", "ended in a crash"), ("hanging", "did not end in 3 s"),
                         ("exiting", "ended the process with exit status 0")):
        line = next((line for line in text.splitlines() if f"{way}_plugin.dll: " in line), "not listed")
        check(f"plugins: {way}_plugin is refused", status == 0 and message in line, line)
    status, text = run("windows", "check-plugin", DEVICE)
    check("check-plugin: a text is no plugin", status == 1 and "is not a shared library" in text, text.strip())


def check_device_over_udp():
    for server, client in (("windows", "windows"), ("linux", "windows"), ("windows", "linux")):
        serving = subprocess.Popen([*TOOLS[server], "device", "--serve", "virtual:", "--port", "0", "--duration", "8"],
                                   stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        port = re.search(r":(\d+), ", serving.stdout.readline().decode())
        status, text = run(client, "device", "--connect", f"udp://127.0.0.1:{port[1]}", "--renderer", "impedance", "--duration", "2")
        accepted = re.search(r"datagrams sent \d+, accepted (\d+)", text)
        # A busy machine misses deadlines, and the guard may then stop the tool: status 1 with its reason.
        check(f"device: {client} on the server of {server}", accepted is not None and int(accepted[1]) > 100 and
              (status == 0 or "stopped by the guard" in text), accepted[0] if accepted else text)
        serving.send_signal(signal.SIGTERM)
        serving.wait()


def check_study(folder):
    for threads in ("1", "2"):
        status, text = run("windows", "study", "--renderers", "impedance", "--grid", "2", "--runs", "2",
                           "--no-convergence", "--threads", threads, "--output", f"study-{threads}", folder=folder)
        check(f"study with {threads} threads", status == 0, text if status else "")
    runs = [(folder / f"study-{threads}/runs.csv").read_bytes() for threads in ("1", "2")]
    check("study: the same bytes whatever the threads", len(runs[0]) > 1000 and runs[0] == runs[1])


def main():
    compare_bits()
    with tempfile.TemporaryDirectory(prefix="enamel-zähne-歯-") as name:
        folder = Path(name)
        compare_c_programs(folder)
        compare_pushes(folder)
        compare_replays(folder)
        check_study(folder)
    check_plugins()
    check_device_over_udp()
    print(f"{len(failures)} checks failed")
    sys.exit(1 if failures else 0)


main()
