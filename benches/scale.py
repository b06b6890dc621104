#!/usr/bin/env python3
"""How a batch of plants scales over workers: a simulation of the scheduler with measured node times.

    python3 benches/scale.py --rootvox target/release/rootvox --study STUDY --work FOLDER [--plants 10000]

Runs the study of one plant with one core (times and sizes of its nodes), counts under strace (where it is there) the
requests that a worker makes of the file system per node, and lays the nodes of many such plants out on 1 to 1,000
workers as the engine does: the longest path first, inputs before consumers. Prints tables (Markdown) for docs/scale.md. What is measured once
stays in FOLDER, which has to be empty at first.

The model: a worker spends the node's measured seconds (scaled to the processor time of the run), and --latency for each request that it makes of the file server,
for the node itself and for each node that another worker was faster at. The server answers --server requests a second
and moves --bandwidth MB a second; a batch cannot end before it has. Plants are independent, so that nodes of all plants
compete for workers; batches of --batch plants share one study file, which bounds what each worker looks through.
"""

import argparse
import heapq
import json
import pathlib
import resource
import subprocess
import sys

CALLS = "open,openat,creat,mkdir,mkdirat,rename,renameat,renameat2,link,linkat,unlink,unlinkat,rmdir,fsync,fdatasync,utimensat"


