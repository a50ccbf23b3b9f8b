"""`python -m vividc`: the command line."""

from vividc.cli.main import main

if __name__ == "__main__":
    main(prog_name="vividc")
