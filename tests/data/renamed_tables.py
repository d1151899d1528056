"""Compares tables of an earlier version with new ones: every cell is the same, and names of columns alone differ. The new
tables may have more columns.

python3 tests/data/renamed_tables.py OLD NEW

OLD and NEW have a folder of tables for each study. The names are those of crates/engine/src/key/docs.rs.
"""

import csv
import re
import sys
from pathlib import Path

SOURCE = Path(__file__).parents[2] / "crates/engine/src/key/docs.rs"
NAMES = dict(re.findall(r'\("([\w-]+)", "([\w-]+)"\)', SOURCE.read_text().split("];")[0]))

# Words in cells of text.
CELLS = [("identified in", "detected in"), ("not identifiable", "not estimable")]


def renamed(name):
    if name in NAMES:
        return NAMES[name]
    return "".join(NAMES.get(part, part) for part in re.split(r"([._])", name))


def worded(cell):
    for former, present in CELLS:
        cell = cell.replace(former, present)
    return cell


def main(old, new):
    cells = files = columns = 0
    for before in sorted(Path(old).glob("*/*.csv")):
        folder = Path(new) / renamed(before.parent.name.replace("randomisation", "randomization").replace("quantiser", "quantizer"))
        after = folder / before.name
        rows, found = (list(csv.reader(path.read_text().splitlines())) for path in (before, after))
        names = [renamed(name) for name in rows[0]]
        places = [found[0].index(name) for name in names]
        columns += sum(a != b for a, b in zip(rows[0], names))
        for at, (a, b) in enumerate(zip(rows[1:], found[1:], strict=True)):
            own = [b[place] for place in places]
            different = [f"{name} {y}, not {x}" for name, x, y in zip(names, map(worded, a), own) if x != y]
            if different:
                print(f"{after}, row {at}: {'; '.join(different[:3])}")
                break
        files += 1
        cells += sum(len(row) for row in rows[1:])
    print(f"{files} tables, {cells} cells: the same but for {columns} renamed columns")


main(*sys.argv[1:])
