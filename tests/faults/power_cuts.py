#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the evermap authors
# SPDX-License-Identifier: BSD-3-Clause
"""power_cuts.py PROGRAM SHIM [--cuts N]: runs verbs on an ext4 file system in an image, and at random moments takes a copy of
what the device holds: what a power cut leaves, for all that is only in the system's memory is not in it. Each copy is mounted
and must hold the old map or the new one, every scan that was acknowledged, and all versions. Needs root and loop devices."""
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from campaign import Campaign, parser_of, scans_told

IMAGE_SIZE = 48 << 20  # bytes


class Mounted:
    def __init__(self, image, at):
        self.image, self.at = image, at

    def __enter__(self):
        self.at.mkdir(exist_ok=True)
        subprocess.run(["mount", "-o", "loop", self.image, self.at], check=True)
        return self.at

    def __exit__(self, *_):
        for _ in range(100):
            if subprocess.run(["umount", self.at], capture_output=True).returncode == 0:
                return
            time.sleep(0.02)
        raise RuntimeError(f"{self.at} cannot be unmounted")


def copy_of_device(image, copy):
    """Waits for two copies in a row that are the same, so that none is of two moments."""
    before = None
    while True:
        now = image.read_bytes()
        if now == before:
            copy.write_bytes(now)
            return
        before = now


def duration(campaign, verb, template):
    """[s] that the verb takes on such a device."""
    image = campaign.folder / "device.img"
    shutil.copy(template, image)
    with Mounted(image, campaign.folder / "device") as at:
        begin = time.monotonic()
        campaign.run(*campaign.verbs()[verb], at=at)
        return time.monotonic() - begin


def cut(campaign, verb, right, template, seconds):
    folder = campaign.folder
    image, copy = folder / "device.img", folder / "cut.img"
    shutil.copy(template, image)
    with Mounted(image, folder / "device") as at, open(folder / "stderr", "wb") as errors:
        process = subprocess.Popen([campaign.program, *campaign.verbs()[verb]], cwd=at, stdout=subprocess.DEVNULL,
                                   stderr=errors, env=campaign.environment(None, at))
        time.sleep(seconds)
        process.send_signal(signal.SIGSTOP)
        told = scans_told((folder / "stderr").read_text())
        ended = process.poll() == 0
        copy_of_device(image, copy)
        process.kill()
        process.wait()
    with Mounted(copy, folder / "cut") as at:
        return campaign.judge_recovered(verb, right, told, ended, at)


def main():
    parser = parser_of(__doc__)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--cuts", type=int, default=300)
    options = parser.parse_args()
    random.seed(options.seed)
    if os.geteuid() != 0:
        sys.exit("power_cuts.py mounts file systems: root alone can")
    wrong = 0
    with tempfile.TemporaryDirectory(prefix="evermap-power-") as folder:
        campaign = Campaign(options.program.resolve(), options.shim.resolve(), folder)
        template = Path(folder) / "template.img"
        with open(template, "wb") as file:
            file.truncate(IMAGE_SIZE)
        subprocess.run(["mkfs.ext4", "-q", template], check=True)
        with Mounted(template, Path(folder) / "template") as at:
            for file in campaign.start.iterdir():
                if file.is_file():
                    shutil.copy(file, at)
            (at / "yard").symlink_to(campaign.start / "yard")
        verbs = ["update", "localize", "undo", "prune", "import"]
        for verb in verbs:
            _, right = campaign.reference(verb)
            length = 1.2 * duration(campaign, verb, template)  # the end is cut, too
            answers = [cut(campaign, verb, right, template, random.uniform(0, length))
                       for _ in range(options.cuts // len(verbs))]
            bad = [answer for answer in answers if answer]
            wrong += len(bad)
            print(f"{verb:9} {len(answers)} power cuts: {len(bad)} wrong", flush=True)
            for answer in bad[:5]:
                print(f"   {answer}", flush=True)
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
