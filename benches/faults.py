#!/usr/bin/env python3
"""Does harm to runs and to the store, and looks whether results stay right. docs/faults.md says what is promised.

    python3 benches/faults.py --seed 1 --kills 300 --calls 300 --rot 300 --races 50 --clock 100 --cleaning 50
    python3 benches/faults.py --seed 1 --only calls:17 --keep     # one trial again; its folder stays

After every fault the same command runs again, without one. A trial is sound where both runs give the results of an
undisturbed one, or the first ends with a clear error and the second gives them. Where the error names a remedy (`rootvox cache
verify --repair`), that comes between. Everything else is a bug: other results, a panic, a run over LIMIT seconds, a
node that `cache verify` calls bad, a file left over. The exit code is 1 if there is one.

Python's standard library, `cc` (for failing calls and clocks), and the program: target/release/rootvox, or --program.
"""

import argparse, collections, concurrent.futures, errno, hashlib, os, pathlib, random, re, shutil, signal, subprocess, sys
import tempfile, time

HERE = pathlib.Path(__file__).resolve().parent
LIMIT = 60  # seconds; an undisturbed run takes about one
CHANGED = ["--set", "extract.high=1.5"]
STUDY = """[study]
name = "tiny"
[photos]
images = "images/*.jpg"
[cameras]
path = "cameras.json"
[tank]
file = "tank.json"
[truth]
roots = "roots.json"
[grid]
spacing = 1.5
depth = 60.0
"""
# Times and measured memory of the run; all else in the results is the same from run to run.
VARYING = re.compile(rb'"(datePublished|endTime|value)": "[^"]*"')


class Bug(Exception):
    pass


class Scene:
    """A folder with a study, its photographs, a store and results."""

    def __init__(self, program, folder):
        self.program, self.folder, self.log = program, folder, []

    def start(self, *words, **environment):
        """Begins the program there; what it says goes into a file, so that nothing waits for a reader."""
        says = tempfile.TemporaryFile()
        free = {k: v for k, v in os.environ.items() if not k.startswith(("ROOTVOX", "FAULT"))}
        process = subprocess.Popen(
            [self.program, *words], cwd=self.folder, stdin=subprocess.DEVNULL, stdout=says, stderr=says,
            env={**free, "RUST_BACKTRACE": "0", **environment}, start_new_session=True)
        process.says, process.words = says, words
        return process

    def end(self, process, limit=LIMIT):
        """Waits; its exit code and text."""
        try:
            code = process.wait(limit)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
            code = None
        process.says.seek(0)
        text = process.says.read().decode(errors="replace")
        process.says.close()
        self.log.append(f"$ rootvox {' '.join(process.words)}\n{text}exit code {code}\n")
        if code is None:
            raise Bug(f"hangs: rootvox {' '.join(process.words)}")
        if "panicked" in text or code == 101:
            raise Bug("panics: " + next((line for line in text.splitlines() if "panicked" in line), text[-200:]))
        if code not in (0, -signal.SIGKILL) and not (code in (1, 2) and "error: " in text):
            raise Bug(f"ends with {code} and no clear error")
        return code, text

    def call(self, *words, **environment):
        return self.end(self.start(*words, **environment))

    def results(self, name="results"):
        """Digest of every file of the results; empty where there are none."""
        top = self.folder / name / "tiny"
        files = sorted(path for path in top.rglob("*") if path.is_file())
        read = lambda path: VARYING.sub(b"", path.read_bytes()) if path.suffix == ".json" else path.read_bytes()
        return {str(path.relative_to(top)): hashlib.sha256(read(path)).hexdigest() for path in files}

    def leftovers(self):
        """Files that no finished run leaves."""
        store, found = self.folder / "cache/v1", []
        for name in ("tmp", "locks", "failures"):
            found += [p for p in (store / name).glob("*")]
        known = {"nodes", "history", "failures", "files.json", "pins", "in-use.lock", "locks", "tmp"}
        found += [p for p in store.glob("*") if p.name not in known]
        found += [p for p in (store / "nodes").glob("*/*") if not re.fullmatch("[0-9a-f]{64}", p.name)]
        found += [p for p in self.folder.glob("*results*/*") if p.name != "tiny"]
        known = {"study.toml", "images", "cameras.json", "tank.json", "roots.json", "cache", "results", "other-results"}
        found += [p for p in self.folder.glob("*") if p.name not in known]
        return [str(p.relative_to(self.folder)) for p in found]


