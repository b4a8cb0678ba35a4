"""Summary: how many cases of each kind ended in which way."""

from collections.abc import Mapping

from scripts.trial.verdict import FAULT, FLOWN, REFUSED, SENTENCE

_ENDINGS = (FLOWN, REFUSED, SENTENCE, FAULT)


def summary_table(counts: Mapping[tuple[str, str], int]) -> str:
    """Cases by kind and ending, from counts by (kind, ending), one kind a line and their sum last."""
    kinds = list(dict.fromkeys(kind for kind, _ in counts))
    rows = {kind: [counts.get((kind, ending), 0) for ending in _ENDINGS] for kind in sorted(kinds, reverse=True)}
    rows["all"] = [sum(column) for column in zip(*rows.values(), strict=True)]
    width = max(map(len, rows))
    lines = [f"{'':{width}}  {'  '.join(_ENDINGS)}"]
    for kind, row in rows.items():
        lines.append(f"{kind:{width}}  {'  '.join(f'{n:{len(name)}}' for n, name in zip(row, _ENDINGS, strict=True))}")
    return "\n".join(lines)
