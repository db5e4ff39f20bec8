"""`python -m runtime`: see `runtime.cli.app`; the working folder is put last, as in `codegen`."""

import os
import sys

if __name__ == "__main__":
    if not sys.flags.safe_path and sys.path[:1] == [os.getcwd()]:  # noqa: PTH109 (no import)
        sys.path.append(sys.path.pop(0))
    from codegen.termination_signals import take_over

    take_over()  # before anything that takes time
    from runtime.cli.app import main

    main()
