"""What the README and the pages of docs/ tell a reader to type, found in their text."""

import re
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]


@dataclass(frozen=True)
class CodeBlock:
    """A fenced block, with the HTML comment on the line above it."""

    page: str
    language: str
    text: str
    comment: str


def code_blocks(page: Path) -> list[CodeBlock]:
    pattern = re.compile(r"^(?:<!-- ([^\n]*) -->\n)?```(\w*)[^\n]*\n(.*?)^```$", re.MULTILINE | re.DOTALL)
    name = str(page.relative_to(ROOT))
    return [CodeBlock(name, m[2], m[3], m[1] or "") for m in pattern.finditer(page.read_text(encoding="utf-8"))]


def commands(block: CodeBlock) -> list[str]:
    """The commands of an `sh` block, without their comments."""
    return [command for line in block.text.splitlines() if (command := re.sub(r"\s+#.*", "", line).strip())]


def inline_commands(page: Path) -> list[str]:
    """Words in backticks that look like something to type: `make run`, `.venv/bin/...`, `scripts/name.py ...`."""
    text = re.sub(r"^```.*?^```$", "", page.read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL)
    spans = (" ".join(span.split()) for span in re.findall(r"`([^`]+)`", text))
    return [s for s in spans if re.match(r"make [a-z]|\.venv/bin/|(\.venv/bin/python )?scripts/\w+\.py ", s)]
