#!/usr/bin/env python3
"""What a day with studies costs: warm reruns, sweeps, a big store, reruns from a lock, two processes at once.

    python3 benches/studies.py target/release/rootvox [--data FOLDER] [--only NAME ...]

FOLDER holds licorice-sim (images/, tank.json, cameras.json); without it a simulated capture of 36 views stands in.
`dvc` and `snakemake` are timed beside rootvox where they are on the path. Only Python's standard library is needed.
Every figure is the best wall time of several runs, with the processor time of that run beside it.
"""
import argparse, json, os, re, resource, shutil, subprocess, sys, tempfile, time
from pathlib import Path

SIMULATED = """
[study]
name = "bench"
[tank]
radius = 30.0
height = 70.0
wall = 2.0
water_level = 5.0
belts = [[0.0, 8.0], [62.0, 70.0]]
[simulate]
seed = 3
capture = { views = %d, width = 160, height = 120, supersampling = 1 }
growth = { main = { length_mm = 50.0 }, first_order = { count = 6, length_mm = 20.0 }, second_order = { count = 0 } }
[grid]
spacing = 1.0
depth = 60.0
"""
FIGURE_6 = """
[sweep]
"render.exclude_irregular" = [true, false]
"rootness.gamma23, rootness.gamma12" = [[0.5, 0.5], [1.0, 1.0]]
"extract.low, extract.high" = [[0.4, 0.6], [0.5, 0.8], [0.65, 1.0], [1.0, 1.5]]
"""
EXTRACTIONS = """
[sweep]
"extract.low" = [0.4, 0.5, 0.6, 0.7]
"extract.high" = [0.8, 1.0, 1.2, 1.5]
"""


def run(command, cwd, check=True):
    """Wall seconds, processor seconds, both outputs."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    begin = time.perf_counter()
    done = subprocess.run([str(c) for c in command], cwd=cwd, capture_output=True, text=True)
    wall = time.perf_counter() - begin
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if check and done.returncode != 0:
        sys.exit(f"{command} failed:\n{done.stdout}{done.stderr}")
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return wall, cpu, done.stdout + done.stderr


def best(command, cwd, times=7):
    return min((run(command, cwd) for _ in range(times)), key=lambda r: r[0])


def counts(text):
    return tuple(int(n) for n in re.search(r"(\d+) nodes: (\d+) cached, (\d+) computed", text).groups())


def say(what, wall, cpu, goal=""):
    print(f"{what:52} {wall * 1000:9.1f} ms wall {cpu * 1000:9.1f} ms cpu  {goal}", flush=True)


def study(folder, more="", data=None, views=36):
    if data:
        text = f"""[study]\nname = "bench"\n[photos]\ndir = "{data}"\nimages = "images/*.jpg"
