"""`python -m tendril` is the command."""

import os
import sys

from ._command import command_path

command = command_path()
os.execv(command, ["tendril", *sys.argv[1:]])
