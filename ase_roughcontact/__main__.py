"""The command ``ase-roughcontact`` as ``python -m ase_roughcontact``."""

import sys

from ase_roughcontact.cli import main

if __name__ == "__main__":
    sys.exit(main())
