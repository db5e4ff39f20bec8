"""`python -m codegen`, as the command `linkwright`; the working folder is put last."""

import os
import sys

if __name__ == "__main__":
    if not sys.flags.safe_path and sys.path[:1] == [os.getcwd()]:  # noqa: PTH109 (no import)
        sys.path.append(sys.path.pop(0))
    from linkwright.command_line import main

    main("python -m codegen")
