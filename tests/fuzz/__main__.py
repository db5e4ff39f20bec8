"""The command of all campaigns: ``python -m tests.fuzz declarations --count 100000 --seed 1``."""

import sys

from tests.fuzz import campaign

GENERATORS = ("declarations", "calls", "model_files", "command_lines")

if __name__ == "__main__":
    if len(sys.argv) < 2 or sys.argv[1] not in GENERATORS:
        sys.exit(f"python -m tests.fuzz {{{','.join(GENERATORS)}}} [options]")
    sys.exit(campaign.main(sys.argv.pop(1)))