[tank]\nfile = "tank.json"\nbelts = [[0.0, 28.0], [214.6, 246.6]]\n[grid]\nspacing = 1.0\ndepth = 180.0\n"""
    else:
        text = SIMULATED % views
    (folder / "study.toml").write_text(text + more)


def warm(rootvox, folder, data):
    study(folder, data=data)
    _, _, text = run([rootvox, "run", "study.toml"], folder)
    nodes = counts(text)[0]
    wall, cpu, text = best([rootvox, "run", "study.toml"], folder)
    assert counts(text)[2] == 0, text
    say(f"rootvox run, nothing changed, {nodes} nodes", wall, cpu, "goal 50 ms")
    rivals(folder / "rivals", nodes, wall)


def rivals(folder, steps, ours):
    """The same number of steps, each a copy of a small file that hangs on the one before in chains of 8."""
    folder.mkdir()
    (folder / "0").write_text("x")
    edges = [(n, n - 1 if n % 8 else 0) for n in range(1, steps + 1)]
    if shutil.which("dvc"):
        run(["dvc", "init", "--no-scm", "-q"], folder)
        stages = "".join(f"  s{n}:\n    cmd: cp {of} {n}\n    deps: ['{of}']\n    outs: ['{n}']\n" for n, of in edges)
        (folder / "dvc.yaml").write_text("stages:\n" + stages)
        run(["dvc", "repro", "-q"], folder)
        wall, cpu, _ = best(["dvc", "repro", "-q"], folder, 3)
        say(f"dvc repro, nothing changed, {steps} stages", wall, cpu, f"{wall / ours:.0f} times ours")
    if shutil.which("snakemake"):
        rules = "".join(f'rule s{n}:\n  input: "{of}"\n  output: "s{n}"\n  shell: "cp {{input}} {{output}}"\n'
                        for n, of in ((n, "0" if of == 0 else f"s{of}") for n, of in edges))
        inputs = ", ".join(f'"s{n}"' for n, _ in edges)
        (folder / "Snakefile").write_text(f"rule all:\n  input: {inputs}\n" + rules)
        run(["snakemake", "-q", "-c2"], folder)
        wall, cpu, _ = best(["snakemake", "-n", "-q"], folder, 3)
        say(f"snakemake -n, nothing changed, {steps} rules", wall, cpu, f"{wall / ours:.0f} times ours")


def sweeps(rootvox, folder, data):
    study(folder, data=data)
    run([rootvox, "run", "study.toml"], folder)
    study(folder, EXTRACTIONS, data)
    wall, cpu, text = run([rootvox, "run", "study.toml"], folder)
    say(f"16 extractions at 1 mm on a warm cache, {counts(text)[2]} ran", wall, cpu, "goal 4 s")
    study(folder, FIGURE_6, data)
    wall, cpu, text = run([rootvox, "run", "study.toml", "--cache", "figure6"], folder)
    total, _, ran = counts(text)
    lock = json.loads((folder / "results/bench/study.lock").read_text())
    distinct = len({n["key"] for n in lock["nodes"] if "key" in n})
    assert ran == distinct, (ran, distinct)
    say(f"figure 6: 16 points, {distinct} distinct nodes, {ran} ran", wall, cpu)


def big(rootvox, folder, _data):
    coarse = SIMULATED.replace("spacing = 1.0", "spacing = 2.0") % 6
    sweep = "[sweep]\nextract.high = { from = 0.7, to = 3.0, count = 10000 }\n"
    (folder / "study.toml").write_text(coarse + sweep)
    (folder / "capture.toml").write_text(coarse)
    wall, cpu, text = run([rootvox, "run", "study.toml"], folder)
    say(f"a sweep of 10000 points, {counts(text)[2]} nodes ran", wall, cpu)
    wall, cpu, text = best([rootvox, "status", "capture.toml"], folder)
    say("status of a study beside them", wall, cpu, "goal 300 ms")
    wall, cpu, text = best([rootvox, "status", "study.toml"], folder, 3)
    say("status of the sweep itself: " + text.splitlines()[-1], wall, cpu)
    wall, cpu, text = best([rootvox, "cache", "du"], folder)
    say("cache du: " + text.splitlines()[-1].replace("  ", " "), wall, cpu, "goal 1000 ms")


def reruns(rootvox, folder, data):
    for name, source in [("simulated", None), ("photographs", data)]:
        if name == "photographs" and not data:
            continue
        study(folder, data=source)
        run([rootvox, "run", "study.toml", "--results", name], folder)
        for threads in (1, 2):
            wall, cpu, text = run([rootvox, "rerun", f"{name}/bench/study.lock", "--cache", f"empty-{name}-{threads}",
                                   "--threads", threads], folder)
            say(f"rerun {name}, {threads} thread(s): {text.splitlines()[0]}", wall, cpu)


def remaining(rootvox, folder, _data):
    """How the estimate of the time left compares with the time that was left, from the first tenth of the run on."""
    quickstart = Path(__file__).resolve().parent.parent / "pipelines/quickstart.toml"
    run([rootvox, "run", quickstart], folder)
    for change in ("simulate.seed=12", "render.sampling=point", "grid.spacing=0.6"):
        run([rootvox, "run", quickstart, "--set", change, "--trace", "trace.json"], folder)
        events = json.loads((folder / "trace.json").read_text())["traceEvents"]
        begin = min(e["ts"] for e in events if e["ph"] == "X")
        end = max(e["ts"] + e.get("dur", 0) for e in events)
        left = [(e["ts"], e["args"]["s"]) for e in events if e["ph"] == "C"]
        # Below 5 s nothing is shown.
        shown = [(s * 1e6) / (end - ts) for ts, s in left if ts > begin + 0.1 * (end - begin) and end - ts > 5e6]
        if shown:
            held = sum(abs(ratio - 1.0) <= 0.3 for ratio in shown)
            print(f"time left, {change}, {(end - begin) / 1e6:.0f} s: estimate / truth {min(shown):.2f} to {max(shown):.2f}, "
                  f"{held} of {len(shown)} within 30 %", flush=True)


def two(rootvox, folder, _data):
    twice = 0
    for turn in range(10):
        here = folder / str(turn)
        here.mkdir()
        for name, values in [("one", [0.8, 0.9, 1.0, 1.2]), ("two", [1.0, 1.2, 1.5, 2.0])]:
            text = (SIMULATED % 6).replace('"bench"', f'"{name}"')
            (here / f"{name}.toml").write_text(text + f"[sweep]\nextract.high = {values}\n")
        both = [subprocess.Popen([rootvox, "run", f"{name}.toml"], cwd=here, stderr=subprocess.PIPE, text=True)
                for name in ("one", "two")]
        ran = sum(counts(process.communicate()[1])[2] for process in both)
        assert all(process.returncode == 0 for process in both)
        locks = [json.loads((here / f"results/{name}/study.lock").read_text())["nodes"] for name in ("one", "two")]
        digests = {}
        for node in locks[0] + locks[1]:
            if "key" in node:
                assert digests.setdefault(node["key"], node["digest"]) == node["digest"], node
        twice += ran - len(digests)
        run([rootvox, "cache", "verify"], here)
    print(f"two processes with overlapping sweeps, 10 times: {len(digests)} distinct nodes, {twice} computed twice")


def main():
    parts = {f.__name__: f for f in (warm, sweeps, big, reruns, remaining, two)}
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("rootvox", type=Path)
    parser.add_argument("--data", type=Path)
    parser.add_argument("--only", nargs="+", choices=parts, default=list(parts))
    arguments = parser.parse_args()
    os.environ.pop("ROOTVOX_CACHE", None)
    data = arguments.data and (arguments.data / "licorice-sim").resolve()
    for name in arguments.only:
        with tempfile.TemporaryDirectory() as folder:
            parts[name](arguments.rootvox.resolve(), Path(folder), data)


if __name__ == "__main__":
    main()
