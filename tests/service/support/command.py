"""The command ``whipple`` in this process, and what it prints."""

import sys
from unittest.mock import patch

import pytest

from service.cli import main as cli


def run(*arguments: object) -> int:
    """Run the command; its exit status."""
    with patch.object(sys, "argv", ["whipple", *map(str, arguments)]), pytest.raises(SystemExit) as ended:
        cli.main()
    return int(ended.value.code or 0)
