"""``python -m lmgcpy.cli``, the command line without its script."""

import sys

from lmgcpy.cli import main

sys.exit(main())
