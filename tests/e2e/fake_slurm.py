"""A sbatch that runs each job at once, for the end-to-end scripts that submit."""
import os
import shutil
import subprocess

# Numbers, dependencies and resources of each job, and the job itself, run at once. A dependency that is no
# job that ended well fails.
SBATCH = r"""#!/usr/bin/env python3
import os, re, subprocess, sys
record = os.environ["FAKE_SLURM"]
script, options = sys.stdin.read(), dict(a.lstrip("-").split("=", 1) if "=" in a else (a.lstrip("-"), "") for a in sys.argv[1:])
number = len(os.listdir(record)) + 1
name = options["job-name"]
for other in options.get("dependency", "afterok:").split(":")[1:]:
    if other and not os.path.exists(f"{record}/{other}"):
        sys.exit(f"{name}: no job {other}")
open(f"{record}/{number}", "w").write("running")
tasks = range(int(options["array"].split("-")[1]) + 1) if "array" in options else [None]
for task in reversed(tasks):
    env = {**os.environ, "SLURM_CPUS_PER_TASK": options["cpus-per-task"]}
    if task is not None:
        env["SLURM_ARRAY_TASK_ID"] = str(task)
    done = subprocess.run(["sh"], input=script, text=True, capture_output=True, env=env)
    if done.returncode:
        os.remove(f"{record}/{number}")
        sys.exit(f"{name} [{task}]: {done.stderr}")
with open(f"{record}/{number}", "w") as file:
    file.write(repr((name, options, script)))
print(f"{number};cluster")
"""

class FakeSlurm:
    def __init__(self, harness):
        self.harness = harness
        self.bin = harness.folder / "fake"
        self.bin.mkdir()
        (self.bin / "sbatch").write_text(SBATCH)
        (self.bin / "sbatch").chmod(0o755)

    def submit(self, script, *options):
        """Jobs by name: what they asked sbatch for, what they ran; and how the script ended."""
        record = self.harness.folder / "record"
        shutil.rmtree(record, ignore_errors=True)
        record.mkdir()
        done = subprocess.run(["sh", "-s", "--", *options], input=script, text=True, capture_output=True,
                              cwd=self.harness.folder, timeout=300,
                              env={**os.environ, "PATH": f"{self.bin}:{os.environ['PATH']}",
                                   "FAKE_SLURM": str(record)})
        jobs = {}
        for file in sorted(record.iterdir(), key=lambda f: int(f.name)):
            name, options, text = eval(file.read_text())
            jobs[name] = {**options, "number": file.name, "script": text}
        return jobs, done
