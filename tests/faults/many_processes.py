#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the evermap authors
# SPDX-License-Identifier: BSD-3-Clause
"""many_processes.py PROGRAM SHIM [--minutes M] [--writers N] [--readers N]: processes that change one map, and others that read
it, all at once. Every change that was reported as done must be a version, and no reader may see damage."""
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor

from campaign import Campaign, parser_of


def main():
    parser = parser_of(__doc__)
    parser.add_argument("--minutes", type=float, default=10)
    parser.add_argument("--writers", type=int, default=4)
    parser.add_argument("--readers", type=int, default=4)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="evermap-many-") as folder:
        campaign = Campaign(options.program.resolve(), options.shim.resolve(), folder)
        at = campaign.copy("map")
        end = time.monotonic() + 60 * options.minutes

        def repeat(*arguments):
            done, wrong = 0, []
            while time.monotonic() < end:
                result = subprocess.run([campaign.program, *arguments], cwd=at, capture_output=True)
                if result.returncode == 0:
                    done += 1
                else:
                    wrong.append(result.stderr.decode())
            return done, wrong

        one_scan = ["update", "map.evm", "yard/scans", "--poses", "yard/poses.txt", "-o", "map.evm", "--duration", "0.05",
                    "--wait", "60"]
        reading = [["info", "map.evm"], ["verify", "map.evm"], ["log", "map.evm"],
                   ["checkout", "map.evm@2", "-o", "reader.evm"]]
        with ThreadPoolExecutor(options.writers + options.readers) as pool:
            writers = [pool.submit(repeat, *one_scan) for _ in range(options.writers)]
            readers = [pool.submit(repeat, *reading[i % len(reading)]) for i in range(options.readers)]
            written = [writer.result() for writer in writers]
            read = [reader.result() for reader in readers]
        changes = sum(done for done, _ in written)
        wrong = [words for _, failures in [*written, *read] for words in failures]
        versions = len(campaign.run("log", "map.evm", at=at).stdout.decode().splitlines())
        campaign.run("verify", "map.evm", at=at)
        print(f"{changes} changes by {options.writers} processes, {versions - 2} versions of them; "
              f"{sum(done for done, _ in read)} readings by {options.readers}; {len(wrong)} wrong")
        for words in wrong[:5]:
            print(f"   {words}")
        sys.exit(0 if versions - 2 == changes and not wrong else 1)


if __name__ == "__main__":
    main()