def run(rootvox, study, cache, results, *more):
    command = [rootvox, "run", str(study), "--threads", "1", "--cache", str(cache), "--results", str(results), *more]
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(command, check=True, stderr=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def plant(cache, lock):
    """The nodes of a study: seconds, bytes, and places of their inputs, inputs before consumers."""
    nodes, place = [], {}
    for locked in json.loads(lock.read_text())["nodes"]:
        if "key" not in locked:
            continue
        found = list(cache.glob(f"v1/nodes/*/{locked['key']}/manifest.json"))
        manifest = json.loads(found[0].read_text())
        inputs = [i["digest"] for port in manifest["inputs"].values() for i in port]
        nodes.append(dict(seconds=manifest["seconds"], bytes=sum(m["bytes"] for m in manifest["members"]), stage=manifest["stage"],
                          inputs=sorted({place[d] for d in inputs if d in place})))
        place.setdefault(manifest["digest"], len(nodes) - 1)
    return nodes


def requests_per_node(args, nodes):
    """Requests of one worker per node that it computes, and per node that it finds done."""
    kept = args.work / "requests.json"
    if kept.exists():
        return json.loads(kept.read_text())
    folder = args.work / "traced"
    counts = []
    for turn in ("computed", "found"):
        log = args.work / f"strace-{turn}"
        command = ["strace", "-f", "-qq", "-e", f"trace={CALLS}", "-o", str(log), args.rootvox, "work", str(args.study), "--cores", "1", "--cache", str(folder)]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        lines = [line for line in log.read_text(errors="replace").splitlines() if str(folder) in line]
        counts.append(len(lines) / len(nodes))
        if turn == "computed":
            claim = sum("/locks/" in line for line in lines) / len(nodes)
    # What another worker was faster at is claimed, found in the store, and given back.
    counts[1] += claim
    kept.write_text(json.dumps(counts))
    return counts


def lay_out(nodes, plants, workers, overhead_s):
    """When the last node of so many plants ends on so many workers, the longest path first."""
    count = len(nodes)
    cost = [n["seconds"] + overhead_s for n in nodes]
    path, consumers = [0.0] * count, [[] for _ in nodes]
    for n in reversed(range(count)):
        path[n] += cost[n]
        for i in nodes[n]["inputs"]:
            path[i] = max(path[i], path[n])
            consumers[i].append(n)
    waits = [len(n["inputs"]) for n in nodes]
    left = [list(waits) for _ in range(plants)]
    ready = [(-path[n], p, n) for p in range(plants) for n in range(count) if waits[n] == 0]
    heapq.heapify(ready)
    ends, now = [], 0.0
    while ready or ends:
        while ready and len(ends) < workers:
            _, p, n = heapq.heappop(ready)
            heapq.heappush(ends, (now + cost[n], p, n))
        now, p, n = heapq.heappop(ends)
        for c in consumers[n]:
            left[p][c] -= 1
            if left[p][c] == 0:
                heapq.heappush(ready, (-path[c], p, c))
    return now


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rootvox", required=True)
    parser.add_argument("--study", required=True, type=pathlib.Path)
    parser.add_argument("--work", required=True, type=pathlib.Path)
    parser.add_argument("--plants", type=int, default=10_000)
    parser.add_argument("--batch", type=int, default=100, help="plants in one study file")
    parser.add_argument("--latency", type=float, default=0.5, help="of a request to the file server, ms")
    parser.add_argument("--server", type=float, default=5_000, help="requests that the file server answers a second")
    parser.add_argument("--bandwidth", type=float, default=1_000, help="of the file server, MB/s")
    args = parser.parse_args()
    args.work.mkdir(parents=True, exist_ok=True)
    cache, results = args.work / "cache", args.work / "results"
    processor = args.work / "processor.json"
    if not processor.exists():
        processor.write_text(json.dumps(run(args.rootvox, args.study, cache, results)))
    locks = sorted(results.glob("*/study.lock"))
    if not locks:
        sys.exit(f"no results in {results}")
    nodes = plant(cache, locks[0])
    # One core computes one node at a time: what its processor time lacks, others on the machine had.
    share = min(1.0, json.loads(processor.read_text()) / sum(n["seconds"] for n in nodes))
    for node in nodes:
        node["seconds"] *= share
    seconds, size = sum(n["seconds"] for n in nodes), sum(n["bytes"] for n in nodes)
    computed, found = requests_per_node(args, nodes)
    per_plant = dict(nodes=len(nodes), seconds=seconds, bytes=size, critical=lay_out(nodes, 1, 10**6, 0.0))
    print(f"One plant: {len(nodes)} nodes, {seconds:.1f} s of one core, longest path {per_plant['critical']:.1f} s, {size / 1e6:.1f} MB; "
          f"{computed:.1f} requests of the file system per node computed, {found:.1f} per node found done.\n")
    plants = args.plants
    print(f"| {plants} plants | |\n|---|---|")
    print(f"| nodes | {plants * len(nodes):,} |\n| core hours | {plants * seconds / 3600:,.0f} |\n| bytes | {plants * size / 1e12:.2f} TB |")
    print(f"| requests of the file system, computing | {plants * len(nodes) * computed / 1e6:,.1f} million |")
    # Prices of S3 standard, us-east-1.
    gets, puts = plants * len(nodes), plants * len(nodes)
    print(f"| S3: PUT and HEAD of a push | {2 * puts / 1e6:.1f} million, {puts / 1000 * 0.005 + puts / 1000 * 0.0004:,.0f} $ |")
    print(f"| S3: GET of a pull | {gets / 1e6:.1f} million, {gets / 1000 * 0.0004:,.1f} $ |")
    print(f"| S3: a month of keeping it | {plants * size / 1e9 * 0.023:,.0f} $ |\n")
    saturated = args.server * (seconds / len(nodes) + computed * args.latency / 1000) / computed
    print(f"A file server is busy with {args.server:,.0f} requests a second at {saturated:,.0f} workers.\n")
    print("| workers | hours | speed-up | efficiency | requests/s | bound by |\n|---|---|---|---|---|---|")
    one = None
    for workers in (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000):
        # Workers are spread over the batches; of a batch each looks at every node once.
        batches = max(1, plants // args.batch)
        sharing = max(1, workers / batches)
        looks = (sharing - 1) * found / max(sharing, 1)
        overhead = (computed + looks * 1.0) * args.latency / 1000
        part = min(plants, 1000)  # The rest is more of the same.
        laid = lay_out(nodes, part, workers, overhead)
        tail = lay_out(nodes, min(part, max(1, part // 2)), workers, overhead)
        rate = (laid - tail) / (part - part // 2)
        laid += rate * (plants - part)
        total = plants * len(nodes) * (computed + (sharing - 1) * found)
        served, moved = total / args.server, plants * size * 2 / (args.bandwidth * 1e6)
        ends = max(laid, served, moved)
        by = ["workers", "requests", "bandwidth"][[laid, served, moved].index(ends)]
        one = one or ends
        print(f"| {workers} | {ends / 3600:,.2f} | {one / ends:,.1f} | {100 * one / ends / workers:.0f} % | {total / ends:,.0f} | {by} |")


if __name__ == "__main__":
    main()
