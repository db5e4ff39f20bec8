"""``python -m codegen``.

`python -m` looks for modules in the working folder first. A model file there may bear the name of
a module that the compiler needs, so that the folder is put last before anything is imported.
"""

import os
import sys

if __name__ == "__main__":
    if not sys.flags.safe_path and sys.path[:1] == [os.getcwd()]:  # noqa: PTH109 (no import)
        sys.path.append(sys.path.pop(0))
    from codegen.termination_signals import take_over

    take_over()  # before anything that takes time
    from codegen.cli import main

    main()
