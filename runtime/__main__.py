"""`python -m runtime`: see `runtime.cli.app`."""

from runtime.cli.app import main

if __name__ == "__main__":
    main()
