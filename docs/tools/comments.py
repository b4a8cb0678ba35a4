"""Comments beside assignments, which say what a field or a constant is; the pages show them as documentation."""

import ast


def _target(node: ast.AST) -> str | None:
    """The name that a plain assignment sets."""
    if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
        return node.target.id
    if isinstance(node, ast.Assign) and len(node.targets) == 1 and isinstance(node.targets[0], ast.Name):
        return node.targets[0].id
    return None


def _above(lines: list[str], first: int) -> str:
    top = first
    while top > 0 and lines[top - 1].lstrip().startswith("#"):
        top -= 1
    return " ".join(line.strip().lstrip("#").strip() for line in lines[top:first])


def _behind(line: str, column: int) -> str:
    # The syntax tree counts columns in bytes.
    comment = line.encode()[column:].decode().strip()
    return comment.lstrip("#").strip() if comment.startswith("#") and "noqa" not in comment else ""


def assignment_comments(source: str) -> dict[str, str]:
    """What each assigned name of a module is, and, as `Class.field`, each field of its classes.

    A field without a comment above shares that of the field before it, as the two ends of a range do; a comment behind
    the field, its unit mostly, follows in parentheses.
    """
    lines = source.splitlines()
    found: dict[str, str] = {}

    def collect(body: list[ast.stmt], prefix: str, *, share: bool) -> None:
        shared = ""
        for node in body:
            if isinstance(node, ast.ClassDef):
                collect(node.body, f"{node.name}.", share=True)
            name = _target(node)
            if name is None or node.end_lineno is None or node.end_col_offset is None:
                continue
            shared = _above(lines, node.lineno - 1) or (shared if share else "")
            behind = _behind(lines[node.end_lineno - 1], node.end_col_offset)
            found[prefix + name] = f"{shared} ({behind})" if shared and behind else shared or behind

    collect(ast.parse(source).body, "", share=False)
    return found
