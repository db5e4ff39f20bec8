"""``python -m codegen``."""

from codegen.termination_signals import take_over

if __name__ == "__main__":
    take_over()  # before anything that takes time

    from codegen.cli import main

    main()
