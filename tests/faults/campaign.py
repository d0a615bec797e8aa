#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the evermap authors
# SPDX-License-Identifier: BSD-3-Clause
"""campaign.py PROGRAM SHIM [--every N] [--verb VERB] [--faults kill,ENOSPC,...]: lets every N-th call for files of every
verb that writes go wrong, by killing the process before it or by an error, and checks after each that the map is one that it
was to be, that versions from before come back bit for bit, that success is not claimed for what failed, that the verb works
when it is run again, and that nothing is left behind. Prints what it tried; exits 1 when anything was lost, torn or lied about."""
import argparse
import hashlib
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

SCANS = 4  # a start of two or three, a journal that grows, and a map that is saved; every call of theirs is tried
ERRORS = ["ENOSPC", "EIO", "EDQUOT", "EINTR", "EMFILE", "short", "ENOSPC+", "EIO+"]
HARMLESS = {"EINTR", "short"}  # what a correct program goes on from


def hash_of(path):
    return hashlib.sha256(path.read_bytes()).hexdigest() if path.exists() else None


def output_of(right):
    return next((name for name in right if name.startswith("new")), "map.evm")


def scans_told(words):
    """Of how many scans the program said that they are done; the last of these may not be acknowledged yet."""
    return sum(1 for line in words.splitlines() if re.search(r"debug: (scan \d+:|yard)", line))


def parser_of(description):
    """What all of these programs are told."""
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=Path)
    parser.add_argument("shim", type=Path)
    return parser


