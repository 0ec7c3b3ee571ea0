"""Write tests/seconds.toml, by which tests are ordered, from what the last runs of the tests took.

`python -m bench.seconds` reads the core-seconds that each run of pytest leaves in out/core-seconds, and sums
them by tier and group. Groups of less than a core-second are left out. A tier that was not run stays as is.
Remove that folder first where tests have gone or have other names.
"""

from __future__ import annotations

import json
import tomllib
from collections import Counter

from tests.tiers import MEASURED, SECONDS, TIERS

HEAD = "# What groups of tests take, core-seconds: `python -m bench.seconds` writes it from the last runs.\n"


def main() -> None:
    tables = tomllib.loads(SECONDS.read_text("utf-8"))
    for tier in TIERS:
        if (path := MEASURED / f"{tier}.json").exists():
            groups = Counter[str]()
            for name, spent in json.loads(path.read_text("utf-8")).items():
                groups[name.rpartition("@")[2]] += spent
            tables[tier] = {group: round(spent) for group, spent in groups.most_common() if spent >= 1}
    parts = [HEAD]
    for tier, groups in tables.items():
        parts.append(
            "\n".join([f"[{tier}]", *(f"{json.dumps(group)} = {spent}" for group, spent in groups.items())])
        )
    SECONDS.write_text("\n\n".join(parts) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
