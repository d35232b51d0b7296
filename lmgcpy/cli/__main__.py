"""``python -m lmgcpy.cli``: the command line without the installed script."""

import sys

from lmgcpy.cli import main

sys.exit(main())