class Campaign:
    def __init__(self, options, work):
        self.options, self.work = options, work
        self.program = str(pathlib.Path(options.program).resolve())
        self.shim = work / "fail.so"
        compiler = shutil.which("cc")
        if compiler is None:
            sys.exit("error: `cc` is missing; failing calls and clocks are made with it. Install a C compiler.")
        subprocess.run([compiler, "-shared", "-fPIC", "-O1", "-w", "-o", self.shim, HERE / "faults/fail.c", "-ldl"], check=True)
        self.prepare()

    def prepare(self):
        """The capture, a store that holds it, and what undisturbed runs give and take."""
        capture = self.work / "capture"
        study, few = HERE.parent / "tests/data/tiny.toml", "simulate.capture.views=4"
        words = [self.program, "simulate", study, "--set", few, "--out", capture, "--cache", self.work / "simulated"]
        subprocess.run(words, check=True, stderr=subprocess.DEVNULL)
        self.bare, self.warm = self.work / "bare", self.work / "warm"
        self.bare.mkdir()
        for name in ("images", "cameras.json", "tank.json", "roots.json"):
            move = shutil.copytree if (capture / name).is_dir() else shutil.copy
            move(capture / name, self.bare / name)
        (self.bare / "study.toml").write_text(STUDY)
        past = time.time() - 3600  # as photographs are: their digests are remembered
        for path in self.bare.rglob("*"):
            os.utime(path, (past, past))
        self.right, self.seconds, self.calls = {}, {}, {}
        shutil.copytree(self.bare, self.warm)
        changed = self.work / "changed"
        for name, words, folder, after in (("plain", [], self.warm, None), ("changed", CHANGED, changed, self.warm)):
            if after:
                shutil.copytree(after, folder)
            scene, begun = Scene(self.program, folder), time.time()
            code, text = scene.call("run", "study.toml", *words)
            if code:
                sys.exit(f"an undisturbed run fails:\n{text}")
            self.seconds[name], self.right[name] = time.time() - begun, scene.results()
            if scene.leftovers():
                raise SystemExit(f"an undisturbed run leaves {scene.leftovers()}")
        assert self.right["plain"] != self.right["changed"]

    def environment(self, scene, **fault):
        return {"LD_PRELOAD": str(self.shim), "FAULT_UNDER": str(scene.folder),
                **{f"FAULT_{name.upper()}": str(value) for name, value in fault.items()}}

    def situation(self, rng, scene):
        """Brings the scene into a state; the command to disturb, and whose results it must give."""
        kind = rng.choice(["cold", "cold", "warm", "results"])
        shutil.copytree(self.bare if kind == "cold" else self.warm, scene.folder)
        if kind == "results":
            shutil.rmtree(scene.folder / "results")
        name = "changed" if kind == "warm" else "plain"
        words = ["run", "study.toml", *(CHANGED if kind == "warm" else [])]
        seconds = {"cold": self.seconds["plain"], "warm": self.seconds["changed"], "results": 0.15}[kind]
        return kind, words, name, seconds

    def same(self, scene, name, where="results"):
        """Fails unless the results are those of an undisturbed run."""
        found, right = scene.results(where), dict(self.right[name])
        if where != "results":  # the page names the command, and that names the folder
            found.pop("report.html", None), right.pop("report.html")
        if found != right:
            files = sorted(f for f in {*found, *right} if found.get(f) != right.get(f))
            raise Bug(f"other results: {', '.join(files[:4])}{' and more' if len(files) > 4 else ''}")

    def unmixed(self, scene):
        """Fails where the results folder, if there, is of no undisturbed run: half written, or mixed."""
        found = scene.results()
        if found and found not in self.right.values():
            raise Bug(f"results are neither old nor new: {len(found)} files")

    def again(self, scene, words, name):
        """The same command without a fault, with the remedy that an error names; how it came right."""
        how = "the next run"
        code, text = scene.call(*words)
        if code and "cache verify" in text:
            how = "repair and the next run"
            scene.call("cache", "verify", "--repair")
            code, text = scene.call(*words)
        if code:
            raise Bug(f"fails without a fault: {text.strip().splitlines()[-1] if text.strip() else code}")
        self.same(scene, name)
        code, text = scene.call("cache", "verify")
        if code:
            raise Bug(f"the store is damaged after the next run: {text.splitlines()[0]}")
        left = scene.leftovers()
        if left:
            raise Bug(f"left over: {', '.join(left[:3])}")
        return how

    def kills(self, rng, scene):
        kind = rng.choice(["run", "run", "run", "gc", "repair"])
        if kind == "run":
            kind, words, name, seconds = self.situation(rng, scene)
            disturbed = words
        else:
            shutil.copytree(self.warm, scene.folder)
            words, name, seconds = ["run", "study.toml"], "plain", 0.06
            if kind == "gc":
                disturbed = ["cache", "gc", "--keep", rng.choice(["0", "1MB", "3MB"])]
            else:
                for _ in range(5):
                    self.damage(rng, scene, "cut")
                disturbed = ["cache", "verify", "--repair"]
            shutil.rmtree(scene.folder / "results")
        what, kills = kind, rng.choice([1, 1, 3])
        for _ in range(kills):
            process = scene.start(*disturbed)
            time.sleep(rng.uniform(0, seconds))
            process.kill()
            scene.end(process)
            self.unmixed(scene)
        if what == "repair":
            scene.call(*disturbed)
        return what, "killed", self.again(scene, words, name)

    def calls_that_fail(self, rng, scene):
        kind, words, name, _ = self.situation(rng, scene)
        call = rng.choice(["write", "write", "fsync", "rename", "mkdir", "open", "open", "read", "unlink"])
        error = rng.choice(["EIO", "EACCES"] if call in ("read", "unlink") else ["ENOSPC", "EIO", "EDQUOT", "EACCES"])
        if (kind, call) not in self.calls:  # how many there are to choose from
            count, trial = self.work / f"{scene.folder.name}-count", Scene(self.program, self.work / f"{scene.folder.name}-whole")
            shutil.copytree(scene.folder, trial.folder)
            trial.call(*words, **self.environment(trial, call=call, count=count))
            shutil.rmtree(trial.folder)
            self.calls[kind, call] = int(count.read_text().split()[0])
        always, most = rng.randrange(2), max(1, self.calls[kind, call])
        at = rng.randint(1, most)
        code, _ = scene.call(*words, **self.environment(
            scene, call=call, errno=getattr(errno, error), at=at, always=always))
        what = f"{call} {error} {'from then on' if always else 'once'}"
        scene.log.insert(0, f"{kind}: {what} at {at} of about {most}\n")
        if code == 0:
            self.same(scene, name)
        else:
            self.unmixed(scene)
        return f"{call}", "no harm" if code == 0 else "clear error", self.again(scene, words, name)

    def damage(self, rng, scene, how):
        """Spoils a file of the store; what was done."""
        store = scene.folder / "cache/v1"
        files = sorted(p for p in store.rglob("*") if p.is_file() and p.stat().st_size > 0)
        groups = {"manifest": lambda p: p.name == "manifest.json", "JSON": lambda p: p.suffix == ".json" and p.name not in ("manifest.json", "zarr.json"),
                  "array": lambda p: p.name == "zarr.json" or "c" in p.parts, "other": lambda p: True}
        group = rng.choice(sorted(groups))
        path = rng.choice([p for p in files if groups[group](p)])
        scene.log.append(f"{how}: {path.relative_to(scene.folder)}\n")
        data = path.read_bytes()
        if how == "flipped":
            at = rng.randrange(len(data))
            path.write_bytes(data[:at] + bytes([data[at] ^ (1 << rng.randrange(8))]) + data[at + 1:])
            scene.log.append(f"byte {at} of {len(data)}\n")
        elif how == "cut":
            path.write_bytes(data[:rng.randrange(len(data))])
        elif how == "emptied":
            path.write_bytes(b"")
        elif how == "removed":
            path.unlink()
        elif how == "swapped":
            others = [p for p in files if p != path and p.name == path.name] or [p for p in files if p != path]
            other = rng.choice(others)
            scene.log.append(f"with {other.relative_to(scene.folder)}\n")
            theirs = other.read_bytes()
            other.write_bytes(data)
            path.write_bytes(theirs)
        return group

    def rot(self, rng, scene):
        shutil.copytree(self.warm, scene.folder)
        how = rng.choice(["flipped", "flipped", "cut", "emptied", "swapped", "removed"])
        self.damage(rng, scene, how)
        words, name = rng.choice([(["run", "study.toml"], "plain"), (["run", "study.toml", *CHANGED], "changed")])
        shutil.rmtree(scene.folder / "results")
        code, _ = scene.call(*words)
        if code == 0:
            self.same(scene, name)
        elif scene.results():
            raise Bug("an error and results")
        # What no run of this study reads may stay damaged: repair looks at everything.
        if code == 0:
            scene.call("cache", "verify", "--repair")
        return how, "no harm" if code == 0 else "clear error", self.again(scene, words, name)

    def clock(self, rng, scene):
        kind, words, name, seconds = self.situation(rng, scene)
        shift = rng.choice([-1, 1]) * int(10 ** rng.uniform(0, 7.5))
        after = rng.choice([0, rng.randrange(2000)])
        if rng.random() < 0.3:
            for path in (scene.folder / "images").iterdir():
                os.utime(path, (time.time() + shift, time.time() + shift))
        fault = self.environment(scene, clock=shift, clock_after=after)
        kill = rng.random() < 0.3
        process = scene.start(*words, **fault)
        if kill:
            time.sleep(rng.uniform(0, seconds))
            process.kill()
        code, text = scene.end(process)
        scene.log.append(f"clock {shift:+} s after {after} questions\n")
        if code not in (0, -signal.SIGKILL):
            raise Bug(f"fails by the clock: {text[-200:]}")
        if code == 0:
            self.same(scene, name)
        return ("ahead" if shift > 0 else "back"), "killed" if kill else "no harm", self.again(scene, words, name)

    def races(self, rng, scene):
        kind, words, name, seconds = self.situation(rng, scene)
        second = rng.choice(["same", "other results", "worker"])
        others = {"same": words, "other results": [*words, "--results", "other-results"], "worker": ["work", "study.toml"]}[second]
        one = scene.start(*words)
        time.sleep(rng.choice([0, 0, rng.uniform(0, seconds)]))
        two = scene.start(*others)
        kill = rng.random() < 0.3
        if kill:
            time.sleep(rng.uniform(0, seconds))
            rng.choice([one, two]).kill()
        codes = [scene.end(process)[0] for process in (one, two)]
        if any(code not in (0, -signal.SIGKILL) for code in codes):
            raise Bug(f"two at once end with {codes}")
        if codes[0] == 0:
            self.same(scene, name)
        if second == "other results" and codes[1] == 0:
            self.same(scene, name, "other-results")
        return second, "one killed" if kill else "no harm", self.again(scene, words, name)

    def cleaning(self, rng, scene):
        kind, words, name, seconds = self.situation(rng, scene)
        reader = rng.choice([words, words, ["status", "study.toml"], ["cache", "du"], ["cache", "ls"], ["cache", "verify"]])
        cleaner = rng.choice([["cache", "gc", "--keep", "0"], ["cache", "gc", "--older-than", "0"], ["cache", "verify", "--repair"]])
        if not (scene.folder / "cache").exists():
            scene.call("run", "study.toml")
            shutil.rmtree(scene.folder / "results")
        reading, codes = scene.start(*reader), []
        while reading.poll() is None or not codes:
            codes.append(scene.call(*cleaner)[0])
        code, text = scene.end(reading)
        if code:
            raise Bug(f"a reader fails during cleaning: {text[-300:]}")
        if reader == words:
            self.same(scene, name)
        refused = "cleaning waits" if any(codes) else "no harm"
        return " ".join(reader[:2] if reader[0] == "cache" else reader[:1]), refused, self.again(scene, words, name)

    def trial(self, kind, n):
        rng = random.Random(f"{self.options.seed} {kind} {n}")
        scene = Scene(self.program, self.work / f"{kind}-{n}")
        act = {"kills": self.kills, "calls": self.calls_that_fail, "rot": self.rot, "clock": self.clock,
               "races": self.races, "cleaning": self.cleaning}[kind]
        try:
            verdict = act(rng, scene)
        except Bug as bug:
            print(f"BUG {kind}:{n}: {bug}", flush=True)
            if self.options.keep or self.options.verbose:
                print("    " + "".join(scene.log).replace("\n", "\n    "), flush=True)
            verdict = None
        if self.options.keep:
            (scene.folder / "log.txt").write_text("".join(scene.log))
            print(f"kept: {scene.folder}\n{''.join(scene.log)}")
        else:
            shutil.rmtree(scene.folder, ignore_errors=True)
        return verdict


