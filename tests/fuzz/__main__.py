"""The command of all campaigns: ``python -m tests.fuzz declarations --count 100000 --seed 1``."""

import runpy
import sys

if __name__ == "__main__":
    if len(sys.argv) < 2 or sys.argv[1] not in ("declarations", "calls", "model_files"):
        sys.exit("python -m tests.fuzz {declarations,calls,model_files} [options]")
    name = sys.argv.pop(1)
    runpy.run_module(f"tests.fuzz.{name}", run_name="__main__", alter_sys=True)
