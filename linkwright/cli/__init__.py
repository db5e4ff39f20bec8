"""The command line, one application under all names of the program."""
