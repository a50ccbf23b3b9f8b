"""`python -m vividc`: the command line."""

from vividc_main import main

if __name__ == "__main__":
    main()
