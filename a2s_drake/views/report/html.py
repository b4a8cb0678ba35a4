"""HTML: what the report's page is made of."""

import base64
from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path
from string import Template

PAGE = Template("""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>a2s_drake: the paper reproduced</title>
<style>
:root { color-scheme: light; }
body { font: 16px/1.5 system-ui, sans-serif; color: #1a1a1a; margin: 0 auto; }
body { max-width: 74rem; padding: 1rem 1.2rem 4rem; }
h1 { font-size: 1.7rem; line-height: 1.2; } h2 { font-size: 1.25rem; margin-top: 2.6rem; }
p, li { max-width: 46rem; }
.headline { display: flex; flex-wrap: wrap; gap: .8rem; margin: 1.2rem 0; padding: 0; list-style: none; }
.headline li { border-left: 4px solid #0072B2; background: #f3f7fa; padding: .5rem 1rem; min-width: 13rem; }
.headline b { display: block; font-size: 1.5rem; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; font-size: .9rem; margin: .8rem 0; }
caption { text-align: left; font-weight: 600; padding-bottom: .3rem; }
th, td { padding: .25rem .7rem; border-bottom: 1px solid #ddd; text-align: right; vertical-align: top; }
.text { text-align: left; } td:not(.text), td:first-child { white-space: nowrap; }
.tables { display: flex; flex-wrap: wrap; gap: 0 3rem; align-items: start; } .tables > div { max-width: 100%; }
thead th { border-bottom: 2px solid #555; } tr.base td { font-weight: 600; background: #f3f7fa; }
.figures { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(21rem, 100%), 1fr)); gap: 1.4rem; }
figure { margin: 0; } figure img { width: 100%; height: auto; }
figcaption { font-size: .85rem; color: #444; }
footer { margin-top: 3rem; font-size: .85rem; color: #555; }
</style>
</head>
<body>
$body
</body>
</html>
""")


def table(
    caption: str, head: Sequence[str], rows: Sequence[Sequence[str]], *, text: int = 1, bold: Sequence[int] = ()
) -> str:
    """An HTML table; the first `text` columns are words, the rows numbered in `bold` stand out."""

    def line(cells: Sequence[str], tag: str) -> str:
        return "".join(
            f'<{tag} class="text">{escape(cell)}</{tag}>' if column < text else f"<{tag}>{escape(cell)}</{tag}>"
            for column, cell in enumerate(cells)
        )

    body = "\n".join(
        f"<tr{' class=base' if index in bold else ''}>{line(row, 'td')}</tr>" for index, row in enumerate(rows)
    )
    return (
        f'<div class="scroll"><table><caption>{escape(caption)}</caption>\n'
        f"<thead><tr>{line(head, 'th')}</tr></thead>\n<tbody>\n{body}\n</tbody></table></div>"
    )


def figures(captions: Mapping[str, str], folder: Path, names: Sequence[str]) -> str:
    """Figures by name, each numbered as its caption stands in order; their SVGs lie in the folder."""
    blocks = []
    for name in names:
        data = base64.b64encode((folder / f"{name}.svg").read_bytes()).decode()
        number = list(captions).index(name) + 1
        blocks.append(
            f'<figure id="{name}"><img alt="{escape(captions[name])}" src="data:image/svg+xml;base64,{data}">'
            f"<figcaption>Fig. {number}. {escape(captions[name])}</figcaption></figure>"
        )
    return '<div class="figures">\n' + "\n".join(blocks) + "\n</div>"
