"""`python -m runtime`: see `runtime.cli.app`."""

from codegen.termination_signals import take_over

if __name__ == "__main__":
    take_over()  # before anything that takes time

    from runtime.cli.app import main

    main()