class Campaign:
    def __init__(self, program, shim, folder):
        self.program, self.shim, self.folder = str(program), str(shim), Path(folder)
        self.start = self.folder / "start"
        self.start.mkdir()
        self.run("simulate", "yard", "--scans", str(SCANS), "-o", "yard", at=self.start)
        self.run("import", "yard/survey.ply", "-r", "0.8", "-o", "map.evm", at=self.start)
        half = ["update", "map.evm", "yard/scans", "--poses", "yard/poses.txt", "-o", "map.evm", "--duration", "0.15"]
        self.run(*half, at=self.start)
        self.run("tag", "map.evm", "half", at=self.start)
        first = (self.start / "yard/poses.txt").read_text().splitlines()[0].split()
        self.initial_pose = " ".join(first[1:8])
        self.versions = {n: self.version(self.start, n) for n in (1, 2)}

    def environment(self, fault, root):
        env = dict(os.environ, LC_ALL="C", TMPDIR=str(self.folder))
        if fault:
            env.update(LD_PRELOAD=self.shim, EVERMAP_FAULT=fault, EVERMAP_FAULT_ROOT=str(root))
        return env

    def run(self, *arguments, at, fault=None, check=None):
        """Raises when it fails, unless `check` says otherwise, as it does where a fault is played."""
        result = subprocess.run([self.program, *arguments], cwd=at, env=self.environment(fault, at), capture_output=True,
                                timeout=120)
        if (fault is None if check is None else check) and result.returncode != 0:
            raise RuntimeError(f"{arguments}: {result.stderr.decode()}")
        return result

    def version(self, at, number):
        out = at / f"version_{number}.evm"
        self.run("checkout", f"map.evm@{number}", "-o", out.name, at=at)
        digest = hash_of(out)
        out.unlink()
        return digest

    def verbs(self):
        scans = ["yard/scans", "--poses", "yard/poses.txt"]
        return {
            "update": ["-v", "update", "map.evm", *scans, "-o", "map.evm", "--sync", "1"],
            "localize": ["-v", "localize", "map.evm", "yard/scans", "--maintain", "--initial-pose", self.initial_pose, "-o",
                         "poses.txt", "--map-out", "map.evm", "--sync", "1"],
            "undo": ["undo", "map.evm"],
            "tag": ["tag", "map.evm", "name", "1"],
            "prune": ["prune", "map.evm", "--keep", "0d"],
            "import": ["import", "yard/survey.ply", "-r", "0.8", "-o", "new.evm"],
            "build": ["build", *scans, "-r", "0.8", "-o", "new.evm"],
            "checkout": ["checkout", "map.evm@1", "-o", "new.evm"],
            "export": ["export", "map.evm", "new.pcd"],
        }

    def copy(self, name):
        at = self.folder / name
        shutil.copytree(self.start, at, ignore=lambda folder, names: ["yard"] if folder == str(self.start) else [])
        (at / "yard").symlink_to(self.start / "yard")
        return at

    def reference(self, verb):
        """What the verb does when nothing goes wrong: the number of its calls, and the files that it leaves."""
        at = self.copy(f"{verb}_right")
        count = self.folder / f"{verb}.count"
        self.run(*self.verbs()[verb], at=at, fault=f"count:{count}", check=True)
        files = {p.name: hash_of(p) for p in at.iterdir() if p.is_file()}
        shutil.rmtree(at)
        # What a run is to leave that ended after 0, 1, ... scans.
        self.after_scans = [hash_of(self.start / "map.evm")]
        for scans in range(1, SCANS + 1 if verb in ("update", "localize") else 1):
            at = self.copy(f"{verb}_{scans}")
            self.run(*self.verbs()[verb], "--duration", str(0.1 * scans - 0.05), at=at, check=False)
            self.after_scans.append(hash_of(at / "map.evm"))
            shutil.rmtree(at)
        return int(count.read_text()), files

    def attempt(self, verb, right, fault, number):
        """Returns what is wrong, or None."""
        at = self.copy(f"{verb}_{fault}_{number}")
        try:
            return self.judge(verb, right, fault, number, at)
        finally:
            shutil.rmtree(at)

    def judge(self, verb, right, fault, number, at):
        ending = "+" if fault.endswith("+") else ""
        result = self.run(*self.verbs()[verb], at=at, fault=f"{fault.rstrip('+')}:{number}{ending}")
        code, words = result.returncode, result.stderr.decode(errors="replace")
        killed = fault == "kill"
        if killed and code not in (0, -signal.SIGKILL):
            return f"exit {code} instead of being killed: {words}"
        if not killed and code not in (0, 1):
            return f"exit {code}: {words}"
        if fault in HARMLESS and code != 0:
            return f"does not go on: {words}"
        if code == 1 and not any(line.startswith("evermap: ") for line in words.splitlines()):
            return f"fails without a word: {words!r}"
        output = output_of(right)
        before = hash_of(self.start / output)
        now = hash_of(at / output)
        if now not in (before, right[output]):
            return f"{output} is neither the old nor the new one"
        if code == 0 and now != right[output]:
            return f"exit 0, but {output} is not the new one"
        return self.judge_recovered(verb, right, scans_told(words) if code == -signal.SIGKILL else 0, code == 0, at)

    def judge_recovered(self, verb, right, told, ended, at):
        """What is wrong with what the next process makes of what this verb left, which had done `told` scans."""
        output = output_of(right)
        self.run("log", "map.evm", at=at)
        self.run("info", "map.evm", at=at)  # brings to its end what this one left
        states = self.after_scans[max(told - 1, 0):] if verb in ("update", "localize") else [hash_of(self.start / output)]
        if hash_of(at / output) not in ([right[output]] if ended else [*states, right[output]]):
            return f"{told} scans were done; {self.run('log', 'map.evm', at=at).stdout.decode()}"
        verdict = self.run("verify", "map.evm", at=at, check=False)
        if verdict.returncode != 0:
            return f"verify: {verdict.stdout.decode()}{verdict.stderr.decode()}"
        for version, digest in self.versions.items():
            if not (verb == "prune" and version == 1) and self.version(at, version) != digest:
                return f"version {version} is another"
        again = self.run(*self.verbs()[verb], at=at, check=False)
        if again.returncode != 0 and not (verb == "undo" and b"no version before" in again.stderr):
            return f"does not work afterwards: {again.stderr.decode()}"
        left = {p.name for p in at.iterdir()} - set(right) - {"yard", "map.evm.history", "poses.txt", "lost+found"}
        if left:
            return f"leaves behind {sorted(left)}"
        return None


def main():
    parser = parser_of(__doc__)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--every", type=int, default=1)
    parser.add_argument("--verb")
    parser.add_argument("--faults", default=",".join(["kill", *ERRORS]))
    options = parser.parse_args()
    random.seed(options.seed)
    wrong = 0
    with tempfile.TemporaryDirectory(prefix="evermap-faults-") as folder:
        campaign = Campaign(options.program.resolve(), options.shim.resolve(), folder)
        for verb in [options.verb] if options.verb else campaign.verbs():
            calls, right = campaign.reference(verb)
            for fault in options.faults.split(","):
                numbers = range(1 + random.randrange(options.every), calls + 1, options.every)
                with ThreadPoolExecutor(os.cpu_count()) as pool:
                    answers = list(pool.map(lambda n: campaign.attempt(verb, right, fault, n), numbers))
                bad = [(n, answer) for n, answer in zip(numbers, answers) if answer]
                wrong += len(bad)
                print(f"{verb:9} {fault:8} at {len(answers):5} of {calls} calls: {len(bad)} wrong", flush=True)
                for number, answer in bad[:5]:
                    print(f"   call {number}: {answer}", flush=True)
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