KINDS = ("kills", "calls", "rot", "clock", "races", "cleaning")


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--seed", type=int, default=1)
    for kind in KINDS:
        options.add_argument(f"--{kind}", type=int, default=0, metavar="N")
    options.add_argument("--jobs", type=int, default=2, help="trials at once")
    options.add_argument("--only", metavar="KIND:N", help="one trial")
    options.add_argument("--keep", action="store_true", help="keep the folders and show what was said")
    options.add_argument("--verbose", action="store_true", help="show what was said where there is a bug")
    options.add_argument("--program", default=HERE.parent / "target/release/rootvox")
    options = options.parse_args()
    work = pathlib.Path(os.path.realpath(tempfile.mkdtemp(prefix="rootvox-faults-")))
    table, bugs, begun = collections.Counter(), collections.Counter(), time.time()
    try:
        campaign = Campaign(options, work)
        if options.only:
            kind, n = options.only.split(":")
            plan = [(kind, int(n))]
        else:
            # In turn, so that a campaign that is stopped has done some of each.
            share = lambda trial: (trial[1] + 0.5) / getattr(options, trial[0])
            plan = sorted(((kind, n) for kind in KINDS for n in range(getattr(options, kind))), key=share)
        done = 0
        with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
            trials = [pool.submit(campaign.trial, *trial) for trial in plan]
            for (kind, _), trial in zip(plan, trials):
                try:
                    verdict = trial.result()
                except KeyboardInterrupt:
                    pool.shutdown(cancel_futures=True)
                    raise
                if verdict is None:
                    bugs[kind] += 1
                else:
                    table[kind, *verdict] += 1
                done += 1
                if done % 50 == 0:
                    print(f"{done} of {len(plan)} trials, {sum(bugs.values())} bugs", flush=True)
    except KeyboardInterrupt:
        print("stopped; so far:")
    finally:
        if not options.keep:
            shutil.rmtree(work, ignore_errors=True)
    print(f"{'fault':9} {'of':15} {'the run itself':15} {'same results after':24} trials")
    for row, count in sorted(table.items(), key=lambda item: (KINDS.index(item[0][0]), item[0])):
        print(f"{row[0]:9} {row[1]:15} {row[2]:15} {row[3]:24} {count:6}")
    print(f"{sum(table.values()) + sum(bugs.values())} trials, {sum(bugs.values())} bugs, {time.time() - begun:.0f} s")
    sys.exit(1 if bugs else 0)


if __name__ == "__main__":
    main()
