"""What the end-to-end scripts share: running our executables and counting what went wrong.

Usage of each script: NAME_test.py BIN_FOLDER. Exit 77 (skipped for ctest) if it holds no executables.
"""
import json
import os
import pathlib
import resource
import signal
import subprocess
import sys
import tempfile

SOURCE = pathlib.Path(__file__).resolve().parents[2]
SHARED = pathlib.Path(os.environ.get("SLIM_SHARED") or SOURCE.parent / "shared")


class Result:
    def __init__(self, code, out, err, peak_bytes):
        self.code, self.out, self.err, self.peak_bytes = code, out, err, peak_bytes

    def json(self):
        """Stdout as the one JSON object it must be."""
        lines = self.out.strip().splitlines()
        assert len(lines) == 1, f"expected one line on stdout, found {len(lines)}: {self.out[:300]}"
        return json.loads(lines[0])


class Harness:
    def __init__(self, *needed):
        if len(sys.argv) < 2:
            sys.exit(f"usage: {sys.argv[0]} BIN_FOLDER")
        self.bin = pathlib.Path(sys.argv[1]).resolve()
        for name in needed:
            if not (self.bin / name).exists():
                print(f"skipped: {self.bin / name} is not built")
                sys.exit(77)
        # A script's `&` has SIGINT ignored, nohup SIGHUP, which our programs would inherit and obey.
        signal.signal(signal.SIGINT, signal.default_int_handler)
        signal.signal(signal.SIGHUP, signal.SIG_DFL)
        self._folder = tempfile.TemporaryDirectory(prefix="slim_e2e_")
        self.folder = pathlib.Path(self._folder.name)
        self.failures = 0
        self.checks = 0

    def run(self, program, *arguments, seconds=60, memory=None, env=None, stdout=subprocess.PIPE):
        """Runs bin/program; a time-out is exit code -1. `memory` bounds the address space."""
        def limit():
            if memory:
                resource.setrlimit(resource.RLIMIT_AS, (memory, memory))
        command = [str(self.bin / program), *map(str, arguments)]
        child = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=stdout,
                                 stderr=subprocess.PIPE, preexec_fn=limit, cwd=self.folder,
                                 env={**os.environ, **(env or {})})
        try:
            out, err = child.communicate(timeout=seconds)
            code = child.returncode
        except subprocess.TimeoutExpired:
            child.kill()
            out, err = child.communicate()
            code = -1
        return Result(code, (out or b"").decode(errors="replace"), err.decode(errors="replace"),
                      resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss * 1024)

    def check(self, true, what):
        self.checks += 1
        if not true:
            self.failures += 1
            print("FAILED:", what)
        return true

    def end(self):
        print(f"{self.checks} checks, {self.failures} failed")
        sys.exit(1 if self.failures or not self.checks else 0)
